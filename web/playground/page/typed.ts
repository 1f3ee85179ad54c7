// Typed numbers: "6 bar", "0,5", "1e-3".

import type { DisplayUnit } from "./tables";

/** Typed text that is no value; the message says why, and what would be one. */
export class Mistyped extends Error {}

const NUMBER = /^([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:e[+-]?\d+)?)\s*(.*)$/i;

/** Where a number without a unit is plausible. */
export interface Plausible {
  /** The largest magnitude, in the unit that is meant. */
  largest: number;
  /** The range in words. */
  range: string;
}

/** The value in a unit of a text with or without one; `spelled` gives a unit its own spelling. Throws `Mistyped`. */
export function typed(text: string, unit: string, others: readonly DisplayUnit[], spelled = (name: string) => name, plausible?: Plausible): number {
  const quoted = `“${text.trim()}”`;
  const match = NUMBER.exec(text.trim().replace("−", "-"));
  if (!match) throw new Mistyped(`${quoted} is no number`);
  const value = Number(match[1].replace(",", "."));
  if (!Number.isFinite(value)) throw new Mistyped(`${quoted} is too large`);
  const name = match[2].trim();
  if (name === "" && unit !== "" && plausible && Math.abs(value) > plausible.largest) {
    throw new Mistyped(`${quoted} has no unit and would be ${value} ${unit}, far beyond ${plausible.range}: write the unit, say ${value} ${unit}`);
  }
  if (name === "" || name === unit || spelled(name) === unit) return value;
  const other = others.find((candidate) => candidate.name === name) ?? others.find((candidate) => candidate.name === spelled(name));
  if (other) return Number(((value - other.offset) / other.factor).toPrecision(15));
  const units = [unit, ...others.map((candidate) => candidate.name)].filter((candidate) => candidate !== "1" && candidate !== "");
  const right = units.length ? `its unit is ${units.slice(0, -1).join(", ")}${units.length > 1 ? " or " : ""}${units.at(-1)}` : "it has no unit";
  throw new Mistyped(`${quoted}: ${name} does not fit, ${right}`);
}

/** A refusal of a value, which says what was typed where the value is written in another way, say in another unit. */
export function quoting(text: string, refusal: string): string {
  return refusal.includes(` ${text.trim()} `) ? refusal : `“${text.trim()}”: ${refusal}`;
}
