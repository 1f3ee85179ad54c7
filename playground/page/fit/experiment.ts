// What an experiment is: which model is run with which signals, and what is compared.

import { model, type Model, type Tables } from "../tables";
import { mean } from "./arrays";
import { FitError, type Measured } from "./measured";
import type { Signal } from "./signals";

/** Values of parameters by name, in SI units. */
export type Values = ReadonlyMap<string, number>;

/** What a simulation begins with, as it was measured; what is loose is fitted along, since its sensors err. */
export interface Beginning {
  values: Map<string, number>;
  loose: string[];
}

/** A stretch of a record that is simulated in one go. */
export interface Window {
  record: Measured;
  /** What was made of the signals once, at the communication points. */
  driven: ReadonlyMap<string, Float64Array>;
  /** Samples that are compared at all, and those of them that are held out of the fit: 1 for yes. */
  used: Uint8Array;
  held: Uint8Array;
  begin: Beginning;
}

export interface Options {
  /** Normal force in N at which the load level is 1. */
  rated: number;
  /** Width in s of the parabolas that give velocities. */
  width: number;
  /** Play in m that hides the jitter of a position at rest; by default three times its noise. */
  play: number | null;
}

export abstract class Experiment {
  abstract readonly compared: readonly Signal[];
  /** Measured signals that drive the model, whose sensors may have a gain and an offset. */
  readonly driving: readonly Signal[] = [];
  /** What has to be free, since the model has no default of it. */
  readonly unknown: readonly string[] = [];
  readonly notes: string[] = [];
  readonly model: Model;

  constructor(
    readonly tables: Tables,
    modelName: string,
    readonly law: number,
    readonly known: Values,
    readonly signals: ReadonlySet<Signal>,
    readonly options: Options,
  ) {
    this.model = model(tables, modelName);
  }

  /** The variables of the model that are recorded. */
  abstract readonly outputs: readonly string[];
  /** What is made of a record once, and which samples are compared. */
  abstract prepare(record: Measured): { driven: Map<string, Float64Array>; used: Uint8Array };
  abstract begin(record: Measured, driven: ReadonlyMap<string, Float64Array>): Beginning;
  /** The inputs at the communication points. */
  abstract inputs(window: Window, values: Values): Map<string, Float64Array>;
  /** The settings of a run, besides what its window begins with. */
  abstract start(values: Values): Map<string, number>;
  /** The compared signals at the communication points. */
  abstract predict(window: Window, outputs: ReadonlyMap<string, Float64Array>, values: Values): Map<Signal, Float64Array>;
  /** Velocity, friction and load level as far as the data alone tell them, for a start of the fit. */
  abstract forces(window: Window, values: Values): Forces | null;

  /** A parameter: fitted, known, or by default. */
  value(name: string, values: Values): number {
    const given = values.get(name) ?? this.known.get(name);
    return given ?? this.model.variables.find((entry) => entry.name === name)?.start ?? 0;
  }

  /** What a sensor has read without its gain and its offset. */
  protected truth(signal: Signal, reading: Float64Array, values: Values): Float64Array {
    const [gain, offset] = [values.get(`gain.${signal}`) ?? 1, values.get(`offset.${signal}`) ?? 0];
    return gain === 1 && offset === 0 ? reading : reading.map((value) => gain * (value - offset));
  }

  /** What of the known and the free parameters the model has. */
  protected ofModel(values: Values): Map<string, number> {
    const names = new Set(this.model.variables.map((entry) => entry.name));
    const measured = this.signals as ReadonlySet<string>;
    return new Map([...this.known, ...values].filter(([name]) => names.has(name) && !measured.has(name)));
  }
}

export interface Forces {
  speed: Float64Array;
  force: Float64Array;
  level: Float64Array;
}

/** What a signal begins with, from its first samples. */
export const first = (values: Float64Array): number => mean(values.subarray(0, 5));

/** Refuses a signal that never changes. */
export function checkMotion(records: readonly Measured[]): void {
  for (const signal of ["position", "velocity"] as const) {
    const courses = records.flatMap((record) => record.signals.get(signal) ?? []);
    if (courses.length && courses.every((course) => course.every((value) => value === course[0]))) {
      throw new FitError(`${signal} never changes: all at rest, so that nothing can be learned of friction`);
    }
  }
}
