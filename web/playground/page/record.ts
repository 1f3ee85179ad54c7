// The record of a run: a table with one row per step.

/** Rows that are kept: two minutes of steps of 1 ms. */
export const ROWS = 120_000;

export class Recording {
  private readonly columns: Float64Array[];
  private length = 0;
  /** Whether the beginning is no longer there. */
  isCut = false;

  constructor(readonly names: readonly string[]) {
    this.columns = names.map(() => new Float64Array(ROWS));
  }

  get rows(): number {
    return this.length;
  }

  push(row: ArrayLike<number>): void {
    if (this.length === ROWS) this.forget(ROWS / 4);
    this.columns.forEach((column, index) => (column[this.length] = row[index]));
    this.length += 1;
  }

  /** The values of a column from a row on, or up to another one. */
  column(name: string, from = 0, to = this.length): Float64Array {
    return this.columns[this.names.indexOf(name)].subarray(Math.max(from, 0), Math.min(to, this.length));
  }

  /** The last row at or before a time in s; the first one if there is none. */
  rowAt(time: number): number {
    const times = this.columns[0];
    let [low, high] = [0, this.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  /** The value of a column in a row. */
  at(name: string, row: number): number {
    return this.columns[this.names.indexOf(name)][row];
  }

  /** The last value of a column. */
  last(name: string): number {
    return this.length ? this.columns[this.names.indexOf(name)][this.length - 1] : NaN;
  }

  /** As comma-separated values that keep every bit, in SI units. */
  csv(): string {
    const lines = [this.names.join(",")];
    for (let row = 0; row < this.length; row += 1) {
      lines.push(this.columns.map((column) => String(column[row])).join(","));
    }
    return lines.join("\n") + "\n";
  }

  private forget(rows: number): void {
    for (const column of this.columns) column.copyWithin(0, rows);
    this.length -= rows;
    this.isCut = true;
  }
}
