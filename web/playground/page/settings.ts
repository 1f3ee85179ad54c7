// Settings of the page, as a link restores them.

import { experiment, isSettable, model, type Tables, type Variable } from "./tables";
import { linkedOption, optionsOf, type Options } from "./fit/options";
import { rangesOf } from "./fit/table";
import { FIRST_CODE, type Result } from "./race/rules";
import { STORIES } from "./stories";
import { along, KINDS, POINTS, type Kind, type Signal } from "./signal";

export const VIEWS = ["stick-slip", "two-laws", "presliding", "closed-loop", "race", "fit"] as const;
export type View = (typeof VIEWS)[number];

export const CYLINDER = "PneumaticServoCylinder";
export const BENCH = "FrictionBench";
export const CONTROLLER = "PositionController";

/** The models of the views on which something runs, the one that moves first. */
const MODELS: Record<Exclude<View, "fit">, string[]> = {
  "stick-slip": [CYLINDER],
  "two-laws": [CYLINDER],
  presliding: [BENCH],
  "closed-loop": [CYLINDER, CONTROLLER],
  race: [CYLINDER, CONTROLLER],
};

/** The law that shows nested loops first: MaxwellSlip. */
const BENCH_LAW = 17;

/** Keys of a link whose values are numbers, besides those of variables. */
const NUMBERS = new Set(["level", "amplitude", "period", "centring", "second", "dither", "integralStop"]);

/** Begin of the keys of fixed values of a bench and of sensors. */
const GIVEN = "known.";
/** Most lines of a range of rows that are left out. */
const MOST_LINES = 1_000_000;

export type Racer = "hand" | "code";

export class Settings {
  view: View = "stick-slip";
  /** The story that is told, if one is. */
  story: string | null = null;
  /** The law that is compared with the cylinder's: SmoothCoulomb, which creeps where a set-valued law sticks. */
  secondLaw = 4;
  /** The experiment of a fit, and the parameters that are free in it; by default the usual ones of the law. */
  experiment = "rig";
  free: readonly string[] | null = null;
  /** Options of a fit that are no defaults. */
  readonly options: Options = new Map();
  /** Fixed values of a bench and of sensors by name, in SI units, which the model does not have, or has no default of. */
  readonly beside = new Map<string, number>();
  /** Lines of the table whose rows are left out, in their order. */
  leftOut: readonly number[] = [];
  /** Whether these came with a link, for a table that is not open yet. */
  isOfLink = false;
  /** Racer: the hand of the visitor, or a program. */
  racer: Racer = "hand";
  code = FIRST_CODE;
  /** Whether the program came with a link, and was not touched since. */
  isForeign = false;
  /** The result to beat, which came with a link, and the visitor's best one. */
  toBeat: Result | null = null;
  best: Result | null = null;
  /** Amplitude in V of the dither of the loop, and the error in m below which its integral part is held; 0 without. */
  dither = 0;
  integralStop = 0;
  readonly signals: Record<View, Signal>;
  /** Values that differ from the defaults, by model. */
  readonly values: Record<string, Map<string, number>> = {
    [CYLINDER]: new Map(),
    [BENCH]: new Map(),
    [CONTROLLER]: new Map(),
  };

  constructor(private readonly tables: Tables) {
    this.values[BENCH].set("friction.law", BENCH_LAW);
    const rising = Array.from({ length: POINTS }, (_, index) => (2 * index) / (POINTS - 1) - 1);
    const nested = Array.from({ length: POINTS }, (_, index) => nestedLoops(index / (POINTS - 1)));
    const voltage: Signal = { kind: "sine", level: 5, amplitude: 0.6, period: 4, points: rising, centring: 1 };
    this.signals = {
      "stick-slip": { ...voltage },
      // So slow and small that one law rests where the other creeps.
      "two-laws": { ...voltage, amplitude: 0.5, period: 8 },
      presliding: { kind: "drawn", level: 0, amplitude: 1e-5, period: 10, points: nested, centring: 0 },
      race: { ...voltage }, // these two have no input of this kind
      fit: { ...voltage },
      "closed-loop": { kind: "ramp", level: 0.25, amplitude: 0.04, period: 8, points: rising, centring: 0 },
    };
  }

