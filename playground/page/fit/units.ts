// Units of measured columns: the library's, and a few more that recorders write.

import type { Tables } from "../tables";

/** The value in SI units is `factor * value + offset`. */
export interface Scale {
  factor: number;
  offset: number;
}

const AMBIENT = 101_325;

/** By SI unit; what the library shows values in is not repeated here. */
const FURTHER: Record<string, Record<string, Scale>> = {
  s: { us: { factor: 1e-6, offset: 0 }, min: { factor: 60, offset: 0 } },
  m: { cm: { factor: 1e-2, offset: 0 }, um: { factor: 1e-6, offset: 0 }, in: { factor: 0.0254, offset: 0 } },
  "m/s": { "in/s": { factor: 0.0254, offset: 0 }, "ft/s": { factor: 0.3048, offset: 0 } },
  N: {
    kN: { factor: 1e3, offset: 0 },
    mN: { factor: 1e-3, offset: 0 },
    lbf: { factor: 0.45359237 * 9.80665, offset: 0 },
  },
  Pa: {
    hPa: { factor: 1e2, offset: 0 },
    mbar: { factor: 1e2, offset: 0 },
    kPa: { factor: 1e3, offset: 0 },
    MPa: { factor: 1e6, offset: 0 },
    psi: { factor: 6894.757293168361, offset: 0 },
    // Above the standard atmosphere; all others are absolute.
    barg: { factor: 1e5, offset: AMBIENT },
    kPag: { factor: 1e3, offset: AMBIENT },
    psig: { factor: 6894.757293168361, offset: AMBIENT },
  },
  V: { mV: { factor: 1e-3, offset: 0 } },
};

const SPELLINGS: [string, string][] = [
  [" ", ""],
  ["(g)", "g"],
  ["\u00b5", "u"],
  ["\u03bc", "u"],
  ["\u00b7", "."],
  ["*", "."],
];

/** The units of an SI unit by name, itself first. */
export function unitsOf(tables: Tables, si: string): Map<string, Scale> {
  const found = new Map<string, Scale>([[si, { factor: 1, offset: 0 }]]);
  for (const { name, factor, offset } of tables.units[si]?.display ?? []) {
    // The library shows `factor * SI + offset`.
    found.set(name, { factor: 1 / factor, offset: offset === 0 ? 0 : -offset / factor });
  }
  for (const [name, scale] of Object.entries(FURTHER[si] ?? {})) found.set(name, scale);
  return found;
}

/** The name in the table of a unit as people write it. */
export const plain = (unit: string): string =>
  SPELLINGS.reduce((name, [other, own]) => name.replaceAll(other, own), unit.trim());

/** Turns values into SI units; a thousandth is a quotient, so that 250 mm are 0.25 m. */
export function toSi(values: Float64Array, { factor, offset }: Scale, turned: boolean): Float64Array {
  const inverse = Math.round(1 / factor);
  const isExact = factor < 1 && Math.abs(inverse * factor - 1) < 1e-14;
  const sign = turned ? -1 : 1;
  return values.map((value) => sign * ((isExact ? value / inverse : value * factor) + offset));
}

/** Everything that is a unit. */
export function everyUnit(tables: Tables): string[] {
  const shown = Object.entries(tables.units).flatMap(([si, { display }]) => [si, ...display.map(({ name }) => name)]);
  return [...shown, ...Object.values(FURTHER).flatMap((units) => Object.keys(units))].filter((name) => name !== "1");
}
