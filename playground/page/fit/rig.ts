// The whole rig: the voltage is given, position and pressures are compared.

import { CYLINDER } from "../settings";
import type { Tables } from "../tables";
import { span } from "./arrays";
import { Experiment, first, type Beginning, type Forces, type Options, type Values, type Window } from "./experiment";
import type { Measured } from "./measured";
import type { Signal } from "./signals";
import { noise, parabolas } from "./smoothing";

const COMPARED: Signal[] = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"];
const GIVEN: Signal[] = ["valveVoltage", "supplyPressure", "externalForce"];
const CHAMBERS = ["chamberA", "chamberB"] as const;
const GRAVITY = 9.80665;
/** A carriage rests where its position stays within so many times its noise. */
const RESTING = 8;

export class Rig extends Experiment {
  readonly compared: readonly Signal[];
  override readonly driving: readonly Signal[];
  readonly outputs: readonly string[];

  constructor(tables: Tables, law: number, known: Values, signals: ReadonlySet<Signal>, options: Options) {
    super(tables, CYLINDER, law, known, signals, options);
    this.compared = COMPARED.filter((signal) => signals.has(signal));
    this.driving = GIVEN.filter((signal) => signals.has(signal));
    this.outputs = this.compared;
  }

  prepare(record: Measured) {
    const driven = new Map<string, Float64Array>();
    for (const signal of record.signals.keys()) driven.set(signal, record.onGrid(signal));
    return { driven, used: new Uint8Array(record.time.length).fill(1) };
  }

  /** Begins with the smoothed position and its slope, and with the pressures; what rests does not move by what is exactly 0. */
  begin(record: Measured, driven: ReadonlyMap<string, Float64Array>): Beginning {
    const { width } = this.options;
    const { smooth, slope } = parabolas(record.onGrid("position"), record.step, width);
    const position = record.of("position");
    const around = position.subarray(0, Math.max(1, Math.round((0.5 * width) / record.step)) + 1);
    const rests = span(around) <= RESTING * noise(position);
    const speed = rests ? 0 : (driven.get("velocity") ?? slope)[0];
    const pressures = CHAMBERS.filter((chamber) => driven.has(`${chamber}.pressure`));
    const values = new Map([
      ["velocity0", speed],
      ["position0", smooth[0]],
      ...pressures.map((chamber) => [`${chamber}.pressure0`, first(driven.get(`${chamber}.pressure`)!)] as const),
    ]);
    return { values, loose: [...values.keys()].filter((name) => name !== "velocity0" || speed !== 0) };
  }

  inputs({ driven }: Window, values: Values): Map<string, Float64Array> {
    return new Map(this.driving.map((signal) => [signal, this.truth(signal, driven.get(signal)!, values)]));
  }

  start(values: Values): Map<string, number> {
    return new Map([...this.ofModel(values), ["friction.law", this.law]]);
  }

  predict(_: Window, outputs: ReadonlyMap<string, Float64Array>): Map<Signal, Float64Array> {
    return new Map(this.compared.map((signal) => [signal, outputs.get(signal)!]));
  }

  /** What acceleration leaves of the pressure force, while moving. */
  forces({ record, driven }: Window, values: Values): Forces | null {
    const [a, b] = CHAMBERS.map((chamber) => driven.get(`${chamber}.pressure`));
    if (!a || !b) return null;
    const width = 2 * this.options.width;
    const value = (name: string) => this.value(name, values);
    const speed = driven.get("velocity") ?? parabolas(driven.get("position")!, record.step, width).slope;
    const acceleration = parabolas(speed, record.step, width).slope;
    const [bore, rod] = ["bore", "rod"].map((name) => 0.25 * Math.PI * value(`cylinder.${name}`) ** 2);
    const [mass, ambient] = [value("mass.moving"), value("ambientPressure")];
    const dead = value("wireForce") + mass * GRAVITY * Math.sin(value("incline"));
    const external = driven.get("externalForce");
    const force = speed.map(
      (_, k) =>
        a[k] * bore - b[k] * (bore - rod) - ambient * rod - dead + (external?.[k] ?? 0) - mass * acceleration[k],
    );
    const [kappaA, kappaB] = ["A", "B"].map((chamber) => value(`friction.kappa${chamber}`));
    const level = speed.map((_, k) => Math.max(1 + kappaA * (a[k] - ambient) + kappaB * (b[k] - ambient), 0));
    return { speed, force, level };
  }
}