  get signal(): Signal {
    return this.signals[this.view];
  }

  /** The models of the present view. */
  get models(): string[] {
    if (this.view !== "fit") return MODELS[this.view];
    return [experiment(this.tables, this.experiment).model];
  }

  /** The fragment of a link, for the present view. */
  fragment(): string {
    const link = new URLSearchParams({ ...(this.story ? { story: this.story } : {}), view: this.view });
    if (this.view === "fit") {
      link.set("experiment", this.experiment);
      if (this.free) link.set("free", this.free.join(" "));
      for (const { name } of optionsOf(this.tables, this.experiment)) if (this.options.has(name)) link.set(name, String(this.options.get(name)));
      for (const [name, value] of this.beside) link.set(`${GIVEN}${name}`, String(value));
      const lines = rangesOf(this.leftOut).map(([first, last]) => (first === last ? String(first) : `${first}-${last}`));
      if (lines.length) link.set("leftOut", lines.join(" "));
    } else if (this.view === "race") {
      const result = this.best ?? this.toBeat;
      link.set("racer", this.racer);
      if (this.racer === "code") link.set("code", this.code);
      if (result) link.set("score", `${(1e3 * result.off).toFixed(2)} mm ${result.time.toFixed(2)} s`);
    } else {
      const { kind, level, amplitude, period, points, centring } = this.signal;
      link.set("signal", kind);
      for (const [name, value] of Object.entries({ level, amplitude, period, centring })) link.set(name, String(value));
      if (kind === "drawn") link.set("points", points.map((point) => Math.round(point * 1000)).join(" "));
    }
    if (this.view === "two-laws") link.set("second", String(this.secondLaw));
    if (this.view === "closed-loop") {
      if (this.dither) link.set("dither", String(this.dither));
      if (this.integralStop) link.set("integralStop", String(this.integralStop));
    }
    for (const of of this.models) {
      // The law is always in the link, because some pages do not start with the table's default.
      const law = model(this.tables, of).variables.find(({ name }) => name === "friction.law");
      if (law) link.set(`${of}.${law.name}`, String(law.start));
      for (const [name, value] of this.values[of]) link.set(`${of}.${name}`, String(value));
    }
    return `#${link}`;
  }

