// The variable tables of the models, as the library states them.

export interface DisplayUnit {
  name: string;
  factor: number;
  offset: number;
}

export interface Unit {
  display: DisplayUnit[];
}

/** A unit as people write it: `SI = factor * written + offset`. */
export interface WrittenUnit {
  name: string;
  si: string;
  factor: number;
  offset: number;
}

/** An experiment that a fit is made of. */
export interface Experiment {
  name: string;
  about: string;
  /** The model whose parameters are known or estimated. */
  model: string;
  /** The signals that it takes, in the order in which they are offered. */
  signals: string[];
  /** Parameters that each machine has of its own. */
  machine: string[];
  /** The options of the use of the data that act in it. */
  options: FitOption[];
  /** Other SI units that its signals may have, of a machine that rotates and of a motor's current. */
  also: Record<string, string[]>;
}

/** An option of a fit: a number, or one of items. */
export interface FitOption {
  name: string;
  about: string;
  /** The default in SI units; null where the data or the experiment choose. */
  usual: number | null;
  /** The unit in which a number is written, and its SI unit; null without. */
  unit: string | null;
  si: string | null;
  isPositive: boolean;
  items: string[] | null;
}

/** Other spellings of parts of units and of whole units, and their own. */
export interface Spellings {
  parts: [string, string][];
  whole: [string, string][];
}

export interface Item {
  id: number;
  name: string;
  description: string;
}

export interface Variable {
  name: string;
  kind: "Real" | "Integer" | "Boolean" | "Enumeration";
  /** The unit or the enumeration. */
  of: string | null;
  role: "time" | "input" | "fixed" | "tunable" | "output" | "local";
  description: string;
  start: number | null;
  min: number | null;
  max: number | null;
  display: string | null;
  /** The enumeration and the id of its item for which alone a parameter counts. */
  countsFor: { choice: string; item: number } | null;
}

/** Course of an input. */
export type Course =
  | { Sine: { mean: number; amplitude: number; frequency: number; delay: number } }
  | { Steps: [number, number][] };

export interface Model {
  name: string;
  description: string;
  /** The default experiment, with the inputs that move in it. */
  experiment: { stop_time: number; step_size: number; signals: { input: string; text: string; course: Course }[] };
  variables: Variable[];
}

export interface Tables {
  version: string;
  models: Model[];
  units: Record<string, Unit>;
  /** SI units of the signals that can be measured. */
  signals: Record<string, string>;
  experiments: Experiment[];
  written: WrittenUnit[];
  spellings: Spellings;
  enumerations: Record<string, { description: string; items: Item[] }>;
}

/** A variable that a user may set before the start. */
export const isSettable = (variable: Variable): boolean =>
  variable.role === "input" || variable.role === "fixed" || variable.role === "tunable";

/** A variable that a user may set while the model runs. */
export const isLive = (variable: Variable): boolean => variable.role === "input" || variable.role === "tunable";

/** The group of a structured name: all before its last dot. */
export const group = (name: string): string => name.slice(0, Math.max(name.lastIndexOf("."), 0));

/** The group of the parameters of a friction law, for example `friction.lugre`; empty for a law that has none. */
export const lawGroup = (of: Model, law: number): string =>
  group(of.variables.find(({ countsFor: it }) => it?.choice === "friction.law" && it.item === law)?.name ?? "");

export function model(tables: Tables, name: string): Model {
  const found = tables.models.find((candidate) => candidate.name === name);
  if (!found) throw new Error(`there is no model ${name}`);
  return found;
}

export function experiment(tables: Tables, name: string): Experiment {
  const found = tables.experiments.find((candidate) => candidate.name === name);
  if (!found) throw new Error(`there is no experiment ${name}`);
  return found;
}

export function variable(of: Model, name: string): Variable {
  const found = of.variables.find((candidate) => candidate.name === name);
  if (!found) throw new Error(`${of.name} has no variable ${name}`);
  return found;
}

/** The items of a variable's enumeration. */
export const items = (tables: Tables, of: Variable): Item[] =>
  (of.kind === "Enumeration" && of.of && tables.enumerations[of.of]?.items) || [];

/** The items of the friction laws. */
export const laws = (tables: Tables): Item[] => tables.enumerations.FrictionLaw.items;

export const lawName = (tables: Tables, id: number): string =>
  laws(tables).find((law) => law.id === id)?.name ?? String(id);

/** The unit that a variable is best looked at in. */
export function displayUnit(tables: Tables, of: Variable): DisplayUnit {
  const unit = of.kind === "Real" && of.of ? tables.units[of.of] : undefined;
  const shown = unit?.display.find((candidate) => candidate.name === of.display);
  return shown ?? { name: of.kind === "Real" && of.of !== "1" ? (of.of ?? "") : "", factor: 1, offset: 0 };
}

/** A number with a maximum of digits, without needless zeros. */
export function short(value: number, digits = 4): string {
  const text = Number(value.toPrecision(digits));
  return Math.abs(text) >= 1e-3 && Math.abs(text) < 1e6 ? String(text) : text === 0 ? "0" : text.toExponential();
}
