// What is done to measured signals before they are used.

import { differences, extremes, median, mean } from "./arrays";

/**
 * The standard deviation of white noise and of quantisation, from third differences, which motion leaves: the sum of the
 * squares of 1, 3, 3, 1 is 20, and 0.6745 the median of a normal distribution's magnitude. Where a signal mostly rests
 * between the steps of its converter, the length of a step tells.
 */
export function noise(values: Float64Array): number {
  if (values.length < 8) return 0;
  const first = differences(values);
  const third = differences(differences(first));
  const white = median(third.map(Math.abs)) / 0.6745 / Math.sqrt(20);
  const [least, most] = extremes(values);
  const small = 1e-12 * Math.max(1, Math.abs(least), Math.abs(most));
  let step = Infinity;
  for (const value of first) if (Math.abs(value) > small && Math.abs(value) < step) step = Math.abs(value);
  return Math.max(white, step === Infinity ? 0 : step / Math.sqrt(12));
}

/** How many samples a width in s has: an odd number, at least five. */
function samples(length: number, step: number, width: number): number {
  const number = Math.max(5, 2 * Math.round((0.5 * width) / step) + 1);
  return Math.min(number, length - 1 + (length % 2));
}

/** Values and slopes of the parabolas fitted about each of equidistant samples (Savitzky and Golay), over a width in s. */
export function parabolas(values: Float64Array, step: number, width: number): { smooth: Float64Array; slope: Float64Array } {
  const number = samples(values.length, step, width);
  const half = (number - 1) / 2;
  const squares = (half * (half + 1) * number) / 3;
  const middle = squares / number;
  let spread = 0;
  for (let k = -half; k <= half; k += 1) spread += (k * k - middle) ** 2;
  const [smooth, slope] = [new Float64Array(values.length), new Float64Array(values.length)];
  for (let index = 0; index < values.length; index += 1) {
    // At the ends the first and the last parabola hold.
    const centre = Math.min(Math.max(index, half), values.length - 1 - half);
    const window = values.subarray(centre - half, centre + half + 1);
    const level = mean(window);
    let [rise, bend] = [0, 0];
    for (let k = -half; k <= half; k += 1) {
      const value = window[k + half] - level;
      rise += k * value;
      bend += (k * k - middle) * value;
    }
    rise /= squares;
    bend /= spread;
    const off = index - centre;
    smooth[index] = level + rise * off + bend * (off * off - middle);
    slope[index] = (rise + 2 * bend * off) / step;
  }
  return { smooth, slope };
}

/** What follows a signal with a play: it rests while the signal stays within the play about it. */
export function follow(values: Float64Array, play: number): Float64Array {
  if (play <= 0) return values;
  let last = values[0];
  return values.map((value) => (last = Math.min(Math.max(last, value - play), value + play)));
}
