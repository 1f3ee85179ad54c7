// Signals that can be measured, and the signals of each experiment, as in the Python package.

export const SIGNALS = {
  time: "s",
  position: "m",
  velocity: "m/s",
  frictionForce: "N",
  force: "N",
  normalForce: "N",
  pressure: "Pa",
  valveVoltage: "V",
  supplyPressure: "Pa",
  externalForce: "N",
  "chamberA.pressure": "Pa",
  "chamberB.pressure": "Pa",
} as const;

/** A signal; its SI unit is `SIGNALS[signal]`. */
export type Signal = keyof typeof SIGNALS;

/** Signals in SI units. */
export type Signals = ReadonlyMap<Signal, Float64Array>;

export const EXPERIMENTS = ["rig", "motion"] as const;
export type ExperimentName = (typeof EXPERIMENTS)[number];

/** The signals that an experiment takes, in the order in which they are offered. */
export const TAKEN: Record<ExperimentName, readonly Signal[]> = {
  rig: [
    "time",
    "valveVoltage",
    "position",
    "velocity",
    "chamberA.pressure",
    "chamberB.pressure",
    "supplyPressure",
    "externalForce",
  ],
  motion: ["time", "position", "velocity", "frictionForce", "force", "normalForce", "pressure"],
};

/** Missing assignments of signals, or null. */
export function lacking(experiment: ExperimentName, signals: ReadonlySet<Signal>): string | null {
  const required: Signal[] = experiment === "rig" ? ["time", "valveVoltage", "position"] : ["time"];
  const missing = required.filter((signal) => !signals.has(signal));
  if (missing.length) return `experiment ${experiment} needs columns for ${required.join(", ")}; ${missing.join(", ")} is missing`;
  if (experiment === "rig") return null;
  if (!signals.has("position") && !signals.has("velocity")) return "experiment motion needs a column for position or velocity";
  if (!signals.has("frictionForce") && !signals.has("force")) return "experiment motion needs a column for frictionForce or force";
  return null;
}
