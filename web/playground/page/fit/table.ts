// Tables from other programs, read by the rules of the Python package: commas, semicolons, tabs or blanks; decimal
// commas where no comma separates; lines that are empty or begin with #, % or //; lines of a recorder above the names;
// separators behind the last value; units behind the names or below them.

import Papa from "papaparse";

/** Columns of numbers as they are written. */
export interface Table {
  file: string;
  /** Names without units. */
  names: string[];
  /** Units as they are written, where some are. */
  units: (string | null)[];
  columns: Float64Array[];
  /** The line of each row. */
  lines: Int32Array;
  /** The line of the header. */
  first: number;
}

/** Error in a table, with file, line and column. */
export class TableError extends Error {}

const COMMENTS = ["#", "%", "//"];
const SEPARATORS: [string, string][] = [
  ["\t", "tabs"],
  [";", "semicolons"],
  [",", "commas"],
  [" ", "blanks"],
];
const NUMBER = /^\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\s*$/;
const DECIMAL_COMMA = /^\s*[-+]?\d+,\d+(?:[eE][-+]?\d+)?\s*$/;
const THOUSANDS = /^\s*[-+]?[1-9]\d{0,2}(?:,\d{3})+\s*$/;
const WITH_UNIT = /^(.+?)\s*(?:\[\s*([^[\]]*?)\s*\]|\(\s*([^()]*?)\s*\)|(?:\/\s*|\s+in\s+)(\S+|\([^()]*\)))$/;
/** Rows in which a decimal comma is looked for. */
const LOOKED_AT = 20;
/** Lines in which the names are looked for, at most. */
const MOST_ABOVE = 200;
/** Characters in which the header is looked for. */
const HEAD = 1 << 16;

/** Reads a file or a text; `isUnit` tells whether something is a unit, `told` is told the share that is done. */
export async function readTable(
  file: string,
  source: Blob | string,
  isUnit: (text: string) => boolean,
  told: (share: number) => void = () => {},
): Promise<Table> {
  const head = typeof source === "string" ? source.slice(0, HEAD) : await source.slice(0, HEAD).text();
  const size = typeof source === "string" ? source.length : source.size;
  const newline = head.includes("\n") || !head.includes("\r") ? "\n" : "\r";
  const [above, separator] = header(head.replace(/^\uFEFF/, "").split(newline).filter(counts).slice(0, MOST_ABOVE), isUnit);
  const reader = new Reader(file, separator, above, isUnit);
  await new Promise<void>((resolve, reject) => {
    Papa.parse(source, {
      delimiter: separator,
      newline,
      chunk: ({ data, errors, meta }, parser) => {
        try {
          const unclosed = errors.find((error) => error.code === "MissingQuotes");
          reader.take(data);
          if (unclosed) throw new TableError(`${file}:${reader.line}: a quote is not closed`);
          told(Math.min(meta.cursor / size, 1));
        } catch (error) {
          reject(error as Error);
          parser.abort(); // which tells that it is complete
        }
      },
      complete: () => resolve(),
      error: reject,
    });
  });
  return reader.table();
}

const counts = (line: string): boolean => {
  const text = line.trim();
  return text !== "" && !COMMENTS.some((mark) => text.startsWith(mark));
};

const bare = (cell: string): string => cell.trim().replace(/^[[\]()]+|[[\]()]+$/g, "");

/** Whether cells hold units: at least one, and nothing that is neither a unit nor empty. */
const holdUnits = (cells: string[], isUnit: (text: string) => boolean): boolean =>
  cells.some((cell) => isUnit(bare(cell))) && cells.every((cell) => isUnit(bare(cell)) || ["", "-", "1"].includes(bare(cell)));

/** Takes away empty cells at the end, but for a number of cells. */
function trimmed(cells: string[], least = 1): string[] {
  let count = cells.length;
  while (count > least && cells[count - 1].trim() === "") count -= 1;
  return cells.slice(0, count);
}

/**
 * How many lines stand above the one with the names, and the separator. It is the first one, unless others stand above rows of
 * numbers: then the last of as many cells as these have, of which none is a number.
 */
function header(lines: string[], isUnit: (text: string) => boolean): [number, string] {
  const usual = SEPARATORS.find(([each]) => lines[0]?.trim().includes(each))?.[0] ?? ",";
  const cellsOf = (line: string, separator: string) =>
    trimmed(separator === " " ? line.trim().split(/\s+/) : (Papa.parse(line, { delimiter: separator }).data[0] ?? []));
  const isNumber = (cell: string) => NUMBER.test(cell) || DECIMAL_COMMA.test(cell);
  for (const [at, line] of lines.entries()) {
    for (const [separator] of SEPARATORS) {
      if (separator !== "," && !line.trim().includes(separator)) continue;
      const [own, below] = [line, lines[at + 1] ?? line].map((each) => cellsOf(each, separator));
      const areRows = [own, below].every((cells) => 2 * cells.filter(isNumber).length > cells.length);
      if (!areRows || own.length !== below.length) continue;
      for (let above = at - 1; above >= 0; above -= 1) {
        const cells = cellsOf(lines[above], separator);
        if (cells.length === own.length && !cells.some(isNumber) && !holdUnits(cells, isUnit)) return [above, separator];
      }
      return [0, usual];
    }
  }
  return [0, usual];
}

/** Takes rows of cells, one for each line. */
class Reader {
  /** The line of the last row. */
  line = 0;
  private last = 0;
  private first = 0;
  private names: string[] | null = null;
  private units: (string | null)[] = [];
  private columns: Float64Array[] = [];
  private lines = new Int32Array(1024);
  private rows = 0;
  private isBelowHeader = false;
  /** Rows that wait until it is known whether commas are decimal ones. */
  private waiting: [number, string[]][] | null = [];
  private hasComma = false;
  /** The first cells with a decimal point, and with a comma that may separate thousands. */
  private marks: { point?: string; thousands?: string } = {};

