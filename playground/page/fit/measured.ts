// Records: measured signals over time without gaps, ready to be compared.

import { differences, interpolate, median } from "./arrays";
import type { Signal } from "./signals";

/** Intervals longer than so many usual ones, and than so many s, split a record. */
const GAP = 5;
const LOST = 0.02;
/** Samples without which a record tells too little. */
const SHORTEST = 50;

export type Signals = ReadonlyMap<Signal, Float64Array>;

/** What is wrong with data or choices, in words for the visitor. */
export class FitError extends Error {}

/** Signals in SI units, sampled without gaps; times from 0. */
export class Measured {
  /** The usual interval between samples in s. */
  readonly step: number;
  /** Communication points of a simulation. */
  readonly grid: Float64Array;

  constructor(
    readonly time: Float64Array,
    /** Time in s of the table that is 0 here. */
    readonly begin: number,
    readonly signals: Signals,
    step?: number,
  ) {
    this.step = step ?? median(differences(time));
    const points = Math.floor(time[time.length - 1] / this.step + 1e-6) + 1;
    this.grid = Float64Array.from({ length: points }, (_, point) => point * this.step);
  }

  of(signal: Signal): Float64Array {
    const found = this.signals.get(signal);
    if (!found) throw new Error(`the record has no ${signal}`);
    return found;
  }

  /** A signal at the communication points, on straight lines between its samples. */
  onGrid(signal: Signal): Float64Array {
    return interpolate(this.grid, this.time, this.of(signal));
  }

  /** The samples from one index up to another. */
  part(first: number, last: number): Measured {
    const start = this.time[first];
    const signals = new Map([...this.signals].map(([name, values]) => [name, values.subarray(first, last)]));
    return new Measured(this.time.slice(first, last).map((time) => time - start), this.begin + start, signals);
  }
}

/** Splits signals at gaps; returns the records, and what was left out. */
export function split(name: string, signals: Signals): { records: Measured[]; notes: string[] } {
  const time = signals.get("time") as Float64Array;
  if (time.length < 2) throw new FitError(`${name}: too short, a single sample`);
  const others = new Map([...signals].filter(([signal]) => signal !== "time"));
  const start = time[0];
  const whole = new Measured(time.map((value) => value - start), start, others);
  const intervals = differences(time);
  const long = Math.max(GAP * median(intervals), LOST);
  const ends = [0];
  intervals.forEach((interval, index) => {
    if (interval > long) ends.push(index + 1);
  });
  ends.push(time.length);
  const pieces = ends.slice(1).map((last, index) => [ends[index], last] as const);
  const used = pieces.filter(([first, last]) => last - first >= SHORTEST);
  if (!used.length) {
    const most = Math.max(...pieces.map(([first, last]) => last - first));
    throw new FitError(`${name}: too short, ${most} samples without a gap; at least ${SHORTEST} are needed`);
  }
  const left = pieces.length - used.length;
  const notes = pieces.length > 1 ? [`split at ${pieces.length - 1} gaps, ${left} pieces too short to use`] : [];
  return { records: pieces.length > 1 ? used.map(([first, last]) => whole.part(first, last)) : [whole], notes };
}