  /** Takes over the fragment of a link; returns what of it could not be understood. */
  restore(fragment: string): string[] {
    const link = new URLSearchParams(fragment.replace(/^#/, ""));
    const problems: string[] = [];
    const view = VIEWS.find((candidate) => candidate === link.get("view"));
    if (!view) return link.size ? [`the link names no page of the playground: ${fragment}`] : [];
    this.view = view;
    this.story = null;
    this.dither = this.integralStop = 0;
    const signal = this.signals[view];
    // A link that states the input states the centring, too, unless there is none.
    if (link.has("signal")) signal.centring = 0;
    this.experiment = this.tables.experiments.find(({ name }) => name === link.get("experiment"))?.name ?? "rig";
    this.free = null;
    this.options.clear();
    this.beside.clear();
    this.leftOut = [];
    this.isOfLink = true;
    this.racer = "hand";
    this.toBeat = this.best = null;
    for (const of of this.models) this.forget(of);
    for (const [key, text] of link) {
      const problem = this.take(key, text, signal);
      if (problem) problems.push(problem);
    }
    return problems;
  }

  /** Back to what the page begins with. */
  forget(of: string): void {
    this.values[of].clear();
    if (of === BENCH) this.values[of].set("friction.law", BENCH_LAW);
  }

  /** Keeps a value of a model if it is not the default. */
  give(of: string, entry: Variable, value: number): void {
    if (value === entry.start) this.values[of].delete(entry.name);
    else this.values[of].set(entry.name, value);
  }

  private take(key: string, text: string, signal: Signal): string | null {
    if (key === "view") return null;
    if (key === "story") {
      this.story = STORIES.find((story) => story.key === text)?.key ?? null;
      return this.story === text ? null : `there is no story ${text}`;
    }
    if (key === "experiment" && this.view === "fit") return this.experiment === text ? null : `${text} is no experiment`;
    if (key === "free" && this.view === "fit") {
      this.free = text.split(" ").filter(Boolean);
      return null;
    }
    if (this.view === "fit") {
      const problem = this.takeOfFit(key, text);
      if (problem !== undefined) return problem;
    }
    if (key === "racer" && this.view === "race") {
      if (text === "hand" || text === "code") this.racer = text;
      return this.racer === text ? null : `${text} is no racer: hand or code`;
    }
    if (key === "code" && this.view === "race") {
      this.isForeign ||= text !== this.code;
      this.code = text;
      return null;
    }
    if (key === "score" && this.view === "race") {
      const [, off, seconds] = /^(\d+(?:\.\d+)?) mm (\d+(?:\.\d+)?) s$/.exec(text) ?? [];
      if (seconds === undefined) return `${text} is no score`;
      this.toBeat = { off: Number(off) / 1e3, time: Number(seconds) };
      return null;
    }
    if (key === "signal") {
      const kind = KINDS.find((candidate) => candidate === text);
      if (kind) signal.kind = kind as Kind;
      return kind ? null : `${text} is no kind of input`;
    }
    if (key === "points") {
      const points = text.split(" ").map((point) => Number(point) / 1000);
      const fits = points.length === POINTS && points.every((point) => Math.abs(point) <= 1);
      if (fits) signal.points = points;
      return fits ? null : `a drawing has ${POINTS} points from -1000 to 1000`;
    }
    const isKnown = NUMBERS.has(key) || this.entry(key) !== undefined;
    if (!isKnown) return `there is no variable ${key}`;
    const value = text.trim() === "" ? NaN : Number(text);
    if (!Number.isFinite(value)) return `${key} = ${text} is no number`;
    if (key === "level" || key === "amplitude" || key === "period" || key === "centring") {
      if (key === "period" && value <= 0) return `period = ${text} s must be positive`;
      signal[key] = value;
      return null;
    }
    if ((key === "dither" || key === "integralStop") && this.view === "closed-loop") {
      this[key] = Math.abs(value);
      return null;
    }
    if (key === "second") {
      this.secondLaw = value;
      return null;
    }
    const [of, known] = this.entry(key) ?? [];
    if (of && known) this.give(of, known, value);
    return null;
  }

  /** Takes over an option, a fixed value, or the rows that are left out of a fit; nothing for another key. */
  private takeOfFit(key: string, text: string): string | null | undefined {
    const option = optionsOf(this.tables, this.experiment).find(({ name }) => name === key);
    if (option) {
      try {
        this.options.set(key, linkedOption(option, text));
        return null;
      } catch (error) {
        return (error as Error).message;
      }
    }
    if (key.startsWith(GIVEN)) {
      const value = text.trim() === "" ? NaN : Number(text);
      if (!Number.isFinite(value)) return `${key} = ${text} is no number`;
      this.beside.set(key.slice(GIVEN.length), value);
      return null;
    }
    if (key !== "leftOut") return undefined;
    if (!/^\d+(-\d+)?( \d+(-\d+)?)*$/.test(text)) return `leftOut = ${text} are no lines of a table`;
    const ranges = text.split(" ").map((range) => {
      const [first, last = first] = range.split("-").map(Number);
      return { first, length: last - first + 1 };
    });
    if (ranges.some(({ length }) => length < 1 || length > MOST_LINES)) return `leftOut = ${text} are no lines of a table`;
    const lines = ranges.flatMap(({ first, length }) => Array.from({ length }, (_, place) => first + place));
    this.leftOut = [...new Set(lines)].sort((one, other) => one - other);
    return null;
  }

  /** The model and the variable that a key of a link names. */
  private entry(key: string): [string, Variable] | undefined {
    const of = this.models.find((candidate) => key.startsWith(`${candidate}.`));
    const known = of && model(this.tables, of).variables.find((entry) => `${of}.${entry.name}` === key && isSettable(entry));
    return of && known ? [of, known] : undefined;
  }
}

/** A large loop with a small one on each of its branches, from -1 to 1 over a fraction of the time. */
export function nestedLoops(fraction: number): number {
  return along([0, 0.9, -0.9, 0.4, -0.2, 1, -0.4, 0.2, -1, 0.5, -0.5], fraction);
}
