// The cylinder in a position loop, whose gains are sliders.

import { Plot, TimeChart } from "../charts";
import type { Context } from "../context";
import { Cures } from "../cures";
import { Cylinder, SHOWN } from "../cylinder";
import { element } from "../dom";
import { episodes, withoutJumps } from "../episodes";
import { filesOfRun } from "../exports";
import { lawChoice } from "../law-choice";
import { LivePage } from "../live";
import { Essentials, parameterSlider } from "../parameter-slider";
import { closedLoop } from "../python";
import { MM, thinning } from "../quantities";
import { Readouts } from "../readouts";
import { coupled, judged, loopMembers } from "../position-loop";
import { STEP, type Member, type Run } from "../run";
import { CONTROLLER, CYLINDER } from "../settings";
import type { Scale } from "../signal-editor";
import { FRICTION, frictionOverVelocity, position } from "./charts";

/** The parameters of the controller that have sliders, with the ends of these in SI units. */
const GAINS: readonly (readonly [string, string, [number, number]])[] = [
  ["gain.position", "Position gain", [0, 60]],
  ["gain.velocity", "Velocity gain", [0, 40]],
  ["gain.integral", "Integral gain", [0, 100]],
  ["feedForward.gain", "Feed-forward", [0, 5]],
  ["valve.deadZone", "Compensation", [0, 0.2]],
  ["valve.transition", "Transition", [0, 1]],
];
/** Time in s over which the loop is judged. */
const JUDGED = 8;

export class ClosedLoop extends LivePage {
  readonly driven = [
    `${CYLINDER}.valveVoltage`,
    `${CONTROLLER}.referencePosition`,
    `${CONTROLLER}.position`,
    `${CONTROLLER}.velocity`,
  ];
  protected readonly scale: Scale = {
    label: "Reference position",
    unit: "mm",
    si: "m",
    factor: MM,
    level: [0.05, 0.45],
    amplitude: [0, 0.2],
    period: [0.5, 20],
    apart: { from: 0.25, to: 0.3 },
  };
  protected readonly window = 8;
  private readonly cylinder = new Cylinder("Cylinder");
  private readonly forces = this.balance();
  private readonly readouts = new Readouts(["Position", "Error", "RMS error", "Break-aways", "Voltage"]);
  private readonly position = position([
    { label: "reference", colour: "--line-2", dashed: true },
    { label: "position", colour: "--line-1" },
  ], { episodes: true });
  private readonly error = new TimeChart({
    title: "Position error",
    up: "Error in mm",
    lines: [{ label: "error", colour: "--line-1" }],
    span: 0.2,
  });
  private readonly voltage = new TimeChart({
    title: "Valve voltage",
    up: "Voltage in V",
    lines: [{ label: "voltage", colour: "--line-3" }],
    span: 0.5,
  });
  private readonly over = frictionOverVelocity([FRICTION]);
  protected readonly charts = [this.position, this.error, this.voltage, this.over];

  constructor(context: Context) {
    super(context);
    const law = lawChoice(context, CYLINDER, "Friction law");
    const gains = element("div", { class: "gains" }, ...GAINS.map(([name, label, ends]) => parameterSlider(context, CONTROLLER, name, label, ends)));
    this.pushable([this.cylinder]);
    this.assemble([this.forces.root, this.cylinder.root], [law, this.readouts.root, gains, this.cures.root], new Essentials(context, CYLINDER));
  }

  protected members(): Member[] {
    const { settings } = this.context;
    return loopMembers(settings.values[CYLINDER], settings.values[CONTROLLER], settings.signal);
  }

  private readonly cures = new Cures(this.context, () => this.restart());
  protected readonly exchange = coupled(() => this.context.settings.signal, () => this.cures.present, (run) => this.pushed(run));

  protected scene(run: Run): void {
    const { recording } = run;
    const now = (name: string) => recording.last(`plant.${name}`);
    const reference = recording.last("controller.referencePosition");
    this.cylinder.show(SHOWN.map(now), this.context.settings.values[CYLINDER].get("cylinder.stroke") ?? 0.5);
    this.forces.show(now, this.context.settings.values[CYLINDER]);
    this.readouts.show("Position", `${(now("position") * MM).toFixed(2)} mm`);
    this.readouts.show("Error", `${((reference - now("position")) * MM).toFixed(3)} mm`);
    this.readouts.show("Voltage", `${now("valveVoltage").toFixed(2)} V`);
    this.judge(run);
  }

  protected plots({ recording }: Run, first: number): Plot[] {
    const column = thinning(recording, first);
    const times = column("time");
    const stroke = this.context.settings.values[CYLINDER].get("cylinder.stroke") ?? 0.5;
    const marks = episodes(recording, first, stroke, "plant.");
    const [wanted, is] = ["controller.referencePosition", "plant.position"].map((name) => column(name, MM));
    const over = () =>
      [withoutJumps(recording.column("plant.velocity", first)).map((value) => value * MM), recording.column("plant.frictionForce", first)] as const;
    return [
      new Plot(this.position, () => ({ times, lines: [wanted, is], episodes: marks })),
      new Plot(this.error, () => ({ times, lines: [wanted.map((value, index) => value - is[index])] })),
      new Plot(this.voltage, () => ({ times, lines: [column("plant.valveVoltage")] })),
      new Plot(this.over, () => [over()]),
    ];
  }

  protected filesOf(run: Run) {
    const { settings, library } = this.context;
    const parts = [
      { model: CYLINDER, prefix: "plant.", values: settings.values[CYLINDER] },
      { model: CONTROLLER, prefix: "controller.", values: settings.values[CONTROLLER] },
    ];
    const ssv = library.ssv("Playground", "Set in the playground", parts, new Date());
    const program = (csv: string) => closedLoop(library.tables, run, settings.signal, csv, settings.dither);
    return filesOfRun("closed-loop", run.recording, program, { ssv, charts: this.charts });
  }

  /** Recent tracking error and break-aways. */
  private judge({ recording, time }: Run): void {
    const { rms, breakAways } = judged(recording, recording.rows - Math.ceil(JUDGED / STEP));
    this.readouts.show("RMS error", `${(rms * MM).toFixed(3)} mm`);
    this.readouts.show("Break-aways", `${breakAways} in ${Math.min(time, JUDGED).toFixed(0)} s`);
  }
}
