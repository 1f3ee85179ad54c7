// Derivatives of what is left of the data, by finite differences of runs.

import type { Problem } from "./problem";

/** Step of the differences, in scaled parameters. */
const STEP = 1e-3;

export interface Sensitivities {
  /** Derivatives of the differences: a column for each place of the vector. */
  columns: Float64Array[];
  /** The differences themselves. */
  base: Float64Array;
}

/**
 * Derivatives within the bounds. What windows begin with is moved in all of them together, since none sees that of another.
 * Where a law refuses one side, as sliding friction beyond what breaks away, the other one tells.
 */
export function sensitivities(problem: Problem, x: Float64Array, base: Float64Array, isCentral: boolean): Sensitivities {
  const free = problem.free.length;
  const slopes = moves(problem).map((move) => slope(problem, x, base, move, isCentral));
  const found: Float64Array[] = Array.from(x, () => new Float64Array(base.length));
  for (let index = 0; index < free; index += 1) found[index] = slopes[index];
  let [row, column] = [0, free];
  problem.windows.forEach((window, index) => {
    const last = row + problem.fitted(window) * problem.experiment.compared.length;
    for (let place = 0; place < problem.loose[index]; place += 1) {
      found[column].set(slopes[free + place].subarray(row, last), row);
      column += 1;
    }
    row = last;
  });
  return { columns: found, base };
}

/** The derivatives of the residuals. */
export function jacobian(problem: Problem, x: Float64Array, base: Float64Array, isCentral: boolean): Float64Array[] {
  const slopes = problem.bySensor((sensor, own) => sensor.slopes(own), base);
  const { columns } = sensitivities(problem, x, base, isCentral);
  return columns.map((column) => column.map((value, row) => finite(value * slopes[row])));
}

const finite = (value: number): number => (Number.isFinite(value) ? value : 0);

/** The places of the vector that are moved together: each parameter, and each kind of beginning in all windows. */
function moves(problem: Problem): number[][] {
  const free = problem.free.length;
  const kinds: number[][] = [];
  let place = free;
  for (const count of problem.loose) {
    for (let kind = 0; kind < count; kind += 1) (kinds[kind] ??= []).push(place++);
  }
  return [...Array.from({ length: free }, (_, index) => [index]), ...kinds];
}

function slope(problem: Problem, x: Float64Array, base: Float64Array, move: number[], isCentral: boolean): Float64Array {
  const { low, high } = problem.bounds;
  const moved = (by: number): { by: number; run: Float64Array } | null => {
    const other = x.slice();
    for (const index of move) other[index] = Math.min(Math.max(x[index] + by, low[index]), high[index]);
    const actual = other[move[0]] - x[move[0]];
    if (actual === 0) return null;
    const run = problem.differences(other);
    return run.every(Number.isNaN) ? null : { by: actual, run };
  };
  const above = moved(STEP);
  const below = isCentral || !above ? moved(-STEP) : null;
  const up = above ?? { by: 0, run: base };
  const down = below ?? { by: 0, run: base };
  if (up.by === down.by) return new Float64Array(base.length);
  return up.run.map((value, row) => finite((value - down.run[row]) / (up.by - down.by)));
}
