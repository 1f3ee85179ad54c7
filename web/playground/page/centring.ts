// The input of a cylinder: a signal over time, and the feedback that keeps the carriage away from the end stops.

import type { Run } from "./run";
import { at, type Signal } from "./signal";

export class CentredInput {
  /** Where the carriages were at the start of the run. */
  private start: number[] = [];

  /** `place`: of the position among the watched variables. */
  constructor(
    private readonly signal: () => Signal,
    private readonly place: number,
  ) {}

  /** The input of a member of a run, which is to be asked at every step from time 0 on. */
  at(time: number, run: Run, member: number): number {
    const signal = this.signal();
    const position = run.read(member)[this.place];
    if (time === 0) this.start[member] = position;
    return at(signal, time) - signal.centring * (position - this.start[member]);
  }
}
