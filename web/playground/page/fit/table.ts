// Tables from other programs, as the library reads them for this page and for the Python package.

/** Columns of numbers as they are written. */
export interface Table {
  file: string;
  /** Names as they are written, and without units. */
  header: string[];
  names: string[];
  /** Units as they are written, where some are. */
  units: (string | null)[];
  columns: Float64Array[];
  /** The line of each row. */
  lines: Int32Array;
  /** The line of the header. */
  first: number;
  /** By the place of a column what is wrong with it: it is refused where somebody asks for it. */
  faults: Map<number, string>;
  /** By the place of a column the place of its own clock, where that is not the first one. */
  clocks: Map<number, number>;
  /** Columns with empty cells, which are NaN: channels that are slower than others. */
  gaps: Set<number>;
}

/** Rising numbers as ranges, each with its first and its last one. */
export function rangesOf(numbers: readonly number[]): [number, number][] {
  const firsts = numbers.filter((number, place) => number !== numbers[place - 1] + 1);
  const lasts = numbers.filter((number, place) => number !== numbers[place + 1] - 1);
  return firsts.map((first, place) => [first, lasts[place]]);
}

/** A table without the rows of some lines. */
export function without(table: Table, lines: readonly number[]): Table {
  const out = new Set(lines);
  const isKept = (_: number, row: number): boolean => !out.has(table.lines[row]);
  return { ...table, columns: table.columns.map((column) => column.filter(isKept)), lines: table.lines.filter(isKept) };
}

/** Error in a table, with file, line and column. */
export class TableError extends Error {}
