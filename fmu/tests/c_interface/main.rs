//! The C interface of the built library, item by item.

#![allow(unsafe_code, reason = "a C interface is called")]

mod coils;
#[path = "../common/mod.rs"]
mod common;
mod derivatives;
mod effects;
mod fmi3;
mod instantiation;
mod logging;
mod model_exchange;
mod saved_states;
mod state_machine;
mod steps;
mod symbols;
mod threads;
mod values;
mod variant;
