// Plants that run together, step by step.

import type { Library, Plant, Values } from "./library";
import { Recording } from "./record";

/** The communication step in s. */
export const STEP = 1e-3;

/** A plant of a run and what is recorded of it. */
export interface Member {
  /** Prefix of its columns, if there are several runs. */
  prefix: string;
  model: string;
  values: Values;
  /** Its inputs at the start, computed from nothing but the time. */
  first: Values;
  watched: readonly string[];
}

/** A value that was changed under way, after a row of the recording. */
export interface Change {
  row: number;
  model: string;
  name: string;
  value: number;
}

/** Gives the plants their inputs at a time; `values` has what they show then. */
export type Exchange = (time: number, run: Run) => void;

export class Run {
  readonly recording: Recording;
  /** The plants as they started: what the settings become later is among the changes. */
  readonly members: readonly Member[];
  readonly changes: Change[] = [];
  /** Whether the input has followed more than one signal. */
  isRedirected = false;
  /** Whether the visitor has pushed a carriage. */
  isPushed = false;
  private readonly plants: Plant[];
  private readonly readers: (() => Float64Array)[];
  private readonly row: Float64Array;
  private steps = 0;

  constructor(
    library: Library,
    members: readonly Member[],
    private readonly exchange: Exchange,
    /** The slot of the first of the plants; the others are in those behind it. */
    first = 0,
  ) {
    this.members = members.map((member) => ({ ...member, values: new Map(member.values) }));
    this.plants = members.map((member, index) =>
      library.start(first + index, member.model, new Map([...member.values, ...member.first])),
    );
    this.readers = members.map((member, index) => this.plants[index].reader(member.watched));
    const names = members.flatMap((member) => member.watched.map((name) => member.prefix + name));
    this.recording = new Recording(["time", ...names]);
    this.row = new Float64Array(names.length + 1);
    this.note();
  }

  get time(): number {
    return this.steps * STEP;
  }

  /** Takes one step and notes what there is at its end. */
  step(): void {
    const end = (this.steps + 1) * STEP;
    for (const plant of this.plants) plant.advance(end);
    this.steps += 1;
    this.note();
  }

  /** Sets variables of one of the plants. */
  set(member: number, values: Values): void {
    this.plants[member].set(values);
  }

  /** Changes a value of all plants of a model from the present instant on. */
  retune(model: string, name: string, value: number): void {
    this.members.forEach((member, index) => {
      if (member.model === model) this.set(index, new Map([[name, value]]));
    });
    this.changes.push({ row: this.steps, model, name, value });
  }

  /** The watched values of one of the plants, in their order. */
  read(member: number): Float64Array {
    return this.readers[member]().slice();
  }

  private note(): void {
    this.exchange(this.time, this);
    this.row[0] = this.time;
    let place = 1;
    for (const read of this.readers) {
      const values = read();
      this.row.set(values, place);
      place += values.length;
    }
    this.recording.push(this.row);
  }
}
