// Two cylinders that differ in their friction law alone, under the same voltage.

import { Plot, TimeChart } from "../charts";
import type { Context } from "../context";
import { CentredInput } from "../centring";
import { Cylinder, SHOWN } from "../cylinder";
import { element } from "../dom";
import { withoutJumps } from "../episodes";
import { filesOfRun } from "../exports";
import { lawChoice, secondLawChoice } from "../law-choice";
import { LivePage } from "../live";
import { Essentials } from "../parameter-slider";
import { oneModel } from "../python";
import { MM, thinning } from "../quantities";
import { Readouts } from "../readouts";
import type { Exchange, Member, Run } from "../run";
import { CYLINDER } from "../settings";
import { at } from "../signal";
import { lawName, model, variable } from "../tables";
import { friction, frictionOverVelocity, position } from "./charts";
import { VOLTAGE, WATCHED } from "./stick-slip";

type Column = Float64Array;

const LINES = [
  { label: "first law", colour: "--line-1" },
  { label: "second law", colour: "--line-2", dashed: true },
];

export class TwoLaws extends LivePage {
  readonly driven = [`${CYLINDER}.valveVoltage`];
  protected readonly scale = VOLTAGE;
  protected readonly window = 16;
  private readonly cylinders = ["First law", "Second law"].map((title) => new Cylinder(title));
  private readonly forces = this.cylinders.map(() => this.balance());
  private readonly readouts = new Readouts(["First is at", "Second is at", "Difference", "Largest so far", "Sticks"]);
  private readonly position = position(LINES, { marked: true });
  private readonly difference = new TimeChart({
    title: "Position difference, second law less first",
    up: "Difference in mm",
    lines: [{ label: "difference", colour: "--line-3" }],
    span: 0.1,
  });
  private readonly friction = friction(LINES, { marked: true });
  private readonly over = frictionOverVelocity(LINES);
  protected readonly charts = [this.position, this.difference, this.friction, this.over];
  private largest = { of: null as Run | null, value: 0, rows: 0 };

  constructor(context: Context) {
    super(context);
    const first = lawChoice(context, CYLINDER, "First law");
    const second = secondLawChoice(context, (law) => {
      context.settings.secondLaw = law;
      context.changed();
      this.restart();
    });
    const sides = [first, second].map((law, index) =>
      element("div", { class: `side side-${index + 1}` }, law, this.forces[index].root, this.cylinders[index].root),
    );
    this.pushable(this.cylinders);
    this.assemble([element("div", { class: "sides" }, ...sides)], [this.readouts.root], new Essentials(context, CYLINDER));
  }

  protected members(): Member[] {
    const first = new Map([["valveVoltage", at(this.context.settings.signal, 0)]]);
    return this.variants().map(([name, values]) => ({
      prefix: `${name}.`,
      model: CYLINDER,
      values,
      first,
      watched: WATCHED,
    }));
  }

  private readonly input = new CentredInput(() => this.context.settings.signal, WATCHED.indexOf("position"));
  protected readonly exchange: Exchange = (time, run) => {
    run.members.forEach((_, index) => run.set(index, new Map([["valveVoltage", this.input.at(time, run, index)], ...this.pushed(run)])));
  };

  protected scene(run: Run): void {
    const { recording, members } = run;
    const stroke = this.context.settings.values[CYLINDER].get("cylinder.stroke") ?? 0.5;
    const names = (variable: string) => members.map((member) => member.prefix + variable);
    const variants = this.variants();
    members.forEach(({ prefix }, index) => {
      const now = (variable: string) => recording.last(prefix + variable);
      this.cylinders[index].show(SHOWN.map(now), stroke);
      this.forces[index].show(now, variants[index][1]);
    });
    const [a, b] = names("position").map((name) => recording.last(name));
    const [heldA, heldB] = names("sticking").map((name) => recording.last(name) === 1);
    this.readouts.show("First is at", `${(a * MM).toFixed(2)} mm`);
    this.readouts.show("Second is at", `${(b * MM).toFixed(2)} mm`);
    this.readouts.show("Difference", `${((b - a) * MM).toFixed(3)} mm`);
    this.readouts.show("Largest so far", `${(this.largestDifference(run) * MM).toFixed(3)} mm`);
    this.readouts.show("Sticks", heldA && heldB ? "both" : heldA ? "first" : heldB ? "second" : "neither");
  }

  protected plots({ recording, members }: Run, first: number): Plot[] {
    const column = thinning(recording, first);
    const times = column("time");
    const both = (name: string, factor?: number) => members.map(({ prefix }) => column(prefix + name, factor));
    const [one, other] = both("position", MM);
    const path = (index: number): [Column, Column] => {
      const whole = (name: string) => recording.column(members[index].prefix + name, first);
      return [withoutJumps(whole("velocity")).map((value) => value * MM), whole("frictionForce")];
    };
    return [
      new Plot(this.position, () => ({ times, lines: [one, other] })),
      new Plot(this.difference, () => ({ times, lines: [one.map((value, index) => other[index] - value)] })),
      new Plot(this.friction, () => ({ times, lines: both("frictionForce") })),
      new Plot(this.over, () => [path(0), path(1)]),
    ];
  }

  protected filesOf(run: Run) {
    const { settings, library } = this.context;
    const variants = this.variants();
    const parts = [{ model: CYLINDER, prefix: "", values: variants[0][1] }];
    const about = `Set in the playground; compared with ${variants[1][0]}`;
    const ssv = library.ssv("Playground", about, parts, new Date());
    const program = (csv: string) => oneModel(library.tables, run, ["first", "second"], "valveVoltage", settings.signal, csv);
    return filesOfRun("two-laws", run.recording, program, { ssv, charts: this.charts });
  }

  /** The names of the laws, and the values of the cylinder with each. */
  private variants(): [string, ReadonlyMap<string, number>][] {
    const { settings, library } = this.context;
    const values = settings.values[CYLINDER];
    const law = variable(model(library.tables, CYLINDER), "friction.law");
    const first = values.get(law.name) ?? law.start ?? 0;
    const names = [first, settings.secondLaw].map((id) => lawName(library.tables, id));
    if (names[0] === names[1]) names[1] += " again";
    return [
      [names[0], values],
      [names[1], new Map([...values, ["friction.law", settings.secondLaw]])],
    ];
  }

  /** The largest difference of position since the start of a run; only new rows are looked at. */
  private largestDifference(run: Run): number {
    const { recording, members } = run;
    if (this.largest.of !== run || recording.rows < this.largest.rows) this.largest = { of: run, value: 0, rows: 0 };
    const [a, b] = members.map(({ prefix }) => recording.column(`${prefix}position`, this.largest.rows));
    a.forEach((value, index) => (this.largest.value = Math.max(this.largest.value, Math.abs(b[index] - value))));
    this.largest.rows = recording.rows;
    return this.largest.value;
  }
}
