//! Value references that the models have in common; those below 400 and from 1001 are each model's own. From
//! 20 000 on are the numbers that stand for enumerations.

/// The independent variable, time.
pub const TIME: u32 = 0;
/// The states of the first contact; those of further contacts follow. References from 400 on once had other meanings.
pub const CONTACT: u32 = 460;
/// The parameters of the solver.
pub const SOLVER: u32 = 5_000;
/// The counters of the solver.
pub const COUNTERS: u32 = 5_100;
/// The event indicators, where they are variables.
pub const INDICATORS: u32 = 6_000;
/// The friction law and its parameters.
pub const FRICTION: u32 = 10_000;
