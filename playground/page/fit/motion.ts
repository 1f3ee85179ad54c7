// A seal or a tribometer: the motion is prescribed, the force is measured.

import { BENCH } from "../settings";
import { items, model, variable, type Tables } from "../tables";
import { interpolate } from "./arrays";
import { Experiment, type Beginning, type Forces, type Options, type Values, type Window } from "./experiment";
import type { Measured } from "./measured";
import type { Signal } from "./signals";
import { follow, noise } from "./smoothing";

/** FrictionBench under a prescribed position; `force = pressure * area + friction` where a seal is under pressure. */
export class Motion extends Experiment {
  readonly compared: readonly Signal[];
  override readonly unknown: readonly string[];
  readonly outputs = ["frictionForce"];

  constructor(tables: Tables, law: number, known: Values, signals: ReadonlySet<Signal>, options: Options) {
    super(tables, BENCH, law, known, signals, options);
    this.compared = signals.has("frictionForce") ? ["frictionForce"] : ["force"];
    this.unknown = this.compared[0] === "force" && signals.has("pressure") ? ["area"] : [];
  }

  /** Hides the jitter of the position, and leaves out samples at rest: friction at rest answers the drive. */
  prepare(record: Measured) {
    const position = record.signals.has("position") ? this.followed(record) : integral(record);
    const driven = new Map([["position", position]]);
    for (const signal of ["pressure", "normalForce"] as const) {
      if (record.signals.has(signal)) driven.set(signal, record.onGrid(signal));
    }
    const used = Uint8Array.from(record.time, (time) => {
      const point = Math.min(Math.max(Math.ceil(time / record.step - 1e-6), 0), position.length - 1);
      return Number(point > 0 && position[point] !== position[point - 1]);
    });
    return { driven, used };
  }

  begin(): Beginning {
    return { values: new Map(), loose: [] };
  }

  /** The position at the end of each step, and the load level. */
  inputs(window: Window, values: Values): Map<string, Float64Array> {
    const position = window.driven.get("position")!;
    const ends = position.map((place, point) => position[point + 1] ?? place);
    return new Map([
      ["prescribedPosition", ends],
      ["friction.level", this.level(window, values)],
    ]);
  }

  /** Starts at rest at the first sample. */
  start(values: Values): Map<string, number> {
    const drive = variable(model(this.tables, BENCH), "bench.drive");
    const prescribed = items(this.tables, drive).find((item) => item.name === "PrescribedPosition");
    return new Map([
      ...this.ofModel(values),
      ["friction.law", this.law],
      ["bench.drive", prescribed?.id ?? NaN],
      ["driveVelocity", 0],
      ["position0", 0],
    ]);
  }

  predict({ driven }: Window, outputs: ReadonlyMap<string, Float64Array>, values: Values): Map<Signal, Float64Array> {
    const friction = outputs.get("frictionForce")!;
    const pressure = driven.get("pressure");
    if (this.compared[0] === "frictionForce" || !pressure) return new Map([[this.compared[0], friction]]);
    const area = values.get("area") ?? 0;
    return new Map([["force", friction.map((force, point) => force + area * pressure[point])]]);
  }

  /** Velocity, friction and load level at the samples that are compared. */
  forces(window: Window, values: Values): Forces {
    const { record, used, held } = window;
    const position = window.driven.get("position")!;
    const last = position.length - 1;
    const slope = position.map((_, point) => {
      const [from, to] = [Math.max(point - 1, 0), Math.min(point + 1, last)];
      return (position[to] - position[from]) / ((to - from) * record.step);
    });
    const [signal] = this.compared;
    const pressure = signal === "force" ? record.signals.get("pressure") : undefined;
    const [area, offset] = [values.get("area") ?? 0, values.get(`offset.${signal}`) ?? 0];
    const force = record.of(signal).map((value, row) => value - offset - area * (pressure?.[row] ?? 0));
    const isFitted = (_: number, row: number) => used[row] === 1 && held[row] === 0;
    const atSamples = (course: Float64Array) => interpolate(record.time, record.grid, course).filter(isFitted);
    return { speed: atSamples(slope), force: force.filter(isFitted), level: atSamples(this.level(window, values)) };
  }

  /** The load level at the communication points. */
  private level({ driven }: Window, values: Values): Float64Array {
    const [load, pressure] = [driven.get("normalForce"), driven.get("pressure")];
    const kappa = values.get("friction.kappaA") ?? 0;
    return driven.get("position")!.map((_, point) => {
      const level = (load ? load[point] / this.options.rated : 1) * (pressure ? 1 + kappa * pressure[point] : 1);
      return Math.max(level, 0);
    });
  }

  private followed(record: Measured): Float64Array {
    const position = record.of("position");
    const play = this.options.play ?? 3 * noise(position);
    this.notes.push(`the position is followed with a play of ${(1e6 * play).toPrecision(3)} um`);
    return follow(
      record.onGrid("position").map((place) => place - position[0]),
      play,
    );
  }
}

/** The position of a measured velocity. */
function integral(record: Measured): Float64Array {
  const speed = record.onGrid("velocity");
  let place = 0;
  return speed.map((value, point) => (place += point ? 0.5 * record.step * (value + speed[point - 1]) : 0));
}
