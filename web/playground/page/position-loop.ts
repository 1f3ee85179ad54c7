// The cylinder and its controller, coupled at every step, and what is done against hunting.

import { SHOWN } from "./cylinder";
import { episodes } from "./episodes";
import type { Values } from "./library";
import type { Recording } from "./record";
import { STEP, type Exchange, type Member, type Run } from "./run";
import { CONTROLLER, CYLINDER } from "./settings";
import { at, type Signal } from "./signal";

/** Steps after which the dither changes its sign. */
export const DITHER_STEPS = 20;

/** What is done against hunting, beside the parameters of the controller. */
export interface Cures {
  /** Amplitude in V of a square wave on the voltage. */
  dither: number;
  /** Error in m below which the integral part is held; 0: never. */
  integralStop: number;
  /** The integral gain while it is not. */
  gain: number;
}

const WATCHED = ["valveVoltage", "externalForce", "supplyPressure", ...SHOWN];
const INTEGRAL = "gain.integral";
const OWN = ["referencePosition", "position", "velocity", "valveVoltage", "positionError", INTEGRAL];

/** Cylinder and controller with their values, at the start of a signal. */
export const loopMembers = (plant: Values, controller: Values, signal: Signal): Member[] => [
  { prefix: "plant.", model: CYLINDER, values: plant, first: new Map(), watched: WATCHED },
  { prefix: "controller.", model: CONTROLLER, values: controller, first: new Map([["referencePosition", at(signal, 0)]]), watched: OWN },
];

/** Gives each what the other shows at the same instant. */
export function coupled(signal: () => Signal, cures: () => Cures, pushed: (run: Run) => [string, number][]): Exchange {
  return (time, run) => {
    const shown = run.read(0);
    const position = shown[WATCHED.indexOf("position")];
    const reference = at(signal(), time);
    const inputs: [string, number][] = [["position", position], ["velocity", shown[WATCHED.indexOf("velocity")]], ["referencePosition", reference]];
    run.set(1, new Map(inputs));
    const own = run.read(1);
    const { dither, integralStop, gain } = cures();
    const sign = Math.floor(Math.round(time / STEP) / DITHER_STEPS) % 2 === 0 ? 1 : -1;
    const command = own[OWN.indexOf("valveVoltage")];
    const voltage = dither === 0 ? command : command + sign * dither;
    run.set(0, new Map([["valveVoltage", voltage], ...pushed(run)]));
    const wanted = Math.abs(reference - position) < integralStop ? 0 : gain;
    if (own[OWN.indexOf(INTEGRAL)] !== wanted) run.retune(CONTROLLER, INTEGRAL, wanted);
  };
}

/** RMS and swing of the error in m, and break-aways, in the rows from one on. */
export function judged(recording: Recording, first: number): { rms: number; swing: number; breakAways: number } {
  const [wanted, is] = ["controller.referencePosition", "plant.position"].map((name) => recording.column(name, first));
  let [squares, low, high] = [0, Infinity, -Infinity];
  for (let row = 0; row < is.length; row += 1) {
    const error = wanted[row] - is[row];
    squares += error ** 2;
    [low, high] = [Math.min(low, error), Math.max(high, error)];
  }
  const { breakAways } = episodes(recording, first, Infinity, "plant.");
  return { rms: Math.sqrt(squares / is.length), swing: high - low, breakAways: breakAways.length };
}
