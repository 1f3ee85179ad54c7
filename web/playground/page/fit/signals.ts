// Signals that can be measured, as the library lists them.

/** A signal; its SI unit is `tables.signals[signal]`. */
export type Signal = string;

/** Signals in SI units. */
export type Signals = ReadonlyMap<Signal, Float64Array>;
