// One cylinder under a voltage: it sticks and slips.

import { Plot, TimeChart } from "../charts";
import type { Context } from "../context";
import { CentredInput } from "../centring";
import { Cylinder, SHOWN } from "../cylinder";
import { episodes, withoutJumps } from "../episodes";
import { filesOfRun } from "../exports";
import { lawChoice } from "../law-choice";
import { LivePage } from "../live";
import { Essentials } from "../parameter-slider";
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
  si: "V",
  factor: 1,
  level: [0, 10],
  amplitude: [0, 5],
  period: [0.1, 10],
  centring: [0, 4],
  apart: { from: 5, to: 5.5 },
};

/** Variables for the charts besides the drawing. */
export const WATCHED = ["valveVoltage", "externalForce", ...SHOWN];

export class StickSlip extends LivePage {
  readonly driven = [`${CYLINDER}.valveVoltage`];
  protected readonly scale = VOLTAGE;
  protected readonly window = 8;
  private readonly cylinder = new Cylinder("Cylinder");
  private readonly forces = this.balance();
  private readonly readouts = new Readouts(["Position", "Velocity", "Friction", "Chamber A", "Chamber B", "Valve"]);
  private readonly position = position([{ label: "position", colour: "--line-1" }], { episodes: true });
  private readonly pressures = new TimeChart({
    title: "Pressures",
    up: "Absolute pressure in bar",
    lines: [
      { label: "chamber A", colour: "--line-1" },
      { label: "chamber B", colour: "--line-2", dashed: true },
    ],
    span: 0.1,
  });
  private readonly friction = friction([FRICTION], { episodes: true });
  private readonly over = frictionOverVelocity([FRICTION]);
  protected readonly charts = [this.position, this.over, this.pressures, this.friction];

  constructor(context: Context) {
    super(context);
    const law = lawChoice(context, CYLINDER, "Friction law");
    this.pushable([this.cylinder]);
    this.assemble([this.forces.root, this.cylinder.root], [law, this.readouts.root], new Essentials(context, CYLINDER));
  }

  protected members(): Member[] {
    const { settings } = this.context;
    const first = new Map([["valveVoltage", at(settings.signal, 0)]]);
    return [{ prefix: "", model: CYLINDER, values: settings.values[CYLINDER], first, watched: WATCHED }];
  }

  private readonly input = new CentredInput(() => this.context.settings.signal, WATCHED.indexOf("position"));
  protected readonly exchange: Exchange = (time, run) =>
    run.set(0, new Map([["valveVoltage", this.input.at(time, run, 0)], ...this.pushed(run)]));

  protected scene({ recording }: Run): void {
    const now = (name: string) => recording.last(name);
    this.cylinder.show(SHOWN.map(now), this.stroke);
    this.forces.show(now, this.context.settings.values[CYLINDER]);
    this.readouts.show("Position", `${(now("position") * MM).toFixed(2)} mm`);
    this.readouts.show("Velocity", now("sticking") === 1 ? "sticks" : `${(now("velocity") * MM).toFixed(1)} mm/s`);
    this.readouts.show("Friction", `${now("frictionForce").toFixed(2)} N`);
    this.readouts.show("Chamber A", `${(now("chamberA.pressure") * BAR).toFixed(3)} bar`);
    this.readouts.show("Chamber B", `${(now("chamberB.pressure") * BAR).toFixed(3)} bar`);
    this.readouts.show("Valve", `${now("valveVoltage").toFixed(2)} V`);
  }

  protected plots({ recording }: Run, first: number): Plot[] {
    const column = thinning(recording, first);
    const times = column("time");
    const marks = episodes(recording, first, this.stroke);
    const over = () => [withoutJumps(recording.column("velocity", first)).map((value) => value * MM), recording.column("frictionForce", first)] as const;
    return [
      new Plot(this.position, () => ({ times, lines: [column("position", MM)], episodes: marks })),
      new Plot(this.over, () => [over()]),
      new Plot(this.pressures, () => ({ times, lines: [column("chamberA.pressure", BAR), column("chamberB.pressure", BAR)] })),
      new Plot(this.friction, () => ({ times, lines: [column("frictionForce")], episodes: marks })),
    ];
  }

  private get stroke(): number {
    return this.context.settings.values[CYLINDER].get("cylinder.stroke") ?? 0.5;
  }

  protected filesOf(run: Run) {
    const { settings, library } = this.context;
    const parts = [{ model: CYLINDER, prefix: "", values: settings.values[CYLINDER] }];
    const ssv = library.ssv("Playground", "Set in the playground", parts, new Date());
    const program = (csv: string) => oneModel(library.tables, run, ["run"], "valveVoltage", settings.signal, csv);
    return filesOfRun("stick-slip", run.recording, program, { ssv, charts: this.charts });
  }
}
