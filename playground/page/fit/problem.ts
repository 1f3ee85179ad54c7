// A problem: data, what is given, what is compared, what is free.

import { Refusal, type Library } from "../library";
import { interpolate, joined } from "./arrays";
import type { Experiment, Values, Window } from "./experiment";
import { bounds, inner, isLogarithmic, outer, type Free } from "./free";
import type { Measured } from "./measured";
import { Sensor } from "./sensor";
import type { Signal } from "./signals";
import { simulate } from "./simulate";

/** Relative tolerance of the solver at which differences of runs are differences of parameters. */
export const TOLERANCE = 1e-6;
/** Standard deviation, in logarithms, of how far a parameter is from its start: a factor of 4.5. */
const PULL = 1.5;
/** A run may take so many times the solver steps of the start; one that takes more is given up. */
const WORK = 20;
/** Residual, in units of the noise, where a simulation could not go on: worse than any of one that could. */
export const FAILED = 1e12;
/** What the changes of what a window begins with are measured in, in SI units. */
const MAGNITUDES: Record<string, number> = {
  position0: 1e-4,
  velocity0: 1e-2,
  "chamberA.pressure0": 1e3,
  "chamberB.pressure0": 1e3,
};

/** Is told of each run: the share of it that is done. */
export type Told = (share: number) => void;
type BySensor = (sensor: Sensor, differences: Float64Array) => Float64Array;

/**
 * The solver sees a vector of scaled parameters. After the free parameters it has what each window begins with, as far as
 * that was only measured: the first samples tell it no better than all others, and what it errs by would pass into the
 * parameters.
 */
export class Problem {
  constructor(
    readonly library: Library,
    readonly experiment: Experiment,
    readonly windows: readonly Window[],
    readonly free: readonly Free[],
    readonly sensors: ReadonlyMap<Signal, Sensor>,
    readonly told: Told = () => {},
    readonly tolerance = TOLERANCE,
    /** Solver steps after which a run is given up. */
    readonly most = Infinity,
  ) {}

  /** Records as windows, whose last share is held out. */
  static of(library: Library, experiment: Experiment, records: Measured[], free: Free[], holdOut: number, told: Told): Problem {
    const fixed = new Set([...experiment.known.keys(), ...free.map(({ name }) => name)]);
    const windows = records.map((record): Window => {
      const { driven, used } = experiment.prepare(record);
      const limit = holdOut > 0 ? record.time[record.time.length - 1] * (1 - holdOut) : Infinity;
      const held = Uint8Array.from(record.time, (time) => Number(time > limit));
      const { values, loose } = experiment.begin(record, driven);
      const begin = {
        values: new Map([...values].filter(([name]) => !fixed.has(name))),
        loose: loose.filter((name) => !fixed.has(name)),
      };
      return { record, driven, used, held, begin };
    });
    const sensors = new Map(
      experiment.compared.map((signal) => [signal, Sensor.of(records.map((record) => record.of(signal)))] as const),
    );
    return new Problem(library, experiment, windows, free, sensors, told);
  }

  with(other: Partial<Pick<Problem, "windows" | "free" | "sensors" | "tolerance" | "most">>): Problem {
    const { windows, free, sensors, tolerance, most } = { ...this, ...other };
    return new Problem(this.library, this.experiment, windows, free, sensors, this.told, tolerance, most);
  }

  /** The values of the free parameters by name. */
  values(x: Float64Array): Map<string, number> {
    return new Map(this.free.map((free, index) => [free.name, outer(free, x[index])]));
  }

  /** What each window begins with. */
  begins(x: Float64Array): Map<string, number>[] {
    let place = this.free.length;
    return this.windows.map(({ begin }) => {
      const values = new Map(begin.values);
      if (x.length > this.free.length) {
        for (const name of begin.loose) values.set(name, (values.get(name) ?? 0) + MAGNITUDES[name] * x[place++]);
      }
      return values;
    });
  }

  /** Samples of a window that are fitted. */
  fitted({ used, held }: Window): number {
    return used.reduce((number, isUsed, row) => number + (isUsed && !held[row] ? 1 : 0), 0);
  }

  /** Number of the residuals. */
  get size(): number {
    return this.windows.reduce((size, window) => size + this.fitted(window), 0) * this.experiment.compared.length;
  }

  /** How much of its beginning each window leaves free. */
  get loose(): number[] {
    return this.windows.map(({ begin }) => begin.loose.length);
  }

  get start(): Float64Array {
    const loose = this.loose.reduce((all, count) => all + count, 0);
    return Float64Array.of(...this.free.map((free) => inner(free, free.start)), ...new Array<number>(loose).fill(0));
  }

  get bounds(): { low: Float64Array; high: Float64Array } {
    const ends = this.start.map(() => Infinity);
    const [low, high] = [ends.map((end) => -end), ends];
    this.free.forEach((free, index) => ([low[index], high[index]] = bounds(free)));
    return { low, high };
  }

  /** The same problem without what is held out, which the fit need not simulate. */
  trained(): Problem {
    const cut = this.windows.flatMap((window) => cutOf(window) ?? []);
    return this.with({ windows: cut });
  }

  /** The same problem whose windows begin as a vector of the trained problem says; others as measured. */
  begun(trained: Problem, x: Float64Array): Problem {
    const begins = trained.begins(x);
    const windows = this.windows.map((window) => {
      if (!cutOf(window)) return window;
      return { ...window, begin: { ...window.begin, values: begins.shift() ?? window.begin.values } };
    });
    return this.with({ windows });
  }

