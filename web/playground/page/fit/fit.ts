// A fit: question and answer of the module, which the Python package uses as well.

import type { Library } from "../library";
import type { Signal, Signals } from "./signals";

export interface Question {
  file: string;
  experiment: string;
  /** Number of the friction law. */
  law: number;
  signals: Signals;
  /** The units of their columns. */
  units: ReadonlyMap<Signal, string>;
  /** Parameters that are known, in SI units; of those that are free the starts. */
  known: ReadonlyMap<string, number>;
  free: readonly string[];
  /** Share of the record at its end that is not fitted but predicted. */
  validation: number;
  /** Random starts beside that from the data. */
  starts: number;
  /** Chosen options of the use of the data, as far as they act in the experiment. */
  options: Record<string, number | string>;
}

export interface Estimate {
  name: string;
  unit: string;
  value: number;
  low: number;
  high: number;
  /** Why the data do not determine it, or null. */
  undetermined: string | null;
}

/** A segment of the record, with what was measured and what the fitted model gives. */
export interface Course {
  /** Times in s, or velocities in m/s of points without a time. */
  across: Float64Array;
  measured: Map<Signal, Float64Array>;
  simulated: Map<Signal, Float64Array>;
}

export type Light = "green" | "yellow" | "red";

export interface Answer {
  converged: boolean;
  message: string;
  estimates: Estimate[];
  rms: Map<Signal, number>;
  validationRms: Map<Signal, number>;
  notes: string[];
  /** SI units of the readings of signals, and a note where the machine rotates. */
  units: Record<Signal, string>;
  unitsTold: string | null;
  /** The start in s of the validation data, of points the number of their first row; null without. */
  validationFrom: number | null;
  /** Verdict on the fit: a light, its meaning, and the reasons, the worst first. */
  light: Light;
  head: string;
  findings: string[];
  /** The fixed parameter or the sensor that would explain most of the residual, in a sentence; null if none explains much. */
  cause: string | null;
  /** The parameter of the cause, and the item that a choice would have, or its estimated value. */
  remedy: { name: string; item: string | null; value: number | null } | null;
  /** Start values of the first segment as they were fitted. */
  start: Map<string, number>;
  courses: Course[];
}

/** Progress of a fit. */
export interface Progress {
  stage: string;
  runs: number;
  /** Share of the present run that is done. */
  share: number;
  /** Root mean square of the residuals in units of the noise, and the best values so far. */
  misfit: number | null;
  best: Record<string, number>;
}

/** A number as the module writes it: JSON has none that is not finite. */
type Written = number | "Infinity" | "-Infinity" | "NaN";

/** The answer as the module writes it; the curves of its segments stand behind one another. */
interface WrittenAnswer extends Omit<Answer, "estimates" | "rms" | "validationRms" | "courses" | "start"> {
  estimates: (Omit<Estimate, "value" | "low" | "high"> & Record<"value" | "low" | "high", Written>)[];
  rms: Record<Signal, Written>;
  validationRms: Record<Signal, Written>;
  signals: Signal[];
  lengths: number[];
  start: Record<string, number>;
}

/** Fits; throws a refusal for data and choices that cannot be used. */
export function fit(library: Library, question: Question, tell: (progress: Progress) => void): Answer {
  const { signals, known, units, ...others } = question;
  const asked = JSON.stringify({ ...others, signals: [...units], known: Object.fromEntries(known) });
  const { text, curves } = library.fit(asked, [...signals.values()], (progress) => tell(JSON.parse(progress)));
  const { signals: compared, lengths, ...answer }: WrittenAnswer = JSON.parse(text);
  const bySignal = (values: Record<Signal, Written>) =>
    new Map(compared.filter((signal) => signal in values).map((signal) => [signal, Number(values[signal])]));
  let place = 0;
  const courses = lengths.map((length): Course => {
    const next = () => curves.slice(place, (place += length));
    const course: Course = { across: next(), measured: new Map(), simulated: new Map() };
    for (const signal of compared) {
      course.measured.set(signal, next());
      course.simulated.set(signal, next());
    }
    return course;
  });
  // The points of a table have no time: they are one course, in the order of their rows.
  const velocities = signals.has("time") ? undefined : signals.get("velocity");
  if (velocities) courses.forEach((course) => (course.across = velocities));
  const estimates = answer.estimates.map((one) => ({ ...one, value: Number(one.value), low: Number(one.low), high: Number(one.high) }));
  const start = new Map(Object.entries(answer.start));
  return { ...answer, start, estimates, rms: bySignal(answer.rms), validationRms: bySignal(answer.validationRms), courses };
}
