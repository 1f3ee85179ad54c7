// Columns of a table as signals, in SI units.

import { Refusal, type Library } from "../library";
import type { Signal } from "./signals";
import type { Experiment } from "../tables";
import { TableError, type Table } from "./table";
import { unitsOf, type SignalScale } from "../units";

/** A column, its unit, and whether its sign is the opposite of ours. */
export interface Column {
  place: number;
  unit: string;
  turned: boolean;
}

export type Columns = Map<Signal, Column>;

/** How a unit of a signal, or a calibration, is turned into the SI unit, or why it is refused. */
export function scaleOf(library: Library, signal: Signal, unit: string): SignalScale | string {
  try {
    return library.scale(signal, unit);
  } catch (error) {
    if (error instanceof Refusal) return error.message;
    throw error;
  }
}

/** The name of a unit of a signal, however it is spelled, or a calibration; null if it is neither. */
function knownUnit(library: Library, unit: string, signal: Signal): string | null {
  const scale = scaleOf(library, signal, unit);
  return typeof scale === "string" ? null : scale.name;
}

/** SI units that a signal may have in an experiment, and the one in which it is written, each with its units. */
export function unitNames({ tables }: Library, { also }: Experiment, signal: Signal, written: string | undefined): string[] {
  const names = [tables.signals[signal], ...(also[signal] ?? [])].flatMap((si) => [...unitsOf(tables, si).keys()]);
  const isOther = !names.includes(written ?? "") && tables.written.some(({ name }) => name === written);
  return written !== undefined && isOther ? [...names, written] : names;
}

/** The unit that a table writes for a column, if it is one of a signal. */
export function writtenUnit(library: Library, table: Table, place: number, signal: Signal): string | null {
  const unit = table.units[place] ?? null;
  return unit === null ? null : knownUnit(library, unit, signal);
}

/** Signals of an experiment by the names of the columns; no column is taken twice. */
export function proposed(library: Library, table: Table, signals: readonly Signal[]): Columns {
  const column = ([signal, place, unit]: [Signal, number, string | null]): [Signal, Column] => {
    const known = unit === null ? null : knownUnit(library, unit, signal);
    return [signal, { place, unit: known ?? library.tables.signals[signal], turned: false }];
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
    const scale = unit === null || unit === "A" ? null : scaleOf(library, signal, unit);
    if (typeof scale === "string") return `${table.file}:${table.first}, column ${place + 1} (${table.names[place]}): ${scale}`;
  }
  return null;
}

/** Refuses a column that is no numbers. */
export function checkColumn(table: Table, place: number): void {
  const fault = table.faults.get(place);
  if (fault !== undefined) throw new TableError(fault);
}
