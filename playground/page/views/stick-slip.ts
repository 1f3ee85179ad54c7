// One cylinder under a voltage: it sticks and slips.

import { TimeChart } from "../charts";
import type { Context, Files } from "../context";
import { Cylinder, SHOWN } from "../cylinder";
import { lawChoice } from "../law-choice";
import { LivePage } from "../live";
import { oneModel } from "../python";
import { BAR, MM, thinning } from "../quantities";
import { Readouts } from "../readouts";
import type { Exchange, Member, Run } from "../run";
import { CYLINDER } from "../settings";
import { at } from "../signal";
import type { Scale } from "../signal-editor";
import { FRICTION, friction, frictionOverVelocity, position } from "./charts";

export const VOLTAGE: Scale = {
  label: "Valve voltage",
  unit: "V",
  factor: 1,
  level: [0, 10],
  amplitude: [0, 5],
  period: [0.1, 10],
};

/** What the charts need besides the drawing. */
export const WATCHED = ["valveVoltage", ...SHOWN];

export class StickSlip extends LivePage {
  readonly driven = [`${CYLINDER}.valveVoltage`];
  protected readonly scale = VOLTAGE;
  protected readonly window = 3;
  private readonly cylinder = new Cylinder("Cylinder");
  private readonly readouts = new Readouts(["Position", "Velocity", "Friction", "Chamber A", "Chamber B", "Valve"]);
  private readonly position = position([{ label: "position", colour: "--line-1" }]);
  private readonly pressures = new TimeChart({
    title: "Pressures",
    up: "bar",
    lines: [
      { label: "chamber A", colour: "--line-1" },
      { label: "chamber B", colour: "--line-2" },
    ],
    span: 0.1,
  });
  private readonly friction = friction([FRICTION]);
  private readonly over = frictionOverVelocity([FRICTION]);

  constructor(context: Context) {
    super(context);
    const charts = [this.position, this.pressures, this.friction, this.over].map((chart) => chart.root);
    const law = lawChoice(context, CYLINDER, "Friction law");
    this.assemble([law, this.cylinder.root, this.readouts.root], charts);
  }

  protected members(): Member[] {
    const { settings } = this.context;
    const first = new Map([["valveVoltage", at(settings.signal, 0)]]);
    return [{ prefix: "", model: CYLINDER, values: settings.values[CYLINDER], first, watched: WATCHED }];
  }

  protected readonly exchange: Exchange = (time, run) =>
    run.set(0, new Map([["valveVoltage", at(this.context.settings.signal, time)]]));

  protected scene({ recording }: Run): void {
    const now = (name: string) => recording.last(name);
    this.cylinder.show(SHOWN.map(now), this.context.settings.values[CYLINDER].get("cylinder.stroke") ?? 0.5);
    this.readouts.show("Position", `${(now("position") * MM).toFixed(2)} mm`);
    this.readouts.show("Velocity", now("sticking") === 1 ? "stuck" : `${(now("velocity") * MM).toFixed(1)} mm/s`);
    this.readouts.show("Friction", `${now("frictionForce").toFixed(2)} N`);
    this.readouts.show("Chamber A", `${(now("chamberA.pressure") * BAR).toFixed(3)} bar`);
    this.readouts.show("Chamber B", `${(now("chamberB.pressure") * BAR).toFixed(3)} bar`);
    this.readouts.show("Valve", `${now("valveVoltage").toFixed(2)} V`);
  }

  protected plots({ recording }: Run, first: number, range: [number, number]): (() => void)[] {
    const column = thinning(recording, first);
    const time = column("time");
    const [a, b] = ["chamberA.pressure", "chamberB.pressure"];
    return [
      () => this.position.show(time, [column("position", MM)], range),
      () => this.pressures.show(time, [column(a, BAR), column(b, BAR)], range),
      () => this.friction.show(time, [column("frictionForce")], range),
      () => this.over.show([column("velocity", MM), column("frictionForce")]),
    ];
  }

  protected filesOf({ recording }: Run): Files {
    const { settings, library } = this.context;
    const values = settings.values[CYLINDER];
    const input = { variable: "valveVoltage", column: "valveVoltage", signal: settings.signal };
    const parts = [{ model: CYLINDER, prefix: "", values }];
    return {
      name: "stick-slip",
      csv: recording.csv(),
      ssv: library.ssv("Playground", "Set in the playground", parts, new Date()),
      python: oneModel(library.tables, CYLINDER, [["run", values]], input, recording.rows, "stick-slip.csv"),
    };
  }
}
