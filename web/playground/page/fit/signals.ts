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
