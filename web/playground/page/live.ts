// A page of plants that run with the wall clock: its buttons, its input, its run.

import { Clock } from "./clock";
import type { Cylinder } from "./cylinder";
import { CYLINDER } from "./settings";
import type { Context, Files, Page } from "./context";
import { TimeChart, type Chart, type Plot } from "./charts";
import { byId, element, segments } from "./dom";
import { startsByItself } from "./embedded";
import { Refusal } from "./library";
import type { Essentials } from "./parameter-slider";
import { ForceBalance } from "./force-balance";
import { Run, STEP, type Exchange, type Member } from "./run";
import { signalEditor, type Scale } from "./signal-editor";
import { Statics } from "./statics";

const SPEEDS = [
  [60, "60:1"],
  [1, "Real time"],
  [0.25, "1:4"],
  [0.05, "1:20"],
  [0.01, "1:100"],
] as const;

/** Whether there is a column beside the page. */
const WIDE = matchMedia("(min-width: 1001px)");

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
  private sliders: Essentials | null = null;
  /** A run that is shown behind the present one, to compare with. */
  private kept: Run | null = null;
  /** The range of time that the visitor has chosen to see. */
  private zoom: [number, number] | null = null;
  private readonly keep = element("button", { type: "button", title: "Keep this run behind the next one, to compare", onclick: () => this.keepRun() }, "Keep");
  private readonly whole = element("button", { type: "button", hidden: true, onclick: () => this.zoomTo(null) }, "Whole time");

  constructor(protected readonly context: Context) {}

  /** The plants of a new run. */
  protected abstract members(): Member[];
  protected abstract readonly exchange: Exchange;
  /** The scale of the input of this page. */
  protected abstract readonly scale: Scale;
  /** Shows the present state of the run. */
  protected abstract scene(run: Run): void;
  /** Contents of the charts of a run, from a row on. */
  protected abstract plots(run: Run, first: number): Plot[];
  /** The charts, in the order of `plots`. */
  protected abstract readonly charts: readonly Chart<never>[];
  protected abstract filesOf(run: Run): Files;

  /** Lets the visitor push the carriages of some drawings, all of them at once. */
  protected pushable(cylinders: readonly Cylinder[]): void {
    for (const cylinder of cylinders) {
      cylinder.letPush((force) => {
        this.push = force;
        if (this.run && force !== 0) this.run.isPushed = true;
      });
    }
  }

  /** The external force on a carriage, in a run in which the visitor has pushed it. */
  protected pushed(run: Run): [string, number][] {
    if (!run.isPushed) return [];
    return [["externalForce", (this.context.settings.values[CYLINDER].get("externalForce") ?? 0) + this.push]];
  }

  /** The forces on a carriage whose run has the present settings. */
  protected balance(): ForceBalance {
    return new ForceBalance(this.context, new Statics(this.context.library));
  }

  /**
   * Puts all in its place, once it is made: first what moves, with its input, and two charts; then the controls and the
   * other charts. The sliders stand beside them or below the controls.
   */
  protected assemble(scene: Node[], controls: Node[], sliders: Essentials): void {
    this.sliders = sliders;
    for (const chart of this.charts) if (chart instanceof TimeChart) chart.onZoom = (range) => this.zoomTo(range);
    const step = element("button", { type: "button", "data-step": "", onclick: () => this.stepOnce() }, "Step 1 ms");
    const again = element("button", { type: "button", "data-again": "", onclick: () => this.restart() }, "Restart");
    const speed = segments("Speed", SPEEDS, 1, (value) => {
      this.clock.speed = value;
      this.isStale = true;
    });
    const transport = element("div", { class: "transport" }, this.play, step, again, this.keep, speed, this.whole, this.status);
    const [input, shape] = signalEditor(this.context.library.tables, this.context.settings.signal, this.scale, () => {
      if (this.run) this.run.isRedirected = true;
      this.context.changed();
    });
    const card = element("section", { class: "card scene" }, ...controls, shape);
    const charts = this.charts.map((chart) => chart.root);
    this.root.replaceChildren(
      element("section", { class: "card scene" }, ...scene, transport, input),
      element("section", { class: "charts first" }, ...charts.slice(0, 2)),
      card,
      element("section", { class: "charts others" }, ...charts.slice(2)),
    );
    const place = () => {
      // Beside the page, where there is room, so that the charts are in sight while a value is changed.
      if (!WIDE.matches) card.append(sliders.root);
      else byId("essentials").replaceChildren(sliders.root);
    };
    place();
    WIDE.addEventListener("change", () => this.root.isConnected && place());
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

  /** Keeps the run to be shown behind the next one, or lets it go. */
  private keepRun(): void {
    this.kept = this.kept ? null : this.run;
    this.keep.textContent = this.kept ? "Let go" : "Keep";
    if (this.kept) this.restart();
    this.isStale = true;
  }

  /** Shows a range of time, or what there is. */
  private zoomTo(range: [number, number] | null): void {
    this.zoom = range;
    this.whole.hidden = range === null;
    this.isStale = true;
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
    if (name === "friction.law") this.sliders?.show();
    if (!isLive || !this.run) {
      this.restart();
      return;
    }
    this.run.retune(model, name, value);
    this.isStale = true;
  }

  files(): Files | null {
    if (!this.run) return null;
    // Whichever file comes next has the same instant.
    if (this.isRunning) this.toggle();
    return this.filesOf(this.run);
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
    const range = this.zoom ?? [end - span, end];
    this.scene(run);
    const plots = this.plots(run, run.recording.rowAt(range[0]));
    const kept = this.kept && this.plots(this.kept, this.kept.recording.rowAt(range[0]));
    plots.forEach((plot, index) => {
      // While it runs, the charts take turns, so that a frame has time for the drawing.
      if (!this.isRunning || index % 2 === this.turn) plot.draw(range, kept?.[index]);
    });
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
