//! The C interface: FMI 2.0 for co-simulation, for any model in [`models::ALL`](pneumatic_servo::models::ALL).
//!
//! | file | what it does |
//! |---|---|
//! | `exports` | the C functions; the only file with `unsafe` |
//! | `guard` | lets a call into an instance: one at a time, obeying the table, without panics leaving it |
//! | `calls` | the table: which function may be called when |
//! | `instance` | an instance and its life |
//! | `values`, `steps`, `derivatives`, `saved_states` | what is done with an instance |
//! | `run` | the simulation behind an instance, started and computed when needed |
//! | `record` | what an instance remembers besides the states of its model |
//! | `layout`, `registry` | where the value of each variable is kept; the models by GUID |
//! | `clock` | where a communication step leads, and what is rounding |
//! | `codec` | saved states as bytes |
//! | `logging`, `failure` | messages to the host |
//! | `guid`, `fnv` | the GUID |
//!
//! # Rules a host can rely on
//! - A call that returns `fmi2Error` has changed nothing and has logged why; the instance can go on.
//! - A step that cannot reach its end returns `fmi2Discard`; `fmi2GetRealStatus` tells how far it came and
//!   `fmi2GetBooleanStatus` that the instance wants to terminate. It can be read, reset, restored or freed.
//! - After an internal error (`fmi2Fatal`) an instance can only be freed; other instances go on.
//! - Computed values are consistent with the inputs set last, also before the next step.
//! - Slopes given to inputs hold for the next step, after which the inputs keep the values they have reached.

mod calls;
mod clock;
mod codec;
mod derivatives;
pub mod exports;
mod failure;
mod fnv;
mod guard;
mod guid;
mod instance;
mod layout;
mod logging;
mod record;
mod registry;
mod run;
mod saved_states;
mod steps;
#[cfg(test)]
mod testing;
pub mod types;
mod values;

pub use guid::guid;
pub use logging::{LOG_CATEGORIES, LogCategory};
