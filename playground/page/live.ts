// A page on which plants run with the wall clock: its buttons, its input, its run.

import { Clock } from "./clock";
import type { Cylinder } from "./cylinder";
import { CYLINDER } from "./settings";
import type { Context, Files, Page } from "./context";
import { element, segments } from "./dom";
import { startsByItself } from "./embedded";
import { Refusal } from "./library";
import { Run, STEP, type Exchange, type Member } from "./run";
import { signalEditor, type Scale } from "./signal-editor";

const SPEEDS = [
  [60, "60:1"],
  [1, "Real time"],
  [0.25, "1:4"],
  [0.05, "1:20"],
  [0.01, "1:100"],
] as const;

/** By how much the charts show more than at real time, at most. */
const LONGEST = 5;

export abstract class LivePage implements Page {
  readonly root = element("div", { class: "page" });
  abstract readonly driven: readonly string[];
  protected run: Run | null = null;
  /** Time in s that the charts show at real time. */
  protected abstract readonly window: number;
  private readonly clock = new Clock(STEP);
  private readonly play = element("button", { type: "button", class: "primary", onclick: () => this.toggle() });
  private readonly status = element("output", { class: "status", "data-status": "" });
  private isRunning = startsByItself;
  private isStale = true;
  private turn = 0;
  private push = 0;

  constructor(protected readonly context: Context) {}

  /** The plants of a new run. */
  protected abstract members(): Member[];
  protected abstract readonly exchange: Exchange;
  /** The scale of the input of this page. */
  protected abstract readonly scale: Scale;
  /** Shows the present state of the run. */
  protected abstract scene(run: Run): void;
  /** Shows its past from a row on in the charts, over a range of time: one function for each chart. */
  protected abstract plots(run: Run, first: number, range: [number, number]): (() => void)[];
  protected abstract filesOf(run: Run): Files;

  /** Lets the visitor push the carriages of some drawings, all of them at once. */
  protected pushable(cylinders: readonly Cylinder[]): void {
    for (const cylinder of cylinders) {
      cylinder.onPush = (force) => {
        this.push = force;
        if (this.run && force !== 0) this.run.isPushed = true;
      };
    }
  }

  /** The external force on a carriage, in a run in which the visitor has pushed it. */
  protected pushed(run: Run): [string, number][] {
    if (!run.isPushed) return [];
    return [["externalForce", (this.context.settings.values[CYLINDER].get("externalForce") ?? 0) + this.push]];
  }

  /** Puts scene and charts in their places, once they are made. */
  protected assemble(scene: Node[], charts: Node[]): void {
    const step = element("button", { type: "button", "data-step": "", onclick: () => this.stepOnce() }, "Step 1 ms");
    const again = element("button", { type: "button", "data-again": "", onclick: () => this.restart() }, "Restart");
    const speed = segments("Speed", SPEEDS, 1, (value) => (this.clock.speed = value));
    const transport = element("div", { class: "transport" }, this.play, step, again, speed, this.status);
    const editor = signalEditor(this.context.settings.signal, this.scale, () => {
      if (this.run) this.run.isRetuned = true;
      this.context.changed();
    });
    this.root.replaceChildren(
      element("section", { class: "card scene" }, ...scene, transport, editor),
      element("section", { class: "charts" }, ...charts),
    );
    this.restart();
    this.label();
  }

  /** Starts from time 0 with the present settings. */
  restart(): void {
    this.clock.pause();
    this.isStale = true;
    try {
      this.run = new Run(this.context.library, this.members(), this.exchange);
      this.context.tell(null);
    } catch (error) {
      this.run = null;
      this.stop(error);
    }
  }

  toggle(): void {
    this.isRunning = !this.isRunning;
    this.isStale = true;
    this.clock.pause();
    this.label();
  }

  stepOnce(): void {
    if (this.isRunning) this.toggle();
    this.advance();
  }

  frame(now: number): void {
    if (!this.run) return;
    if (this.isRunning) {
      try {
        this.clock.frame(now, () => this.run?.step());
      } catch (error) {
        this.stop(error);
      }
      this.isStale = true;
    }
    if (this.isStale) this.show(this.run);
    this.isStale = false;
  }

  change(model: string, name: string, value: number, isLive: boolean): void {
    if (!isLive || !this.run) {
      this.restart();
      return;
    }
    this.run.members.forEach((member, index) => {
      if (member.model === model) this.run?.set(index, new Map([[name, value]]));
    });
    this.run.isRetuned = true;
    this.isStale = true;
  }

  files(): Files | null {
    if (!this.run) return null;
    const files = this.filesOf(this.run);
    const { isRetuned, recording } = this.run;
    const notes = [
      isRetuned ? "# Something was changed under way; this program has the last values from the beginning.\n" : "",
      recording.isCut ? "# The file of the run begins in its middle; this program begins with the initial state.\n" : "",
    ];
    return { ...files, python: notes.join("") + files.python };
  }

  private advance(): void {
    try {
      this.run?.step();
    } catch (error) {
      this.stop(error);
    }
    this.isStale = true;
  }

  private show(run: Run): void {
    const span = this.window * Math.min(Math.max(this.clock.speed, 0.02), LONGEST);
    const end = Math.max(run.time, span);
    const first = Math.max(run.recording.rows - Math.ceil(span / STEP) - 1, 0);
    this.scene(run);
    // While it runs, the charts take turns, so that a frame has time for the drawing.
    const plots = this.plots(run, first, [end - span, end]);
    plots.filter((_, index) => !this.isRunning || index % 2 === this.turn).forEach((plot) => plot());
    this.turn = 1 - this.turn;
    const { rate, frames, dropped } = this.clock;
    this.status.textContent = `t = ${run.time.toFixed(3)} s`;
    this.status.title = `${rate.toFixed(0)} frames per second, ${dropped} steps dropped`;
    Object.assign(this.status.dataset, { time: run.time, rate: rate.toFixed(1), frames, dropped });
  }

  /** Says why it does not go on. */
  private stop(error: unknown): void {
    if (!(error instanceof Refusal)) throw error;
    this.context.tell(error.message);
    if (this.isRunning) this.toggle();
  }

  private label(): void {
    this.play.textContent = this.isRunning ? "Pause" : "Play";
    this.play.setAttribute("aria-pressed", String(this.isRunning));
  }
}
