// Episodes of a recording: sticking, break-away, rest against an end stop.

import type { Recording } from "./record";

/** Times in s. */
export interface Episodes {
  sticking: [number, number][];
  breakAways: number[];
  stops: [number, number][];
}

/** The episodes from a row of a recording on, for a stroke in m. */
export function episodes(recording: Recording, first: number, stroke: number, prefix = ""): Episodes {
  const column = (name: string) => recording.column(name, first);
  const [time, position, sticking] = [column("time"), column(`${prefix}position`), column(`${prefix}sticking`)];
  const held = intervals(time, (row) => sticking[row] === 1);
  return {
    sticking: held,
    // The last interval goes on, unless the carriage slides in the last row.
    breakAways: held.map(([, end]) => end).filter((_, index) => index < held.length - 1 || sticking.at(-1) !== 1),
    stops: intervals(time, (row) => position[row] <= 0 || position[row] >= stroke),
  };
}

/** The intervals of time in whose rows something holds; each ends at the first row in which it no longer does. */
function intervals(time: Float64Array, holds: (row: number) => boolean): [number, number][] {
  const found: [number, number][] = [];
  let begin = -1;
  for (let row = 0; row <= time.length; row += 1) {
    const isOn = row < time.length && holds(row);
    if (isOn && begin < 0) begin = row;
    if (isOn || begin < 0) continue;
    found.push([time[begin], time[Math.min(row, time.length - 1)]]);
    begin = -1;
  }
  return found;
}

/** The share of a velocity's range by which it may change from row to row of a path; a bounce changes it by more. */
const JUMP = 0.15;

/** A velocity without the rows after which it jumps, so that a path over it has a gap there and no chord. */
export function withoutJumps(velocity: Float64Array): Float64Array {
  let [low, high] = [0, 0];
  for (const value of velocity) [low, high] = [Math.min(low, value), Math.max(high, value)];
  const limit = JUMP * (high - low);
  return velocity.map((value, row) => (row + 1 < velocity.length && Math.abs(velocity[row + 1] - value) > limit ? NaN : value));
}
