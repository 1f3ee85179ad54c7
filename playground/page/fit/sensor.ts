// A sensor: how likely its readings are if a simulation is true, as in the Python package.

import { extremes, joined, line, median } from "./arrays";
import { logNormal } from "./normal";
import { noise } from "./smoothing";

/** Noise of so many steps of a converter hides it: the sum of both is as good as normal. */
const COARSE = 2;
/** Noise is not looked for below this share of the step of a converter. */
const FINEST = 0.02;
/** Noise in SI units below which no sensor is taken for. */
const LEAST = 1e-12;
/** Values that leave a lattice by more than this share of its step were not made by a converter. */
const ON_LATTICE = 0.1;

/**
 * Normal noise, and perhaps a converter that rounds. The rounding errors of a carriage at rest are all the same, so that
 * least squares would take them for motion. A reading of a coarse converter says only between which two values the noisy
 * signal was: P(d) = Phi((d + step/2)/noise) - Phi((d - step/2)/noise), with d the reading less the simulation.
 */
export class Sensor {
  constructor(
    readonly noise: number,
    readonly step = 0,
    readonly isCoarse = false,
  ) {}

  /** Noise and rounding together, and the converter, from measured courses of a signal. */
  static of(courses: Float64Array[]): Sensor {
    const ends = courses.flatMap(extremes);
    const magnitude = Math.max(...ends.map(Math.abs));
    return new Sensor(Math.max(median(courses.map(noise)), 1e-9 * magnitude, LEAST), converter(joined(courses)));
  }

  /** The sensor whose noise makes differences most likely. */
  withNoiseOf(differences: Float64Array): Sensor {
    let squares = 0;
    for (const difference of differences) squares += difference * difference;
    const rms = Math.max(Math.sqrt(squares / differences.length), LEAST);
    if (rms >= COARSE * this.step) return new Sensor(rms, this.step, false);
    const cost = (logarithm: number) => {
      const sensor = new Sensor(Math.exp(logarithm), this.step, true);
      let total = 0;
      for (const difference of differences) total -= sensor.logLikelihood(difference);
      return total;
    };
    const found = least(cost, Math.log(FINEST * this.step), Math.log(COARSE * this.step), 0.01);
    return new Sensor(Math.exp(found), this.step, true);
  }

  /** What least squares may add up: the signed root of twice what the logarithm of P lacks to its best. */
  residuals(differences: Float64Array): Float64Array {
    if (!this.isCoarse) return differences.map((difference) => difference / this.noise);
    const best = this.logLikelihood(0);
    return differences.map(
      (difference) => Math.sign(difference) * Math.sqrt(2 * Math.max(best - this.logLikelihood(difference), 0)),
    );
  }

  /** The derivatives of the residuals. */
  slopes(differences: Float64Array): Float64Array {
    if (!this.isCoarse) return new Float64Array(differences.length).fill(1 / this.noise);
    const residuals = this.residuals(differences);
    // Next to its middle the residual is as straight as anything; the quotient is not.
    const near = 1e-3 * this.noise;
    const straight = this.residuals(Float64Array.of(near))[0] / near;
    return differences.map((difference, index) =>
      Math.abs(difference) > near ? -this.score(difference) / residuals[index] : straight,
    );
  }

  /** The slopes of the logarithm of P against the simulation, in units of the weights: of variance 1. */
  scores(differences: Float64Array): Float64Array {
    if (!this.isCoarse) return differences.map((difference) => difference / this.noise);
    const weights = this.weights(differences);
    return differences.map((difference, index) => -this.score(difference) / weights[index]);
  }

  /** The roots of the information that a reading is expected to have about what is simulated. */
  weights(differences: Float64Array): Float64Array {
    if (!this.isCoarse) return new Float64Array(differences.length).fill(1 / this.noise);
    const reach = Math.ceil((6 * this.noise) / this.step) + 1;
    return differences.map((difference) => {
      // What the simulation is off the nearest value that the converter has: all readings are expected from there.
      const offset = difference - this.step * Math.round(difference / this.step);
      let information = 0;
      for (let reading = -reach; reading <= reach; reading += 1) {
        const shifted = offset + this.step * reading;
        information += Math.exp(this.logLikelihood(shifted)) * this.score(shifted) ** 2;
      }
      return Math.sqrt(Math.max(information, (1e-6 / this.noise) ** 2));
    });
  }

  /** The ends of the range that a reading stands for, in units of the noise, as P sees them: it is even. */
  private ends(difference: number): [number, number] {
    const [half, distance] = [0.5 * this.step, Math.abs(difference)];
    return [(half - distance) / this.noise, (-half - distance) / this.noise];
  }

  private logLikelihood(difference: number): number {
    const [high, low] = this.ends(difference).map(logNormal);
    return high + Math.log1p(-Math.exp(low - high));
  }

  /** The derivative of the logarithm of P. */
  private score(difference: number): number {
    const [upper, lower] = this.ends(difference);
    const likelihood = this.logLikelihood(difference) + 0.5 * Math.log(2 * Math.PI);
    const size = (Math.exp(-0.5 * upper ** 2 - likelihood) - Math.exp(-0.5 * lower ** 2 - likelihood)) / this.noise;
    return -Math.sign(difference) * size;
  }
}

/** The step of the converter whose lattice the values lie on; 0 if they lie on none. */
export function converter(values: Float64Array): number {
  const sorted = Float64Array.from(values).sort();
  const levels = sorted.filter((value, index) => index === 0 || value !== sorted[index - 1]);
  if (levels.length < 2) return 0;
  let smallest = Infinity;
  for (let index = 1; index < levels.length; index += 1) smallest = Math.min(smallest, levels[index] - levels[index - 1]);
  let number = 0;
  const numbers = levels.map((level, index) => (number += index ? Math.round((level - levels[index - 1]) / smallest) : 0));
  const [step, first] = line(numbers, levels);
  const isOn = levels.every((level, index) => Math.abs(level - first - step * numbers[index]) < ON_LATTICE * step);
  return isOn ? step : 0;
}

/** Where a function with one hollow is least, by golden sections. */
export function least(of: (x: number) => number, low: number, high: number, within: number): number {
  const share = (Math.sqrt(5) - 1) / 2;
  let [a, b] = [low, high];
  let [c, d] = [b - share * (b - a), a + share * (b - a)];
  let [atC, atD] = [of(c), of(d)];
  while (b - a > within) {
    if (atC < atD) {
      [b, d, atD] = [d, c, atC];
      c = b - share * (b - a);
      atC = of(c);
    } else {
      [a, c, atC] = [c, d, atD];
      d = a + share * (b - a);
      atD = of(d);
    }
  }
  return 0.5 * (a + b);
}
