// Courses of an input over time.

export const KINDS = ["constant", "sine", "ramp", "drawn"] as const;
export type Kind = (typeof KINDS)[number];

/** Points of a drawing. */
export const POINTS = 101;

export interface Signal {
  kind: Kind;
  /** The value of the slider, and the middle of everything else, in SI units. */
  level: number;
  /** Amplitude around the middle. */
  amplitude: number;
  /** Time in s after which it repeats. */
  period: number;
  /** A drawing over one period, from -1 to 1. */
  points: number[];
  /** Feedback in V/m that draws the carriage back to where the run began: an open loop drifts into an end stop. */
  centring: number;
}

/** A fraction of 0 to 1 along a list of points, on straight lines between them. */
export function along(points: readonly number[], fraction: number): number {
  const place = fraction * (points.length - 1);
  const index = Math.min(Math.floor(place), points.length - 2);
  return points[index] + (points[index + 1] - points[index]) * (place - index);
}

/** From -1 to 1 and back, beginning at 0. */
function triangle(phase: number): number {
  if (phase < 0.25) return 4 * phase;
  return phase < 0.75 ? 2 - 4 * phase : 4 * phase - 4;
}

/** The value at a time in s. */
export function at(signal: Signal, time: number): number {
  const phase = (time / signal.period) % 1;
  switch (signal.kind) {
    case "constant":
      return signal.level;
    case "sine":
      return signal.level + signal.amplitude * Math.sin(2 * Math.PI * phase);
    case "ramp":
      return signal.level + signal.amplitude * triangle(phase);
    case "drawn":
      return signal.level + signal.amplitude * along(signal.points, phase);
  }
}

/** Whether it can be stated by a formula of the time, from the beginning of a run. */
export const isFormula = (signal: Signal): boolean => signal.kind === "sine" && signal.centring === 0;