  /** The same problem, in which runs are given up that take many times the work of the start; throws its refusal. */
  bounded(): Problem {
    const begins = this.begins(this.start);
    const values = this.values(this.start);
    const works = this.windows.map((window, index) => this.run(window, values, begins[index]).work);
    return this.with({ most: WORK * Math.max(...works, 1) });
  }

  /** Compared signals at the communication points, for each window; nothing where a run failed. */
  predictions(x: Float64Array): (Map<Signal, Float64Array> | null)[] {
    const [values, begins] = [this.values(x), this.begins(x)];
    return this.windows.map((window, index) => {
      try {
        const { outputs } = this.run(window, values, begins[index]);
        return this.experiment.predict(window, outputs, values);
      } catch (error) {
        if (!(error instanceof Refusal)) throw error;
        return null;
      }
    });
  }

  /** What the sensors would read at the samples; NaN where a run failed. */
  readings(x: Float64Array): Map<Signal, Float64Array>[] {
    const values = this.values(x);
    return this.predictions(x).map((predicted, index) => {
      const { record } = this.windows[index];
      return new Map(
        this.experiment.compared.map((signal) => {
          const course = predicted?.get(signal);
          if (!course) return [signal, new Float64Array(record.time.length).fill(NaN)] as const;
          return [signal, read(record, signal, course, values)] as const;
        }),
      );
    });
  }

  /** Measured less simulated at the fitted samples, window by window, in it signal by signal; NaN where a run failed. */
  differences(x: Float64Array): Float64Array {
    const all = new Float64Array(this.size);
    let place = 0;
    this.readings(x).forEach((readings, index) => {
      const { record, used, held } = this.windows[index];
      for (const signal of this.experiment.compared) {
        const [measured, seen] = [record.of(signal), readings.get(signal)!];
        for (let row = 0; row < measured.length; row += 1) {
          if (used[row] && !held[row]) all[place++] = measured[row] - seen[row];
        }
      }
    });
    return all;
  }

  /** What sensors make of differences. */
  bySensor(of: BySensor, differences: Float64Array): Float64Array {
    const all = new Float64Array(differences.length);
    let first = 0;
    for (const window of this.windows) {
      const count = this.fitted(window);
      for (const signal of this.experiment.compared) {
        all.set(of(this.sensors.get(signal)!, differences.subarray(first, first + count)), first);
        first += count;
      }
    }
    return all;
  }

  /** The residuals in units of the noise. */
  residuals(differences: Float64Array): Float64Array {
    const found = this.bySensor((sensor, own) => sensor.residuals(own), differences);
    return found.map((value) => (Number.isFinite(value) ? value : FAILED));
  }

  /**
   * What draws logarithms to their starts, as residuals. Too weak to be felt where the data tell a value, it keeps those
   * that they do not tell from going astray.
   */
  pulls(x: Float64Array): Float64Array {
    const { start, pull } = this;
    return x.map((value, index) => pull[index] * (value - start[index]));
  }

  /** The derivatives of these. */
  get pull(): Float64Array {
    return this.start.map((_, index) => (index < this.free.length && isLogarithmic(this.free[index]) ? 1 / PULL : 0));
  }

  /** Differences of each signal at the samples that are fitted, or at those that are held out. */
  bySignal(readings: Map<Signal, Float64Array>[], isHeld: boolean): Map<Signal, Float64Array> {
    return new Map(
      this.experiment.compared.map((signal) => {
        const parts = this.windows.map(({ record, used, held }, index) => {
          const seen = readings[index].get(signal)!;
          const left = record.of(signal).map((value, row) => value - seen[row]);
          return left.filter((_, row) => used[row] && held[row] === Number(isHeld));
        });
        return [signal, joined(parts)] as const;
      }),
    );
  }

  /** Sensors with the noise that makes what a vector leaves of their signals most likely. */
  likelySensors(x: Float64Array): Map<Signal, Sensor> {
    const left = this.bySignal(this.readings(x), false);
    return new Map(
      [...this.sensors].map(([signal, sensor]) => {
        const own = left.get(signal)!;
        return [signal, own.every(Number.isFinite) ? sensor.withNoiseOf(own) : sensor] as const;
      }),
    );
  }

  private run(window: Window, values: Values, begin: Values) {
    const { experiment } = this;
    const settings = new Map([...begin, ...experiment.start(values), ["solver.relativeTolerance", this.tolerance]] as const);
    const { grid, step } = window.record;
    const inputs = experiment.inputs(window, values);
    const { library, told, most } = this;
    return simulate(library, experiment.model.name, settings, inputs, experiment.outputs, grid.length, step, most, told);
  }
}

/** What a sensor with a gain, an offset and a delay reads of a course. */
function read({ time, grid }: Measured, signal: Signal, course: Float64Array, values: Values): Float64Array {
  const delay = values.get(`delay.${signal}`) ?? 0;
  const gain = values.get(`gain.${signal}`) ?? 1;
  const offset = values.get(`offset.${signal}`) ?? 0;
  const seen = interpolate(delay === 0 ? time : time.map((value) => value - delay), grid, course);
  return gain === 1 && offset === 0 ? seen : seen.map((value) => value / gain + offset);
}

/** A window up to its last sample that is fitted; nothing if there is none. */
function cutOf({ record, driven, used, held, begin }: Window): Window | null {
  let last = used.length;
  while (last > 0 && (!used[last - 1] || held[last - 1])) last -= 1;
  if (last === 0) return null;
  if (last === used.length) return { record, driven, used, held, begin };
  const cut = record.part(0, last);
  const shorter = new Map([...driven].map(([name, course]) => [name, course.subarray(0, cut.grid.length)] as const));
  return { record: cut, driven: shorter, used: used.subarray(0, last), held: held.subarray(0, last), begin };
}

