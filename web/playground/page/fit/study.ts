// The state of a fit on the page: table, choices and result.

import type { Context } from "../context";
import { byId } from "../dom";
import { unpacked, type Estimable } from "../library";
import { experiment, model, variable } from "../tables";
import { problemOf, proposed, type Columns } from "./columns";
import type { Finding } from "./findings";
import type { Answer, Progress, Question } from "./fit";
import { begin, type Reply } from "./job";
import { optionsOf, type Option } from "./options";
import type { Signal } from "./signals";
import { without, type Table } from "./table";

/** An answer with its question, its table and the columns of the signals. */
export interface Found {
  answer: Answer;
  question: Question;
  columns: Columns;
  table: Table;
  /** Units of parameters by name. */
  units: Record<string, string>;
  /** Lines of the file whose rows were left out. */
  leftOut: readonly number[];
}

/** Work in progress. */
export type Work = { kind: "none" } | { kind: "reading" } | { kind: "fitting"; progress: Progress | null };

/** The file that comes with the page, its machine, and what is free of it in the documentation. */
const EXAMPLE = {
  file: "rig.csv",
  supply: 6e5,
  free: ["Fs", "Fc", "vs", "sigma2"].map((name) => `friction.stribeck.${name}`).concat("valve.deadZone", "valve.C"),
  law: "Stribeck",
};

/** Objects that the parts of the fit share. */
export interface FitContext extends Context {
  /** The data and the fit, which outlast a look at another page. */
  study: Study;
}

export class Study {
  /** The table with all of its rows. */
  private whole: Table | null = null;
  /** The table without the rows of some lines. */
  private kept: { whole: Table | null; lines: readonly number[]; table: Table | null } = { whole: null, lines: [], table: null };
  columns: Columns = new Map();
  /** Units in which parameters of the machine are asked for. */
  readonly units = new Map<string, string>();
  work: Work = { kind: "none" };
  problem: string | null = null;
  /** Findings about the record under the present columns and settings, as soon as they are known. */
  findings: readonly Finding[] = [];
  /** The last fit, with what was asked. */
  found: Found | null = null;
  /** View of all this. */
  shown: () => void = () => {};
  /** What is called when the findings about the record are known, of which the fields of the page are independent. */
  informed: () => void = () => {};
  /** View of the progress. */
  progressed: () => void = () => {};
  private end: () => void = () => {};
  /** What the findings were asked for, as a text, and what ends the check. */
  private checked = "";
  private endCheck: () => void = () => {};

  constructor(readonly context: Context) {}

  /** The table without the rows that are left out. */
  get table(): Table | null {
    const { whole } = this;
    const lines = this.context.settings.leftOut;
    if (this.kept.whole !== whole || this.kept.lines !== lines) this.kept = { whole, lines, table: whole && without(whole, lines) };
    return this.kept.table;
  }

  /** To be called when something has changed that a link restores: it is shown. */
  changed(): void {
    this.context.changed();
    this.shown();
  }

  get modelName(): string {
    return this.context.settings.models[0];
  }

  /** The number of the law. */
  get law(): number {
    const { settings, library } = this.context;
    const entry = variable(model(library.tables, this.modelName), "friction.law");
    return settings.values[this.modelName].get(entry.name) ?? entry.start ?? 0;
  }

  /** Fixed values, and starts of estimated ones, of the model, of its bench and of its sensors. */
  get known(): Map<string, number> {
    const own = [...this.context.settings.values[this.modelName]].filter(([name]) => name !== "friction.law");
    return new Map([...own, ...this.context.settings.beside]);
  }

  /** Fixed values of sensors, and others that the machine's fields do not show. */
  get unseen(): [string, number][] {
    const { bench, lacking } = this.estimable;
    const isSensor = (name: string) => /^(gain|offset|delay|lag)\./.test(name);
    return [...this.context.settings.beside].filter(([name]) => !(name in bench) && (lacking === null || isSensor(name)));
  }

  /** Checks the record if columns or settings have changed since it was checked. */
  check(): void {
    const { table, columns, law, known } = this;
    const { experiment } = this.context.settings;
    const asked = table ? JSON.stringify([table.file, table.lines.length, [...columns], experiment, law, [...known]]) : "";
    if (asked === this.checked) return;
    this.endCheck();
    this.checked = asked;
    this.findings = [];
    if (!table) return;
    const { module } = this.context.library;
    this.endCheck = begin({ kind: "check", module, table, columns, experiment, law, known }, (reply) => {
      this.endCheck = () => {};
      if (reply.kind === "problem") this.problem = reply.text;
      if (reply.kind === "findings") this.findings = reply.findings;
      this.informed();
    });
  }

  /** Estimated parameters: the chosen ones, or the usual ones under the law. */
  get free(): readonly string[] {
    return this.context.settings.free ?? this.usual();
  }

  usual(): string[] {
    return this.estimable.usual;
  }

  /** Parameters that may be estimated from the columns that are chosen. */
  get estimable(): Estimable {
    const { settings, library } = this.context;
    return library.estimable(settings.experiment, this.law, this.known, this.unitsOfColumns);
  }

  /** Units of the columns by their signals. */
  private get unitsOfColumns(): Map<Signal, string> {
    return new Map([...this.columns].map(([signal, { unit }]) => [signal, unit]));
  }

