// A fit: what is asked, and what comes out.

import { Refusal, type Library } from "../library";
import type { Tables } from "../tables";
import { span } from "./arrays";
import { checkMotion, type Experiment, type Options } from "./experiment";
import { freeOf, type Free } from "./free";
import { started } from "./guess";
import { certainty } from "./intervals";
import { FitError, split, type Measured, type Signals } from "./measured";
import { Motion } from "./motion";
import { FAILED, Problem } from "./problem";
import { Rig } from "./rig";
import { lacking, SIGNALS, type ExperimentName, type Signal } from "./signals";
import { noise } from "./smoothing";
import { solve, withLikelySensors } from "./solve";

export interface Question {
  file: string;
  experiment: ExperimentName;
  /** Number of the friction law. */
  law: number;
  /** Signals in SI units. */
  signals: Signals;
  /** Parameters that are known, in SI units; of those that are free the starts. */
  known: ReadonlyMap<string, number>;
  free: readonly string[];
  /** Share of the record at its end that is not fitted but predicted. */
  holdOut: number;
  /** Random starts beside that from the data. */
  starts: number;
  options: Options;
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

/** A stretch of the record, with what was measured and what the fitted model gives. */
export interface Course {
  time: Float64Array;
  measured: Map<Signal, Float64Array>;
  simulated: Map<Signal, Float64Array>;
}

export interface Answer {
  converged: boolean;
  message: string;
  estimates: Estimate[];
  rms: Map<Signal, number>;
  holdOutRms: Map<Signal, number>;
  notes: string[];
  /** The first time that is held out, or null. */
  heldFrom: number | null;
  courses: Course[];
}

/** What is told on the way. */
export interface Progress {
  stage: string;
  runs: number;
  /** Share of the present run that is done. */
  share: number;
  /** Root mean square of the residuals in units of the noise, and the best values so far. */
  misfit: number | null;
  best: [string, number][];
}

/** Fits; throws a refusal, or an error for data and choices that cannot be used. */
export function fit(library: Library, question: Question, tell: (progress: Progress) => void): Answer {
  const progress: Progress = { stage: "Look at the data", runs: 0, share: 0, misfit: null, best: [] };
  const experiment = experimentOf(library.tables, question);
  const { records, notes } = split(question.file, question.signals);
  checkMotion(records);
  checkIntervals(records);
  const free = freeParameters(library.tables, experiment, question);
  const told = (share: number) => {
    if (share === 0) progress.runs += 1;
    progress.share = share;
    tell(progress);
  };
  let problem = Problem.of(library, experiment, records, free, question.holdOut, told);
  checkSize(problem, records);
  problem = started(problem);
  const begun = problem.trained();
  checkStart(begun);
  const trained = begun.bounded();
  const seen = (x: Float64Array, meanSquare: number) => {
    progress.misfit = Math.sqrt(meanSquare);
    progress.best = [...trained.values(x)];
    tell(progress);
  };
  const stage = (text: string) => {
    progress.stage = text;
    tell(progress);
  };
  const [fitted, best] = withLikelySensors(trained, solve(trained, question.starts, seen, stage), seen, stage);
  stage("Intervals");
  const sure = certainty(fitted, best.x);
  const values = fitted.values(best.x);
  const own = best.x.slice(0, fitted.free.length);
  const whole = problem.with({ sensors: fitted.sensors }).begun(fitted, best.x);
  const readings = whole.readings(own);
  const rms = rmsOf(whole.bySignal(readings, false));
  const isSimulated = [...rms.values()].every(Number.isFinite);
  const held = whole.windows.flatMap(({ record, held: is }) => {
    const row = is.indexOf(1);
    return row < 0 ? [] : [record.begin + record.time[row]];
  });
  return {
    converged: best.converged && isSimulated,
    message: isSimulated ? best.message : "the fitted values cannot be simulated",
    estimates: fitted.free.map(({ name, unit }, index) => ({
      name,
      unit,
      value: values.get(name) ?? NaN,
      low: sure.low[index],
      high: sure.high[index],
      undetermined: sure.undetermined.get(name) ?? null,
    })),
    rms,
    holdOutRms: rmsOf(whole.bySignal(readings, true)),
    notes: [...notes, ...experiment.notes],
    heldFrom: held.length ? Math.min(...held) : null,
    courses: whole.windows.map(({ record }, index) => ({
      time: record.time.map((time) => time + record.begin),
      measured: new Map(experiment.compared.map((signal) => [signal, record.of(signal).slice()])),
      simulated: readings[index],
    })),
  };
}

function experimentOf(tables: Tables, { experiment, law, known, signals, options, free }: Question): Experiment {
  const names = new Set(signals.keys());
  const problem = lacking(experiment, names);
  if (problem) throw new FitError(problem);
  const fixed = new Map([...known].filter(([name]) => !free.includes(name)));
  return new (experiment === "rig" ? Rig : Motion)(tables, law, fixed, names, options);
}

function freeParameters(tables: Tables, experiment: Experiment, { free, known }: Question): Free[] {
  if (!free.length) throw new FitError("nothing is free: choose at least one parameter");
  const missing = experiment.unknown.find((name) => !free.includes(name));
  if (missing) throw new FitError(`${missing} has no default; it must be free`);
  return free.map((name) => {
    return freeOf(tables, experiment.model, name, known.get(name), experiment.compared, experiment.driving);
  });
}

/** Refuses samples between which a carriage does all that it does, or that no rig has. */
function checkIntervals(records: readonly Measured[]): void {
  for (const { step } of records) {
    if (step > 0.5) throw new FitError(`samples are ${step} s apart, between which a carriage does all that it does; is time in ms?`);
    if (step < 1e-6) throw new FitError(`samples are ${step} s apart, which no rig has; is time in s?`);
  }
}

function checkSize(problem: Problem, records: readonly Measured[]): void {
  const { compared } = problem.experiment;
  const rests = (position: Float64Array) => span(position) <= 8 * noise(position);
  if (compared.includes("position") && records.every((record) => rests(record.of("position")))) {
    throw new FitError("all at rest: the position never leaves its noise");
  }
  if (problem.size === 0) throw new FitError("all at rest: no sample moves beyond the noise of the position");
  for (const signal of compared) {
    if (records.every((record) => span(record.of(signal)) === 0)) {
      throw new FitError(`${signal} = ${records[0].of(signal)[0]} ${SIGNALS[signal]} all the time; is it the right column?`);
    }
  }
  if (problem.size < 5 * problem.free.length) {
    throw new FitError(`too short: ${problem.size} samples to compare for ${problem.free.length} free parameters`);
  }
}

/** Refuses a start that cannot be simulated at all, with the model's own words. */
function checkStart(problem: Problem): void {
  const residuals = problem.residuals(problem.differences(problem.start));
  if (!residuals.every((value) => Math.abs(value) === FAILED)) return;
  try {
    problem.bounded();
  } catch (error) {
    if (error instanceof Refusal) throw new FitError(`the start values cannot be simulated: ${error.message}`);
    throw error;
  }
}

function rmsOf(differences: Map<Signal, Float64Array>): Map<Signal, number> {
  const found = new Map<Signal, number>();
  for (const [signal, values] of differences) {
    const square = values.reduce((total, value) => total + value * value, 0) / values.length;
    if (values.length) found.set(signal, Math.sqrt(square));
  }
  return found;
}
