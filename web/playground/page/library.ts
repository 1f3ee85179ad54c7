// The plant: the WebAssembly module, its texts and its numbers.

import type { Model, Tables } from "./tables";
import type { Columns } from "./fit/columns";
import type { Finding } from "./fit/findings";
import type { Signal } from "./fit/signals";
import type { Table } from "./fit/table";
import { model } from "./tables";
import type { SignalScale } from "./units";

interface Exports extends WebAssembly.Exports {
  memory: WebAssembly.Memory;
  playground_buffer(): number;
  playground_text(): number;
  playground_text_length(): number;
  playground_tables(): void;
  playground_start(slot: number, model: number, count: number): number;
  playground_set(slot: number, count: number): number;
  playground_advance(slot: number, end: number): number;
  playground_read(slot: number, count: number): number;
  playground_ssv(count: number, bytes: number): number;
  playground_question(bytes: number): number;
  playground_samples(count: number): number;
  playground_fit(): number;
  playground_estimable(): number;
  playground_friction_columns(): number;
  playground_friction_table(): number;
  playground_curves(): number;
  playground_file(bytes: number): number;
  playground_read_table(): number;
  playground_proposed_columns(): number;
  playground_scale(): number;
  playground_table_signals(): number;
  playground_findings(): number;
  playground_own_fmu(): number;
  playground_made(): number;
  playground_made_length(): number;
}

/** Refusal by the library. */
export class Refusal extends Error {
  /** `text`: with numbers of very many digits written short. */
  constructor(text: string) {
    super(text.replace(/\d{17,}(?:\.\d+)?|0\.0{8,}\d+/g, (digits) => String(Number(digits))));
  }
}

/**
 * Parameters that a fit estimates unless others are chosen, others of sensors and of a bench, units of what may be known of the bench
 * and of all these, and what its signals lack.
 */
export interface Estimable {
  usual: string[];
  others: string[];
  bench: Record<string, string>;
  units: Record<string, string>;
  lacking: string | null;
}

/** Values by the names of variables. */
export type Values = ReadonlyMap<string, number>;

/** Values of a model, and what stands before their names. */
export interface Part {
  model: string;
  prefix: string;
  values: Values;
}

/** A machine that becomes an FMU of its own. */
export interface Machine {
  name: string;
  /** Variables that stay, by a name for their choice or by their names. */
  preset: string;
  inputs?: string[];
  outputs?: string[];
  parameters?: string[];
  /** By model. */
  values: Record<string, Values>;
  /** Models of the components of a system. */
  parts: Record<string, string>;
  /** Sections of HTML for the documentation page. */
  sections: string;
}

/** A slot for trying out values, not used by the pages. */
export const TRIAL = 7;

/** Numbers in the buffer of the module. */
const BUFFER = 4096;

