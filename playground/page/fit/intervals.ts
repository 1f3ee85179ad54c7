// How sure the values are: 95 % intervals, and what the data do not determine.

import { Matrix } from "ml-matrix";
import { isLogarithmic, outer } from "./free";
import { pseudoInverse, singular, triangle } from "./matrix";
import { student } from "./normal";
import type { Problem } from "./problem";
import { sensitivities } from "./sensitivities";

/** Stretches of time that count as independent. */
const BLOCKS = 20;
/** Singular values below this share of the largest are no information. */
const RANK = 1e-7;
const LEVEL = 0.95;

export interface Certainty {
  low: Float64Array;
  high: Float64Array;
  /** Why the data do not determine a parameter, by name. */
  undetermined: Map<string, string>;
}

/**
 * The wider of two: that of independent residuals, and that of a jackknife which leaves out one block of time after the other,
 * for residuals that hang together.
 */
export function certainty(problem: Problem, x: Float64Array): Certainty {
  const base = problem.differences(x);
  const { columns } = sensitivities(problem, x, base, true);
  const weights = problem.bySensor((sensor, own) => sensor.weights(own), base);
  const every = columns.map((column) => column.map((value, row) => value * weights[row]));
  const scores = problem.bySensor((sensor, own) => sensor.scores(own), base);
  const count = problem.free.length;
  const own = without(every.slice(0, count), every.slice(count));
  const inverse = pseudoInverse(triangle(own), RANK);
  const deviation = inverse.to2DArray().map((row) => Math.hypot(...row));
  const half = deviation.map((value) => value * student(LEVEL, Math.max(1, scores.length - count)));
  const labels = blocks(problem);
  const groups = labels.reduce((most, label) => Math.max(most, label + 1), 0);
  if (groups >= count + 2) {
    const factor = student(LEVEL, groups - 1);
    jackknife(own, scores, labels, groups).forEach((value, index) => (half[index] = Math.max(half[index], factor * value)));
  }
  const isBlind = blind(own);
  isBlind.forEach((is, index) => (half[index] = is ? Infinity : half[index]));
  const ends = problem.free.map((free, index) => [-1, 1].map((side) => outer(free, x[index] + side * half[index])));
  return {
    low: Float64Array.from(ends, ([low]) => low),
    high: Float64Array.from(ends, ([, high]) => high),
    undetermined: undetermined(problem, x, half, isBlind),
  };
}

/** What is left of columns when others take all that they can of them: when the windows begin as suits them best. */
function without(columns: Float64Array[], others: Float64Array[]): Float64Array[] {
  const basis: Float64Array[] = [];
  for (const other of others) {
    // Twice is enough for all digits.
    const rest = reduced(reduced(other, basis), basis);
    const norm = Math.sqrt(dot(rest, rest));
    if (norm > 1e-12 * Math.sqrt(dot(other, other))) basis.push(rest.map((value) => value / norm));
  }
  return columns.map((column) => reduced(reduced(column, basis), basis));
}

function reduced(column: Float64Array, basis: Float64Array[]): Float64Array {
  const rest = column.slice();
  for (const direction of basis) {
    const share = dot(rest, direction);
    for (let row = 0; row < rest.length; row += 1) rest[row] -= share * direction[row];
  }
  return rest;
}

function dot(a: Float64Array, b: Float64Array): number {
  let total = 0;
  for (let row = 0; row < a.length; row += 1) total += a[row] * b[row];
  return total;
}

/** The deviations that show in how the parameters move as one group of samples after the other is left out. */
function jackknife(columns: Float64Array[], scores: Float64Array, labels: Int32Array, groups: number): number[] {
  const count = columns.length;
  const information = Array.from({ length: groups }, () => Matrix.zeros(count, count));
  const slopes = Array.from({ length: groups }, () => Matrix.zeros(count, 1));
  for (let row = 0; row < scores.length; row += 1) {
    const [matrix, slope] = [information[labels[row]], slopes[labels[row]]];
    for (let i = 0; i < count; i += 1) {
      const value = columns[i][row];
      slope.set(i, 0, slope.get(i, 0) + value * scores[row]);
      for (let j = 0; j < count; j += 1) matrix.set(i, j, matrix.get(i, j) + value * columns[j][row]);
    }
  }
  const whole = information.reduce((total, matrix) => total.add(matrix), Matrix.zeros(count, count));
  const squares = new Array<number>(count).fill(0);
  information.forEach((matrix, group) => {
    const move = pseudoInverse(Matrix.sub(whole, matrix), RANK ** 2).mmul(slopes[group]);
    for (let index = 0; index < count; index += 1) squares[index] += move.get(index, 0) ** 2;
  });
  return squares.map((square) => Math.sqrt((square * (groups - 1)) / groups));
}

/** The number of the block of each sample: stretches of time, all signals of a stretch together. */
function blocks(problem: Problem): Int32Array {
  const counts = problem.windows.map((window) => problem.fitted(window));
  const total = counts.reduce((all, count) => all + count, 0);
  const size = Math.max(1, Math.ceil(total / BLOCKS));
  const isWhole = counts.length >= BLOCKS;
  let before = 0;
  const labels = counts.flatMap((count) => {
    const inside = Int32Array.from({ length: count }, (_, row) => Math.floor((before + (isWhole ? 0 : row)) / size));
    before += count;
    return problem.experiment.compared.map(() => inside);
  });
  return numbered(labels);
}

/** Labels one after the other, as numbers without gaps. */
function numbered(parts: Int32Array[]): Int32Array {
  const numbers = new Map<number, number>();
  const all = new Int32Array(parts.reduce((length, part) => length + part.length, 0));
  let place = 0;
  for (const part of parts) {
    for (const label of part) {
      if (!numbers.has(label)) numbers.set(label, numbers.size);
      all[place++] = numbers.get(label) ?? 0;
    }
  }
  return all;
}

/** Which parameters take part in a direction that the residuals do not see, as they are scaled and by their own effects. */
function blind(columns: Float64Array[]): boolean[] {
  const norms = columns.map((column) => Math.sqrt(dot(column, column)) || 1);
  const scaled = columns.map((column, index) => column.map((value) => value / norms[index]));
  const [one, other] = [columns, scaled].map(unseen);
  return one.map((is, index) => is || other[index]);
}

function unseen(columns: Float64Array[]): boolean[] {
  const { values, right } = singular(triangle(columns));
  const largest = Math.max(...values);
  return columns.map((_, row) =>
    largest === 0 || values.some((value, direction) => value < RANK * largest && Math.abs(right.get(row, direction)) > 0.1),
  );
}

function undetermined(problem: Problem, x: Float64Array, half: number[], isBlind: boolean[]): Map<string, string> {
  const reasons = new Map<string, string>();
  const { low, high } = problem.bounds;
  problem.free.forEach((free, index) => {
    const [value, reach] = [x[index], half[index]];
    if (isBlind[index] || !Number.isFinite(reach)) {
      reasons.set(free.name, "the data do not change with it, or only with a combination of parameters");
    } else if (Number.isFinite(high[index] - low[index]) && value - reach <= low[index] && value + reach >= high[index]) {
      reasons.set(free.name, "its interval is wider than its bounds");
    } else if (isLogarithmic(free) && reach > 1) {
      reasons.set(free.name, "its interval is wider than from a third to three times its value");
    } else if (Math.min(value - low[index], high[index] - value) < 1e-6 * Math.max(1, Math.abs(value))) {
      reasons.set(free.name, "it is at a bound");
    }
  });
  return reasons;
}
