// What a fit is worth: a light and a sentence, by the checks of the Python package.

import { deviation } from "./arrays";
import type { Answer } from "./fit";
import { Sensor } from "./sensor";
import { SIGNALS } from "./signals";
import { short } from "../tables";

/** Share of a signal's spread that no model of it leaves. */
const MISSED = 0.5;
/** A fit that leaves so many times the noise of a sensor misses something. */
const LOUD = 3;
/** Validation data that are missed by so many times the residual of the fitted ones are predicted badly, or not at all. */
const OFF = 1.5;
const FAR_OFF = 3;

export type Light = "green" | "yellow" | "red";

export interface Finding {
  light: Light;
  text: string;
}

const ORDER: readonly Light[] = ["red", "yellow", "green"];
const HEADS: Record<Light, string> = {
  green: "The law describes the data as far as they tell",
  yellow: "Look at this before the values are used",
  red: "These values do not describe the machine",
};

type Judged = Pick<Answer, "converged" | "message" | "estimates" | "rms" | "holdOutRms" | "courses">;

/** The light of a fit, its sentence, and what it is judged by, the worst first. */
export function verdict(answer: Judged): { light: Light; head: string; findings: Finding[] } {
  const findings = [...ofSearch(answer), ...ofMisfit(answer), ...ofPrediction(answer)];
  findings.sort((one, other) => ORDER.indexOf(one.light) - ORDER.indexOf(other.light));
  const light = findings[0]?.light ?? "green";
  return { light, head: HEADS[light], findings };
}

function ofSearch({ converged, message, estimates }: Judged): Finding[] {
  const search: Finding[] = converged ? [] : [{ light: "red", text: `The search has not come to an end: ${message}` }];
  const untold = estimates.filter(({ undetermined }) => undetermined !== null);
  return [...search, ...untold.map(({ name, undetermined }): Finding => ({ light: "yellow", text: `${name} is not identifiable: ${undetermined}` }))];
}

function ofMisfit({ rms, courses }: Judged): Finding[] {
  return [...rms].map(([signal, left]): Finding => {
    const measured = courses.map((course) => course.measured.get(signal) ?? new Float64Array());
    const spread = deviation(measured);
    const { noise, step } = Sensor.of(measured);
    const sensor = Math.hypot(noise, step / Math.sqrt(12));
    const residual = `RMS residual of ${signal}: ${short(left)} ${SIGNALS[signal]}`;
    if (!(left <= MISSED * spread)) {
      return { light: "red", text: `${residual}, and the signal varies by ${short(spread)} ${SIGNALS[signal]}: look at signs, units, and the supply, mass and bore that were assumed` };
    }
    if (left > LOUD * sensor) {
      return { light: "yellow", text: `${residual}, ${short(left / sensor)} times the noise of its sensor: the law, or a fixed parameter, misses something` };
    }
    return { light: "green", text: `${residual}, about the noise of its sensor` };
  });
}

function ofPrediction({ rms, holdOutRms }: Judged): Finding[] {
  return [...holdOutRms].map(([signal, left]): Finding => {
    const ratio = left / Math.max(rms.get(signal) ?? 0, 1e-300);
    const light = !(ratio <= FAR_OFF) ? "red" : ratio > OFF ? "yellow" : "green";
    return { light, text: `Validation data of ${signal} are missed by ${short(ratio)} times the residual of the fitted data` };
  });
}
