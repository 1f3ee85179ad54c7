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

/** Gives the plants their inputs at a time; `values` has what they show then. */
export type Exchange = (time: number, run: Run) => void;

export class Run {
  readonly recording: Recording;
  /** Whether a value was changed under way, so that the settings alone do not repeat the run. */
  isRetuned = false;
  /** Whether the visitor has pushed a carriage. */
  isPushed = false;
  private readonly plants: Plant[];
  private readonly readers: (() => Float64Array)[];
  private readonly row: Float64Array;
  private steps = 0;

  constructor(
    library: Library,
    readonly members: readonly Member[],
    private readonly exchange: Exchange,
    /** The slot of the first of the plants; the others are in those behind it. */
    first = 0,
  ) {
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
