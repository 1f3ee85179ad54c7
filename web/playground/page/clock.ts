// Pacing of a run by the wall clock.

/** Time in ms that stepping may take of a frame; what does not fit is left out of the pace and counted. */
const BUDGET = 9;

export class Clock {
  /** Simulated seconds per second. */
  speed = 1;
  /** Frames that were shown, and steps that the machine was too slow for, while running. */
  frames = 0;
  dropped = 0;
  rate = 0;
  private last: number | null = null;
  private owed = 0;
  private since: { time: number; frames: number } | null = null;

  constructor(private readonly step: number) {}

  /** Forgets the wall clock, after a pause. */
  pause(): void {
    this.last = null;
    this.since = null;
    this.owed = 0;
  }

  /** Takes the steps that are due at a time in ms of the wall clock. */
  frame(now: number, advance: () => void): void {
    this.count(now);
    if (this.last !== null) this.owed += ((now - this.last) / 1000) * this.speed;
    this.last = now;
    const end = performance.now() + BUDGET;
    while (this.owed >= this.step) {
      if (performance.now() > end) {
        const late = Math.floor(this.owed / this.step);
        this.dropped += late;
        this.owed -= late * this.step;
        return;
      }
      advance();
      this.owed -= this.step;
    }
  }

  private count(now: number): void {
    this.frames += 1;
    this.since ??= { time: now, frames: this.frames };
    const elapsed = now - this.since.time;
    if (elapsed >= 500) {
      this.rate = ((this.frames - this.since.frames) / elapsed) * 1000;
      this.since = { time: now, frames: this.frames };
    }
  }
}
