// What is free in a fit: names, starts, bounds, and how the solver sees them.

import { lawGroup, model, type Model, type Tables, type Variable } from "../tables";
import { FitError } from "./measured";
import { SIGNALS, type Signal } from "./signals";

/** Without bounds a positive parameter may be so many times smaller or larger than its start. */
const SPAN = 1e3;
/** Magnitudes of the offsets of sensors, by SI unit. */
const OFFSETS: Record<string, number> = { m: 1e-4, N: 1, Pa: 1e3, "m/s": 1e-2, V: 0.1 };

/** A free parameter in SI units; a start that only the data tell is NaN. */
export interface Free {
  name: string;
  unit: string;
  start: number;
  low: number;
  high: number;
  /** Magnitude of its changes; 0 for a parameter whose logarithm is free. */
  scale: number;
  isGiven: boolean;
  /** Smallest and largest value that the model accepts. */
  legal: [number, number];
}

export const isLogarithmic = (free: Free): boolean => free.scale === 0;
export const inner = (free: Free, value: number): number => (isLogarithmic(free) ? Math.log(value) : value / free.scale);
export const outer = (free: Free, value: number): number => (isLogarithmic(free) ? Math.exp(value) : value * free.scale);

/** The bounds as the solver sees them. */
export function bounds(free: Free): [number, number] {
  const of = (bound: number) => (!isLogarithmic(free) ? bound / free.scale : bound > 0 ? Math.log(bound) : -Infinity);
  return [of(free.low), of(free.high)];
}

/** The same with a start that the data tell, within the bounds; those of a logarithm move along. */
export function at(free: Free, start: number): Free {
  if (free.isGiven || !Number.isFinite(start)) return free;
  let { low, high } = free;
  if (isLogarithmic(free)) {
    if (start <= 0) return free;
    low = Math.max(free.legal[0], Math.min(low, start / SPAN));
    high = Math.min(free.legal[1], Math.max(high, start * SPAN));
  }
  return { ...free, start: Math.min(Math.max(start, low), high), low, high };
}

/** A parameter, or what a sensor does, with the start that the visitor has given, if any. */
export function freeOf(
  tables: Tables,
  of: Model,
  name: string,
  given: number | undefined,
  compared: readonly Signal[],
  driving: readonly Signal[],
): Free {
  const free = ofSensor(name, compared, driving) ?? ofModel(tables, of, name);
  if (given === undefined) return free;
  if (given < free.legal[0] || given > free.legal[1]) throw new FitError(`${name}: the start ${given} is not legal`);
  if (isLogarithmic(free) && given > 0) {
    const isUsual = free.low <= given && given <= free.high;
    const [least, most] = isUsual ? [free.low, free.high] : free.legal;
    return { ...free, start: given, isGiven: true, low: Math.max(least, given / SPAN), high: Math.min(most, given * SPAN) };
  }
  if (!isLogarithmic(free)) return { ...free, start: given, isGiven: true };
  return { ...free, start: given, isGiven: true, scale: Math.max(Math.abs(free.high), 1e-300), low: Math.min(free.low, 0) };
}

function ofSensor(name: string, compared: readonly Signal[], driving: readonly Signal[]): Free | null {
  const [, kind, signal] = /^(gain|offset|delay)\.(.+)$/.exec(name) ?? [];
  if (!kind) return null;
  const there = kind === "delay" ? compared : [...compared, ...driving];
  if (!there.some((known) => known === signal)) {
    const place = kind === "delay" ? "compared" : "compared or driving";
    throw new FitError(`${name}: ${signal} is not ${place} here, only ${there.join(", ")}`);
  }
  const unit = SIGNALS[signal as Signal];
  const none: [number, number] = [-Infinity, Infinity];
  const common = { name, isGiven: false, legal: none };
  if (kind === "delay") return { ...common, unit: "s", start: 0, low: -0.5, high: 0.5, scale: 0.02, legal: [-0.5, 0.5] };
  if (kind === "gain") return { ...common, unit: "1", start: 1, low: -Infinity, high: Infinity, scale: 1 };
  return { ...common, unit, start: 0, low: -Infinity, high: Infinity, scale: OFFSETS[unit] };
}

function ofModel(tables: Tables, of: Model, name: string): Free {
  if (name === "area" && of.name === "FrictionBench") {
    const none: [number, number] = [-Infinity, Infinity];
    return { name, unit: "m2", start: NaN, low: -Infinity, high: Infinity, scale: 1e-4, isGiven: false, legal: none };
  }
  // The seal under pressure has it, too; the bench gets the load level that it makes.
  const isOfSeal = name === "friction.kappaA" && !of.variables.some((entry) => entry.name === name);
  const variables = isOfSeal ? model(tables, "PneumaticServoCylinder").variables : of.variables;
  const found = variables.find((entry) => entry.name === name);
  if (!found) throw new FitError(`there is no parameter ${name} of ${of.name}`);
  return ofVariable(found);
}

function ofVariable({ name, kind, role, start, min, max, of }: Variable): Free {
  if ((role !== "fixed" && role !== "tunable") || kind !== "Real" || start === null) {
    throw new FitError(`${name} is no real parameter, so that it cannot be fitted`);
  }
  const unit = of ?? "1";
  const legal: [number, number] = [min ?? -Infinity, max ?? Infinity];
  const common = { name, unit, start, isGiven: false, legal };
  // Viscous friction, heat transfer and the like may well be 0, which has no logarithm.
  if (legal[0] >= 0 && start > 0 && unit !== "N.s/m" && unit !== "W/(m2.K)" && legal[1] > 1) {
    return { ...common, low: Math.max(legal[0], start / SPAN), high: Math.min(legal[1], start * SPAN), scale: 0 };
  }
  return { ...common, low: legal[0], high: legal[1], scale: Math.abs(start) || (unit === "1/Pa" ? 1e-6 : 1) };
}

/**
 * The parameters of a law that a fit usually frees: forces, stiffnesses, dampings, velocities and lengths; of elements those
 * that there are; of GMS their shares; of Dahl and Leuven the exponent. Forces that are 0 by default stay as they are.
 */
export function usual(of: Model, law: number, known: ReadonlyMap<string, number>): string[] {
  const group = `${lawGroup(of, law)}.`;
  const elements = of.variables.find((entry) => entry.name === `${group}N`);
  const number = elements ? (known.get(elements.name) ?? elements.start ?? 0) : 0;
  const units = ["N", "N/m", "N.s/m", "m/s", "1/m", "m"];
  const names = of.variables
    .filter(({ name, of: unit, role, kind, start }) => {
      if (!name.startsWith(group) || kind !== "Real" || (role !== "fixed" && role !== "tunable")) return false;
      const hasNoUnit = name.startsWith(`${group}alpha[`) || name === `${group}n`;
      if ((!units.includes(unit ?? "") && !hasNoUnit) || name.endsWith("stribeck.FsInf")) return false;
      const element = /\[(\d+)\]/.exec(name);
      if (element && Number(element[1]) > number) return false;
      return !(start === 0 && (element || unit === "N"));
    })
    .map(({ name }) => name);
  // The shares multiply the level, so that one of both stays as it is.
  return names.filter((name) => !(names.includes(`${group}alpha[1]`) && name === `${group}Fc`));
}
