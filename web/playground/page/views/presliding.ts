// The friction force of a law under a drawn displacement: hysteresis loops, which close or do not.

import { PathChart, TimeChart, type Paths } from "../charts";
import type { Context, Files, Page } from "../context";
import { element, segments, slider } from "../dom";
import { filesOfRun } from "../exports";
import { lawChoice } from "../law-choice";
import { Refusal } from "../library";
import { loops, type Loop } from "../loops";
import { oneModel } from "../python";
import { thinning } from "../quantities";
import { Run, STEP, type Member } from "../run";
import { BENCH, nestedLoops } from "../settings";
import { along, POINTS, type Signal } from "../signal";
import { sketch } from "../sketch";
import { short } from "../tables";
import { FRICTION, friction } from "./charts";

const MICROMETRES = 1e6;
/** The item of `bench.drive` that moves the mass as prescribed. */
const PRESCRIBED = 2;
/** A loop is called closed if its gap is smaller than this part of the range of the force. */
const CLOSED = 0.01;

/** Displacements to begin with, over a fraction of the time. */
const SHAPES: readonly (readonly [string, (fraction: number) => number])[] = [
  ["Nested loops", nestedLoops],
  ["One loop", (fraction) => Math.sin(4 * Math.PI * fraction)],
  ["Growing", (fraction) => fraction * Math.sin(10 * Math.PI * fraction)],
];

export class Presliding implements Page {
  readonly root = element("div", { class: "page" });
  readonly driven = [`${BENCH}.driveVelocity`, `${BENCH}.bench.drive`];
  private readonly pad = element("div", {});
  private readonly verdict = element("div", { class: "verdict", "aria-live": "polite" });
  private readonly loops = new PathChart({
    title: "Friction over displacement",
    across: "Displacement in µm",
    up: "Friction force in N",
    lines: [{ label: "friction force", colour: "--line-1" }],
    span: 0.01,
  });
  private readonly displacement = new TimeChart({
    title: "Displacement",
    up: "Displacement in µm",
    lines: [{ label: "displacement", colour: "--line-2" }],
    span: 0.1,
  });
  private readonly force = friction([FRICTION], { span: 0.01 });
  private run: Run | null = null;
  private isStale = true;
  /** The loops that are shown, and those that are kept behind them, to compare. */
  private shown: Paths = [];
  private kept: Paths | null = null;
  private readonly keep = element("button", { type: "button", title: "Keep these loops behind the next ones, to compare", onclick: () => this.keepLoops() }, "Keep");

  constructor(private readonly context: Context) {
    const shapes = segments<string>(
      "Displacement",
      SHAPES.map(([name]) => [name, name] as const),
      "",
      (name) => this.take(SHAPES.find(([candidate]) => candidate === name)?.[1] ?? nestedLoops),
    );
    const { signal } = this;
    const amplitude = slider({
      label: "Amplitude",
      unit: "µm",
      isPositive: true,
      scale: { shown: (power) => Number((10 ** power).toPrecision(4)), place: Math.log10 },
      min: 0,
      max: 4,
      step: 0.05,
      value: Math.log10(signal.amplitude * MICROMETRES),
      onChange: (power) => this.changed(() => (signal.amplitude = 10 ** power / MICROMETRES)),
    });
    const period = slider({
      label: "Duration",
      unit: "s",
      min: 1,
      max: 20,
      step: 0.5,
      value: signal.period,
      onChange: (value) => this.changed(() => (signal.period = value)),
    });
    this.showPad();
    const controls = element("div", { class: "signal" }, this.pad, amplitude, period);
    const title = element("span", { class: "title" }, "Displacement: draw it");
    const editor = element("div", { class: "signal-editor" }, title, element("div", { class: "buttons" }, shapes, this.keep), controls);
    const law = lawChoice(context, BENCH, "Friction law");
    this.root.append(
      element("section", { class: "card scene" }, law, editor, this.verdict),
      element("section", { class: "charts" }, this.loops.root, this.displacement.root, this.force.root),
    );
  }

