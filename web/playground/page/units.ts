// Units in which people write values, from the table of the library.

import type { DisplayUnit, Spellings, Tables } from "./tables";

/** The value in SI units is `factor * value + offset`. */
export interface Scale {
  factor: number;
  offset: number;
}

/** The same for readings of a signal: the SI unit, and the unit as the table of the library spells it. */
export interface SignalScale extends Scale {
  si: string;
  name: string;
}

/** The units of an SI unit by name, itself first, then those in which the library shows values. */
export function unitsOf({ units, written }: Tables, si: string): Map<string, Scale> {
  const own = written.filter((unit) => unit.si === si);
  const shown = (units[si]?.display ?? []).map(({ name }) => name);
  const order = (name: string) => (name === si ? -1 : shown.includes(name) ? shown.indexOf(name) : shown.length);
  const found = new Map<string, Scale>([[si, { factor: 1, offset: 0 }]]);
  for (const unit of own.sort((one, other) => order(one.name) - order(other.name))) found.set(unit.name, unit);
  return found;
}

/** Units in which a value may be typed where it is shown in one of them: how they are turned into that one. */
export function typedAs(tables: Tables, si: string, { name: shown, factor, offset }: DisplayUnit): DisplayUnit[] {
  const others = [...unitsOf(tables, si)].filter(([name]) => name !== shown && name !== "1");
  return others.map(([name, unit]) => {
    const whole = factor * unit.factor;
    return { name, factor: 1 / whole, offset: -(factor * unit.offset + offset) / whole };
  });
}

/** The name in the table of a unit as people write it. */
export function plain({ parts, whole }: Spellings, unit: string): string {
  const name = parts.reduce((text, [other, own]) => text.replaceAll(other, own), unit.trim());
  return whole.find(([other]) => other === name)?.[1] ?? name;
}

/** Turns values into SI units; a thousandth is a quotient, so that 250 mm are 0.25 m. */
export function toSi(values: Float64Array, { factor, offset }: Scale, turned: boolean): Float64Array {
  const inverse = Math.round(1 / factor);
  const isExact = factor < 1 && Math.abs(inverse * factor - 1) < 1e-14;
  const sign = turned ? -1 : 1;
  return values.map((value) => sign * ((isExact ? value / inverse : value * factor) + offset));
}
