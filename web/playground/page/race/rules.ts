// The race to 300 mm: its end and its score.

/** Where the carriage has to come to rest, in m. */
export const TARGET = 0.3;
/** Time in s after which it is over. */
export const LONGEST = 10;
/** The range of the valve's voltage in V. */
export const VOLTS: readonly [number, number] = [0, 10];
/** A carriage rests that is slower, in m/s, for so long, in s; not before it has moved so far, in m. */
const [SLOW, REST, MOVED] = [1e-4, 1, 1e-3];
/** Cost of a second, in mm. */
const SECOND = 0.1;

/** Result of a race. */
export interface Result {
  /** Distance from the target in m. */
  off: number;
  /** Since when it rests, in s. */
  time: number;
}

/** The score, of which less is better: the distance in mm and a tenth of the time in s. */
export const score = ({ off, time }: Result): number => 1e3 * off + SECOND * time;

export const tell = (result: Result): string =>
  `${(1e3 * result.off).toFixed(2)} mm off after ${result.time.toFixed(2)} s: score ${score(result).toFixed(2)}`;

/** Watches a carriage until it rests. */
export class Judge {
  result: Result | null = null;
  private begin: number | null = null;
  private since: number | null = null;

  /** Notes where a carriage is at a time, which goes on from call to call. */
  note(time: number, position: number, velocity: number): void {
    if (this.result) return;
    this.begin ??= position;
    const isResting = Math.abs(velocity) < SLOW && Math.abs(position - this.begin) > MOVED;
    this.since = isResting ? (this.since ?? time) : null;
    const off = Math.abs(position - TARGET);
    if (this.since !== null && time - this.since >= REST) this.result = { off, time: this.since };
    else if (time >= LONGEST) this.result = { off, time };
  }
}

/** First program of the editor, to be improved. */
export const FIRST_CODE = `// Every millisecond: the voltage of the valve, which is closed at 5 V.
let sum = 0;
function control(time, position, velocity) { // in s, m, m/s
  const error = 0.3 - position;
  sum += 0.001 * error;
  return 5 + 60 * error + 10 * sum - 6 * velocity;
}`;
