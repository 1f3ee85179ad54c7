// Columns of a table as signals, in SI units.

import type { Tables } from "../tables";
import type { Table } from "./table";
import { TableError } from "./table";
import { SIGNALS, type Signal } from "./signals";
import { plain, toSi, unitsOf, type Scale } from "../units";

/** A column, its unit, and whether its sign is the opposite of ours. */
export interface Column {
  place: number;
  unit: string;
  turned: boolean;
}

export type Columns = Map<Signal, Column>;

/** Names that are usual for a signal beside its own, in English and German; a unit may follow behind a low line. */
const NAMES: Record<Signal, RegExp> = {
  time: /^(t|time|zeit)$/i,
  position: /^(x|pos|position|stroke|displacement|piston[\s_-]?position|weg|hub|kolbenweg)$/i,
  velocity: /^(v|vel|velocity|speed|geschwindigkeit)$/i,
  frictionForce: /^(ff|f_f|friction|friction[\s_-]?force|reibung|reibkraft)$/i,
  force: /^(f|force|kraft)$/i,
  normalForce: /^(fn|f_n|normal[\s_-]?force|normalkraft)$/i,
  pressure: /^(p|pressure|druck)$/i,
  valveVoltage: /^(u|voltage|valve[\s_-]?(voltage|signal|command)|control[\s_-]?voltage|spannung|ventilspannung)$/i,
  supplyPressure: /^(ps|p_s|supply|supply[\s_-]?pressure|versorgungsdruck)$/i,
  externalForce: /^(fext|f_ext|external[\s_-]?force|externe[\s_-]?kraft)$/i,
  "chamberA.pressure": chamber("a|1"),
  "chamberB.pressure": chamber("b|2"),
};

/** Names of the pressure of one chamber, which have its letter or its number. */
function chamber(which: string): RegExp {
  return new RegExp(
    `^(p[\\s_-]?(${which})|(pressure|druck)[\\s_-]?(${which})|(chamber|kammer)[\\s_-]?(${which})([\\s_-]?(pressure|druck))?)$`,
    "i",
  );
}

/** The unit that a table writes for a column, if it is one of a signal. */
export function writtenUnit(tables: Tables, table: Table, place: number, signal: Signal): string | null {
  const unit = table.units[place] ?? null;
  return unit !== null && unitsOf(tables, SIGNALS[signal]).has(plain(tables.spellings, unit)) ? plain(tables.spellings, unit) : null;
}

/** Signals of an experiment by the names of the columns; no column is taken twice. */
export function proposed(tables: Tables, table: Table, signals: readonly Signal[]): Columns {
  const found: Columns = new Map();
  const taken = new Set<number>();
  const take = (signal: Signal, matches: (name: string, place: number) => string | null) => {
    if (found.has(signal)) return;
    for (const [place, name] of table.names.entries()) {
      const unit = taken.has(place) ? null : matches(name, place);
      if (unit === null) continue;
      found.set(signal, { place, unit, turned: false });
      taken.add(place);
      return;
    }
  };
  const unitAt = (place: number, signal: Signal) => writtenUnit(tables, table, place, signal) ?? SIGNALS[signal];
  for (const signal of signals) take(signal, (name, place) => (name === signal ? unitAt(place, signal) : null));
  for (const signal of signals) take(signal, (name, place) => (NAMES[signal].test(name.trim()) ? unitAt(place, signal) : null));
  for (const signal of signals) {
    take(signal, (name) => {
      const [, bare, unit] = /^(.+)_([^_]+)$/.exec(name) ?? [];
      const isOne = unit && NAMES[signal].test(bare.trim()) && unitsOf(tables, SIGNALS[signal]).has(plain(tables.spellings, unit));
      return isOne ? plain(tables.spellings, unit) : null;
    });
  }
  return found;
}

/** The scale of a signal: `pressure` of a test bench counts above ambient, so that a gauge unit of it has no offset, and one above vacuum has. */
export const scaleOf = (signal: Signal, { factor, offset, offsetAboveAmbient }: Scale): Pick<Scale, "factor" | "offset"> => ({
  factor,
  offset: signal === "pressure" ? offsetAboveAmbient : offset,
});

/** The chosen columns in SI units; throws an error that names the line where time does not rise. */
export function signalsOf(tables: Tables, table: Table, columns: Columns): Map<Signal, Float64Array> {
  const found = new Map<Signal, Float64Array>();
  for (const [signal, { place, unit, turned }] of columns) {
    const scale = unitsOf(tables, SIGNALS[signal]).get(unit);
    if (!scale) throw new TableError(`${table.file}: ${unit} is no unit of ${signal}`);
    found.set(signal, toSi(table.columns[place], scaleOf(signal, scale), turned));
  }
  const time = columns.get("time");
  if (time) checkTime(table, time);
  return found;
}

function checkTime(table: Table, { place, unit, turned }: Column): void {
  const times = table.columns[place];
  for (let row = 1; row < times.length; row += 1) {
    const isRising = turned ? times[row] < times[row - 1] : times[row] > times[row - 1];
    if (isRising) continue;
    throw new TableError(
      `${table.file}:${table.lines[row]}, column ${table.names[place]}: time must rise, ` +
        `but ${times[row]} ${unit} follows ${times[row - 1]} ${unit}`,
    );
  }
}
