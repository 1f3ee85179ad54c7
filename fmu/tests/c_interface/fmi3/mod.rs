//! The face of FMI 3.0, item by item.

mod derivatives;
mod events;
mod instantiation;
mod saved_states;
mod state_machine;
mod values;

const COULOMB: i64 = 2;
const STRIBECK: i64 = 7;
const STATES: usize = 41;
const INDICATORS: usize = 6;