  frame(): void {
    if (!this.isStale) return;
    this.isStale = false;
    this.restart();
    if (this.run) this.draw(this.run);
  }

  change(): void {
    this.isStale = true;
  }

  files(): Files | null {
    if (!this.run) return null;
    const { library } = this.context;
    const { run } = this;
    const ssv = library.ssv("Playground", "Set in the playground", run.members, new Date());
    const program = (csv: string) => oneModel(library.tables, run, ["run"], "driveVelocity", null, csv);
    return filesOfRun("presliding", run.recording, program, { ssv, charts: [this.loops, this.displacement, this.force] });
  }

  private get signal(): Signal {
    return this.context.settings.signals.presliding;
  }

  /** The values of the bench, which begins where the displacement does. */
  private values(): Map<string, number> {
    const begin = ["position0", this.place(0)] as const;
    return new Map([begin, ...this.context.settings.values[BENCH], ["bench.drive", PRESCRIBED]]);
  }

  /** The displacement in m at a time in s. */
  private place(time: number): number {
    const { points, amplitude, period } = this.signal;
    return amplitude * along(points, Math.min(time / period, 1));
  }

  private changed(change: () => void): void {
    change();
    this.isStale = true;
    this.context.changed();
  }

  private keepLoops(): void {
    this.kept = this.kept ? null : this.shown;
    this.keep.textContent = this.kept ? "Let go" : "Keep";
    this.isStale = true;
  }

  private take(shape: (fraction: number) => number): void {
    const points = Array.from({ length: POINTS }, (_, index) => shape(index / (POINTS - 1)));
    this.changed(() => (this.signal.points = points));
    this.showPad();
  }

  private showPad(): void {
    const draw = (points: number[]) => this.changed(() => (this.signal.points = points));
    this.pad.replaceChildren(sketch("Displacement", this.signal.points, draw));
  }

  /** Runs the whole displacement. */
  private restart(): void {
    const { period } = this.signal;
    const rate = (time: number) => (this.place(time + STEP) - this.place(time)) / STEP;
    const velocity = (time: number) => new Map([["driveVelocity", rate(time)]]);
    const watched = ["driveVelocity", "position", "frictionForce", "sticking"];
    const member: Member = { prefix: "", model: BENCH, values: this.values(), first: velocity(0), watched };
    try {
      const run = new Run(this.context.library, [member], (time, running) => running.set(0, velocity(time)));
      // At its end the displacement has no velocity any more.
      while (run.time + 1.5 * STEP < period) run.step();
      this.run = run;
      this.context.tell(null);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.context.tell(error.message);
    }
  }

  private draw({ recording, time }: Run): void {
    const column = thinning(recording, 0);
    const [times, x, force] = [column("time"), column("position", MICROMETRES), column("frictionForce")];
    this.loops.show([[x, force]], [0, time], this.kept ?? undefined);
    this.displacement.show({ times, lines: [x] }, [0, time]);
    this.force.show({ times, lines: [force] }, [0, time]);
    this.shown = [[x, force]];
    const all = recording.column("frictionForce");
    const span = all.reduce((a, b) => Math.max(a, b)) - all.reduce((a, b) => Math.min(a, b));
    this.judge(loops(recording.column("position"), all), span);
  }

  private judge(found: Loop[], span: number): void {
    const isClosed = (loop: Loop) => Math.abs(loop.gap) <= CLOSED * span;
    const rows = found.map((loop) => {
      const [from, to] = [loop.from, loop.to].map((place) => short(place * MICROMETRES, 3));
      const text = `${from} to ${to} µm: ${isClosed(loop) ? "closes" : "does not close"}`;
      const gap = element("span", { class: "muted" }, ` (gap ${short(loop.gap, 2)} N)`);
      return element("li", { class: isClosed(loop) ? "closed" : "open" }, text, gap);
    });
    const count = found.filter(isClosed).length;
    const summary = found.length ? `${count} of ${found.length} loops close` : "No loop is completed";
    this.verdict.replaceChildren(element("strong", {}, summary), element("ul", {}, ...rows));
  }
}
