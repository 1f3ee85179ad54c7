// Columns of a table as signals, in SI units.

import type { Library } from "../library";
import type { Tables } from "../tables";
import type { Table } from "./table";
import { TableError } from "./table";
import { SIGNALS, type Signal } from "./signals";
import { plain, unitsOf, type Scale } from "../units";

/** A column, its unit, and whether its sign is the opposite of ours. */
export interface Column {
  place: number;
  unit: string;
  turned: boolean;
}

export type Columns = Map<Signal, Column>;

/** The name of a unit of a signal, however it is spelled; null if it is none. */
const knownUnit = (tables: Tables, unit: string, signal: Signal): string | null => {
  const name = plain(tables.spellings, unit);
  return unitsOf(tables, SIGNALS[signal]).has(name) ? name : null;
};

/** The unit that a table writes for a column, if it is one of a signal. */
export function writtenUnit(tables: Tables, table: Table, place: number, signal: Signal): string | null {
  const unit = table.units[place] ?? null;
  return unit === null ? null : knownUnit(tables, unit, signal);
}

/** Signals of an experiment by the names of the columns; no column is taken twice. */
export function proposed(library: Library, table: Table, signals: readonly Signal[]): Columns {
  const column = ([signal, place, unit]: [Signal, number, string | null]): [Signal, Column] => {
    const known = unit === null ? null : knownUnit(library.tables, unit, signal);
    return [signal, { place, unit: known ?? SIGNALS[signal], turned: false }];
  };
  return new Map(library.proposedColumns(table, signals).map(column));
}

/** What is wrong with the chosen columns as the table writes them: no numbers, or a unit that is not known; null if nothing is. */
export function problemOf(library: Library, table: Table, columns: Columns): string | null {
  for (const [signal, { place }] of columns) {
    const fault = table.gaps.has(place) ? undefined : table.faults.get(place);
    if (fault !== undefined) return fault;
    const unit = table.units[place] ?? null;
    // Behind a pressure it is a chamber.
    if (unit === null || unit === "A" || knownUnit(library.tables, unit, signal) !== null) continue;
    const where = `${table.file}:${table.first}, column ${place + 1} (${table.names[place]})`;
    const known = [...unitsOf(library.tables, SIGNALS[signal]).keys()].join(", ");
    return `${where}: the unit ${unit} is no known one of ${signal}; choose one of ${known}`;
  }
  return null;
}

/** The scale of a signal: `pressure` of a test bench counts above ambient, so that a gauge unit of it has no offset, and one above vacuum has. */
export const scaleOf = (signal: Signal, { factor, offset, offsetAboveAmbient }: Scale): Pick<Scale, "factor" | "offset"> => ({
  factor,
  offset: signal === "pressure" ? offsetAboveAmbient : offset,
});

/** Refuses a column that is no numbers. */
export function checkColumn(table: Table, place: number): void {
  const fault = table.faults.get(place);
  if (fault !== undefined) throw new TableError(fault);
}
