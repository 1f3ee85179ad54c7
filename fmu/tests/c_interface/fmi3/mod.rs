//! The face of FMI 3.0, item by item.

pub mod derivatives;
pub mod events;
pub mod experiment;
pub mod instantiation;
pub mod model_exchange;
pub mod saved_states;
pub mod state_machine;
pub mod values;

const COULOMB: i64 = 2;
const STRIBECK: i64 = 7;
const STATES: usize = 48;
const INDICATORS: usize = 12;