/** The bytes that were compressed and written in base 64. */
export async function unpacked(base64: string): Promise<ArrayBuffer> {
  const compressed = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  const stream = new Blob([compressed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** The module. */
export class Library {
  readonly tables: Tables;

  private constructor(
    readonly module: WebAssembly.Module,
    private readonly exports: Exports,
    /** Functions that the module calls. */
    private readonly page: { progress: () => void },
  ) {
    exports.playground_tables();
    this.tables = JSON.parse(this.text());
  }

  /** The module from compressed bytes in base 64. */
  static async load(base64: string): Promise<Library> {
    return Library.of(await WebAssembly.compile(await unpacked(base64)));
  }

  /** An instance of its own of a module, say in a worker. */
  static async of(module: WebAssembly.Module): Promise<Library> {
    const page = { progress: () => {} };
    const instance = await WebAssembly.instantiate(module, { page: { progress: () => page.progress() } });
    return new Library(module, instance.exports as Exports, page);
  }

  /** Starts a model at time 0; what ran in the slot before is gone. Throws a refusal, and changes nothing then. */
  start(slot: number, name: string, values: Values): Plant {
    const of = model(this.tables, name);
    const places = placesOf(of);
    const count = this.write(pairs(places, values));
    this.demand(this.exports.playground_start(slot, this.tables.models.indexOf(of), count));
    return new Plant(this, slot, places);
  }

  /** Values as a file of the standard SSP 1.0, which hosts of the FMU read. Throws a refusal. */
  ssv(name: string, description: string, parts: readonly Part[], now: Date): string {
    const numbers = parts.flatMap((part) => {
      const of = model(this.tables, part.model);
      const values = pairs(placesOf(of), part.values);
      return [this.tables.models.indexOf(of), values.length, ...values];
    });
    const texts = [name, description, now.toISOString().replace(/\.\d+/, ""), ...parts.map((part) => part.prefix)];
    const bytes = new TextEncoder().encode(texts.map((text) => `${text}\0`).join(""));
    const count = this.write(numbers);
    const { buffer, byteOffset } = this.buffer().subarray(count);
    if (bytes.length > 8 * (BUFFER - count)) throw new Error(`${bytes.length} bytes do not fit into the buffer`);
    new Uint8Array(buffer, byteOffset).set(bytes);
    this.demand(this.exports.playground_ssv(count, bytes.length));
    return this.text();
  }

  /**
   * Fits what a question asks for, with the samples of its signals; returns the answer and the samples of its curves. Throws a
   * refusal.
   */
  fit(question: string, signals: readonly Float64Array[], progress: (text: string) => void): { text: string; curves: Float64Array } {
    const { exports } = this;
    this.ask(question, signals);
    this.page.progress = () => progress(this.text());
    this.demand(exports.playground_fit());
    const text = this.text();
    return { text, curves: new Float64Array(exports.memory.buffer, exports.playground_curves()) };
  }

  /** Parameters that a fit may estimate with columns in these units, and why its signals are too few, or null. */
  estimable(experiment: string, law: number, known: Values, units: ReadonlyMap<Signal, string>): Estimable {
    this.ask(JSON.stringify({ experiment, law, known: Object.fromEntries(known), signals: [...units] }), []);
    this.demand(this.exports.playground_estimable());
    return JSON.parse(this.text());
  }

  /** The table in a file. Throws a refusal that names line, column and remedy. */
  readTable(file: string, bytes: Uint8Array): Table {
    const { exports } = this;
    this.ask(file, []);
    this.put(bytes);
    this.demand(exports.playground_read_table());
    const { header, names, units, rows, first, faults, clocks, gaps } = JSON.parse(this.text());
    const numbers = new Float64Array(exports.memory.buffer, exports.playground_curves(), rows * (names.length + 1));
    const column = (place: number) => numbers.slice(rows * place, rows * (place + 1));
    return {
      file,
      header,
      names,
      units,
      columns: names.map((_: string, place: number) => column(place)),
      lines: Int32Array.from(column(names.length)),
      first,
      faults: new Map(faults),
      clocks: new Map(clocks),
      gaps: new Set(gaps),
    };
  }

  /** Signals that the names of columns tell: signal, place and the unit that is written. */
  proposedColumns({ names, units }: Table, signals: readonly Signal[]): [Signal, number, string | null][] {
    this.ask(JSON.stringify({ names, units, signals }), []);
    this.demand(this.exports.playground_proposed_columns());
    return JSON.parse(this.text());
  }

  /** How readings in a unit, or with a calibration by two points, are turned into an SI unit of a signal. Throws a refusal. */
  scale(signal: Signal, unit: string): SignalScale {
    this.ask(`${signal}\0${unit}\0`, []);
    this.demand(this.exports.playground_scale());
    return JSON.parse(this.text());
  }

  /** The chosen columns in SI units, on the clock of the one for time, and those that were read at other times. Throws a refusal. */
  tableSignals(table: Table, columns: Columns): { signals: Map<Signal, Float64Array>; others: Signal[] } {
    const { exports } = this;
    this.askOfTable(table, columns, {});
    this.demand(exports.playground_table_signals());
    const { rows, others } = JSON.parse(this.text());
    const samples = new Float64Array(exports.memory.buffer, exports.playground_curves(), rows * columns.size);
    const signals = [...columns.keys()].map((signal, at): [Signal, Float64Array] => [signal, samples.slice(rows * at, rows * (at + 1))]);
    return { signals: new Map(signals), others };
  }

  /** Findings about the chosen columns under an experiment, with their remedies. */
  findings(table: Table, columns: Columns, experiment: string, law: number, known: Values): Finding[] {
    this.askOfTable(table, columns, { experiment, law, known: Object.fromEntries(known) });
    this.demand(this.exports.playground_findings());
    return JSON.parse(this.text());
  }

  /** The places of the columns of velocity and force of a table with measured friction. Throws a refusal. */
  frictionColumns(table: string, names: readonly string[]): [number, number] {
    this.ask([table, ...names].map((text) => `${text}\0`).join(""), []);
    this.demand(this.exports.playground_friction_columns());
    return JSON.parse(this.text());
  }

  /** Parameters of the law Table for velocities in m/s, forces in N and the lines of a table. Throws a refusal. */
  frictionTable(table: string, velocity: Float64Array, force: Float64Array, lines: Int32Array): Map<string, number> {
    this.ask(table, [velocity, force, Float64Array.from(lines)]);
    this.demand(this.exports.playground_friction_table());
    return new Map(Object.entries(JSON.parse(this.text())));
  }

  /** The FMU of a machine, made of a released one. Throws a refusal. */
  ownFmu(machine: Machine, source: Uint8Array): Uint8Array<ArrayBuffer> {
    const { exports } = this;
    const values = Object.entries(machine.values).map(([of, own]) => [of, Object.fromEntries(own)]);
    this.ask(JSON.stringify({ ...machine, values: Object.fromEntries(values) }), []);
    this.put(source);
    this.demand(exports.playground_own_fmu());
    return new Uint8Array(exports.memory.buffer, exports.playground_made(), exports.playground_made_length()).slice();
  }

  /** Writes a question about columns of a table, and the table as its samples. */
  private askOfTable(table: Table, columns: Columns, further: object): void {
    const { file, names, units, first, lines } = table;
    const chosen = [...columns].map(([signal, column]) => ({ signal, ...column }));
    const about = { faults: [...table.faults], clocks: [...table.clocks], gaps: [...table.gaps] };
    const question = { file, names, units, first, rows: lines.length, ...about, chosen, ...further };
    this.ask(JSON.stringify(question), [...table.columns, Float64Array.from(lines)]);
  }

  /** Writes a question and its samples. */
  private ask(question: string, columns: readonly Float64Array[]): void {
    const { exports } = this;
    const bytes = new TextEncoder().encode(question);
    const place = exports.playground_question(bytes.length);
    new Uint8Array(exports.memory.buffer, place).set(bytes);
    let samples = exports.playground_samples(columns.reduce((count, { length }) => count + length, 0));
    for (const column of columns) {
      new Float64Array(exports.memory.buffer, samples).set(column);
      samples += column.byteLength;
    }
  }

  /** Writes a file. */
  private put(bytes: Uint8Array): void {
    const { exports } = this;
    const place = exports.playground_file(bytes.length);
    new Uint8Array(exports.memory.buffer, place).set(bytes);
  }

  /** Writes numbers into the buffer. */
  write(numbers: ArrayLike<number>): number {
    if (numbers.length > BUFFER) throw new Error(`${numbers.length} numbers do not fit into the buffer`);
    this.buffer().set(numbers);
    return numbers.length;
  }

  /** The buffer; memory that has grown is a new one. */
  buffer(): Float64Array {
    return new Float64Array(this.exports.memory.buffer, this.exports.playground_buffer(), BUFFER);
  }

  /** Calls the module for a plant. */
  call(name: "playground_set" | "playground_read" | "playground_advance", slot: number, argument: number): void {
    this.demand(this.exports[name](slot, argument));
  }

  private demand(answer: number): void {
    if (answer !== 0) throw new Refusal(this.text());
  }

  private text(): string {
    const bytes = new Uint8Array(
      this.exports.memory.buffer,
      this.exports.playground_text(),
      this.exports.playground_text_length(),
    );
    return new TextDecoder().decode(bytes);
  }
}

/** A running model. */
export class Plant {
  constructor(
    private readonly library: Library,
    private readonly slot: number,
    private readonly places: ReadonlyMap<string, number>,
  ) {}

  /** Sets inputs and tunable parameters. */
  set(values: Values): void {
    this.library.call("playground_set", this.slot, this.library.write(pairs(this.places, values)));
  }

  /** A function that sets some variables, to values in their order. */
  setter(names: readonly string[]): (values: ArrayLike<number>) => void {
    const numbers = Float64Array.from(names.flatMap((name) => [place(this.places, name), 0]));
    return (values) => {
      for (let index = 0; index < names.length; index += 1) numbers[2 * index + 1] = values[index];
      this.library.call("playground_set", this.slot, this.library.write(numbers));
    };
  }

  /** Lets time go on to an end in s. */
  advance(end: number): void {
    this.library.call("playground_advance", this.slot, end);
  }

  /** A function that reads some variables; the array it returns is valid until the next call. */
  reader(names: readonly string[]): () => Float64Array {
    const places = Float64Array.from(names, (name) => place(this.places, name));
    return () => {
      this.library.call("playground_read", this.slot, this.library.write(places));
      return this.library.buffer().subarray(0, places.length);
    };
  }
}

const placesOf = (of: Model): Map<string, number> =>
  new Map(of.variables.map((variable, place) => [variable.name, place]));

function pairs(places: ReadonlyMap<string, number>, values: Values): number[] {
  return [...values].flatMap(([name, value]) => [place(places, name), value]);
}

function place(places: ReadonlyMap<string, number>, name: string): number {
  const found = places.get(name);
  if (found === undefined) throw new Refusal(`there is no variable ${name}`);
  return found;
}