  /** Frees a parameter, or no longer does. */
  setFree(name: string, isFree: boolean): void {
    const others = this.free.filter((other) => other !== name);
    this.context.settings.free = isFree ? [...others, name] : others;
    this.context.changed();
  }

  /** Under another law its own parameters are free; what is none of a law stays. */
  lawChanged(): void {
    const { settings, library } = this.context;
    if (!settings.free) return;
    const of = model(library.tables, this.modelName);
    const ofOtherLaws = of.variables.filter(({ countsFor: it }) => it?.choice === "friction.law" && it.item !== this.law);
    const others = settings.free.filter((free) => !ofOtherLaws.some(({ name }) => name === free));
    settings.free = [...new Set([...this.usual(), ...others])];
  }

  choose(name: string): void {
    const { settings } = this.context;
    settings.experiment = name;
    settings.free = null;
    settings.beside.clear();
    this.found = null;
    this.propose();
    this.context.changed();
  }

  /** Takes over the columns that their names tell. */
  propose(): void {
    const { settings, library } = this.context;
    this.columns = this.table ? proposed(library, this.table, experiment(library.tables, settings.experiment).signals) : new Map();
    this.problem = this.table && problemOf(library, this.table, this.columns);
  }

  /** Reads a file. What a link says of sensors and rows is for the first one. */
  open(file: File): void {
    const { settings } = this.context;
    this.cancel();
    if (!settings.isOfLink) {
      for (const [name] of this.unseen) settings.beside.delete(name);
      settings.leftOut = [];
      this.context.changed();
    }
    settings.isOfLink = false;
    this.whole = null;
    this.found = null;
    this.findings = [];
    this.problem = null;
    this.work = { kind: "reading" };
    this.end = begin({ kind: "read", module: this.context.library.module, file }, (reply) => this.take(reply, null));
    this.shown();
  }

  /** Opens the file that comes with the page, under the settings that it was made for. */
  async example(): Promise<void> {
    const { settings, library } = this.context;
    settings.experiment = "rig";
    settings.isOfLink = false;
    const [of] = settings.models;
    const law = library.tables.enumerations.FrictionLaw.items.find(({ name }) => name === EXAMPLE.law);
    const cylinder = model(library.tables, of);
    settings.give(of, variable(cylinder, "friction.law"), law?.id ?? 0);
    settings.give(of, variable(cylinder, "supplyPressure"), EXAMPLE.supply);
    settings.free = EXAMPLE.free;
    const bytes = await unpacked((byId("example").textContent ?? "").trim());
    this.open(new File([bytes], EXAMPLE.file));
    this.context.changed();
    this.context.open();
  }

  /** Reason why the fit cannot be started, or null. */
  get obstacle(): string | null {
    if (!this.table) return "open a table first";
    if (this.free.length === 0) return "nothing is free: choose at least one parameter";
    const { lacking, units } = this.estimable;
    const stranger = [...this.context.settings.beside.keys()].find((name) => !lacking && !(name in units));
    if (stranger !== undefined) return `${stranger} has no part in this experiment`;
    return lacking ?? this.findings.find(({ refused }) => refused)?.text ?? null;
  }

  /** Fits. */
  start(): void {
    if (!this.table) return;
    const { settings, library } = this.context;
    const asked = { table: this.table, columns: new Map(this.columns), leftOut: settings.leftOut, units: this.estimable.units };
    this.problem = null;
    try {
      const { signals, others } = library.tableSignals(this.table, this.columns);
      const { law, free, known } = this;
      const of = experiment(library.tables, settings.experiment);
      const value = ({ name, usual }: Option) => settings.options.get(name) ?? usual;
      const [validation, starts] = optionsOf(library.tables, of.name).map((option) => Number(value(option)));
      const chosen = of.options.map((option) => [option.name, value(option)] as const);
      const options = Object.fromEntries(chosen.flatMap(([name, own]) => (own === null ? [] : [[name, own]])));
      const units = this.unitsOfColumns;
      const question: Question = { file: this.table.file, experiment: of.name, law, signals, units, known, free, validation, starts, options };
      if (others.length) {
        this.problem = `${others.join(", ")}: read at other times than time; commands are held and readings run on straight lines between their samples.`;
      }
      this.found = null;
      this.work = { kind: "fitting", progress: null };
      const request = { kind: "fit", module: library.module, question } as const;
      this.end = begin(request, (reply) => this.take(reply, { ...asked, question }));
    } catch (error) {
      this.problem = (error as Error).message;
    }
    this.shown();
  }

  /** Ends what is being done. */
  cancel(): void {
    if (this.work.kind === "none") return;
    this.end();
    const best = this.work.kind === "fitting" ? Object.entries(this.work.progress?.best ?? {}) : [];
    const values = best.map(([name, value]) => `${name} = ${Number(value.toPrecision(5))}`).join(", ");
    this.problem = values ? `The fit was cancelled. Best so far: ${values}` : "It was cancelled.";
    this.work = { kind: "none" };
    this.shown();
  }

  private take(reply: Reply, asked: Omit<Found, "answer"> | null): void {
    if (reply.kind === "progress") {
      this.work = { kind: "fitting", progress: reply.progress };
      this.progressed();
      return;
    }
    this.work = { kind: "none" };
    if (reply.kind === "problem") this.problem = reply.text;
    if (reply.kind === "table") {
      this.whole = reply.table;
      this.propose();
    }
    if (reply.kind === "answer" && asked) this.found = { answer: reply.answer, ...asked };
    this.shown();
  }
}