  constructor(
    private readonly file: string,
    private readonly separator: string,
    /** Lines above the header that are still to come. */
    private above: number,
    private readonly isUnit: (text: string) => boolean,
  ) {}

  take(rows: string[][]): void {
    for (const cells of rows) {
      this.last += 1;
      this.line = this.last;
      if (this.line === 1) cells[0] = cells[0].replace(/^\uFEFF/, "");
      if (counts(cells.join(this.separator)) && (this.above -= 1) < 0) this.row(cells);
      // A line break within quotes is one, too.
      for (const cell of cells) if (cell.includes("\n")) this.last += cell.split("\n").length - 1;
    }
  }

  table(): Table {
    this.settle();
    if (!this.names) throw new TableError(`${this.file}: there are no lines but empty ones and comments`);
    if (!this.rows) throw new TableError(`${this.file}: there are no rows below the header`);
    return {
      file: this.file,
      names: this.names,
      units: this.units,
      columns: this.columns.map((column) => column.slice(0, this.rows)),
      lines: this.lines.slice(0, this.rows),
      first: this.first,
    };
  }

  private row(given: string[]): void {
    const split = this.separator === " " ? given.flatMap((cell) => cell.split(/\s+/)).filter((cell) => cell !== "") : given;
    const cells = this.names ? trimmed(split, this.names.length) : split;
    if (!this.names) return this.header(trimmed(cells));
    if (!this.isBelowHeader) {
      this.isBelowHeader = true;
      if (cells.length === this.names.length && holdUnits(cells, this.isUnit)) {
        this.units = this.units.map((own, place) => own ?? this.unit(cells[place]));
        return;
      }
    }
    if (!this.waiting) return this.numbers(this.line, cells);
    this.waiting.push([this.line, cells]);
    if (this.waiting.length === LOOKED_AT) this.settle();
  }

  /** Decides about commas, and takes the rows that waited for it. */
  private settle(): void {
    const rows = this.waiting ?? [];
    this.waiting = null;
    this.hasComma ||= this.separator !== "," && rows.some(([, cells]) => cells.some((cell) => DECIMAL_COMMA.test(cell)));
    for (const [line, cells] of rows) this.numbers(line, cells);
  }

  private header(cells: string[]): void {
    this.first = this.line;
    const found = cells.map((cell) => this.nameAndUnit(cell.trim()));
    this.names = found.map(([name]) => name);
    this.units = found.map(([, unit]) => unit);
    this.columns = cells.map(() => new Float64Array(1024));
  }

  private nameAndUnit(text: string): [string, string | null] {
    const match = WITH_UNIT.exec(text);
    const unit = match && this.unit(match[2] ?? match[3] ?? match[4]);
    // `friction.gms.alpha[1]` has no unit, but a number.
    return match && unit ? [match[1], unit] : [text, null];
  }

  private unit(text: string): string | null {
    return this.isUnit(bare(text)) ? bare(text) : null;
  }

  private numbers(line: number, cells: string[]): void {
    const names = this.names ?? [];
    const place = `${this.file}:${line}`;
    if (cells.length !== names.length) {
      throw new TableError(`${place}: ${cells.length} values, but the header has ${names.length} columns${this.hint(cells)}`);
    }
    if (this.rows === this.lines.length) this.grow();
    for (let at = 0; at < cells.length; at += 1) {
      if (this.hasComma) this.checkMarks(cells[at], `${place}, column ${at + 1} (${names[at]})`);
      const cell = this.hasComma ? cells[at].replace(",", ".") : cells[at];
      const value = NUMBER.test(cell) ? Number(cell) : NaN;
      if (!Number.isFinite(value)) {
        const isInfinite = /^\s*[-+]?(nan|inf(inity)?)\s*$/i.test(cell) || NUMBER.test(cell);
        const problem = isInfinite ? `${cell.trim()} is not finite` : `'${cell}' is no number`;
        throw new TableError(`${place}, column ${at + 1} (${names[at]}): ${problem}`);
      }
      this.columns[at][this.rows] = value;
    }
    this.lines[this.rows] = line;
    this.rows += 1;
  }

  /** Refuses a table in which commas may be decimal marks or separate thousands. */
  private checkMarks(cell: string, place: string): void {
    if (cell.includes(".")) this.marks.point ??= `${place}: '${cell.trim()}'`;
    else if (THOUSANDS.test(cell)) this.marks.thousands ??= `${place}: '${cell.trim()}'`;
    const { point, thousands } = this.marks;
    if (point === undefined || thousands === undefined) return;
    throw new TableError(`${thousands} may have a separator of thousands, since a decimal point is in ${point}; write numbers with one mark`);
  }

  /** Says where a line is separated otherwise than the header. */
  private hint(cells: string[]): string {
    const line = cells.join(this.separator).trim();
    const other = SEPARATORS.find(([each]) => each !== this.separator && line.includes(each));
    const own = SEPARATORS.find(([each]) => each === this.separator);
    return other ? `; the header is separated by ${own?.[1]}, but this line has ${other[1]}` : "";
  }

  private grow(): void {
    const size = 2 * this.rows;
    const grown = new Int32Array(size);
    grown.set(this.lines);
    this.lines = grown;
    this.columns = this.columns.map((column) => {
      const longer = new Float64Array(size);
      longer.set(column);
      return longer;
    });
  }
}
