//! Models as FMUs: the C interface of FMI 2.0 and 3.0 to any list of [`Model`]s. A crate that
//! is compiled as a `cdylib` says once which models its library serves, by [`export_fmu!`].
//!
//! | module | contents |
//! |---|---|
//! | `instance` | instances, their values, steps, saved states and messages; knows no version of the standard |
//! | `calls` | the table of calls allowed in each mode |
//! | `failure` | status and message of a failed call |
//! | `host` | the host's memory: arrays and strings that are read and written through pointers |
//! | `memory`, `unload` | a check of memory for an instance; clean-up when the library is unloaded |
//! | `c_interface` | the common part of the C interfaces |
//! | `export` | the macro that lists the models of a library |
//! | [`self_test`](mod@self_test), `module` | sources in C: a short run that proves exact arithmetic, and their other exports |
//! | [`fmi2`], [`fmi3`] | the C interfaces of FMI 2.0 and 3.0: types and functions |
//!
//! # Rules a host can rely on
//! - A call that returns an error has changed nothing and has logged why; the instance can go on. Without an instance to ask,
//!   or from within its own logger, a call is refused without a word.
//! - A step that cannot reach its end is discarded in FMI 2.0 and an error in FMI 3.0, where only what leaves no trace is
//!   discarded; the instance tells how far it came and that it wants to terminate. It can be read, reset, restored or freed.
//! - After an internal error an instance can only be freed; other instances go on.
//! - Where memory is short no instance is made, and no run started. A logger must return, neither throw nor jump.
//! - Computed values are consistent with the inputs set last, also before the next step.
//! - Slopes given to inputs hold for the next step, after which the inputs keep the values they have reached.
//! - Arrays that are passed in may overlap with those that are written: everything is read before anything is written.

mod calls;
#[macro_use]
mod c_interface;
mod export;
mod failure;
pub mod fmi2;
pub mod fmi3;
mod host;
mod instance;
mod memory;
// Exports for C only.
#[cfg(all(feature = "module", target_family = "wasm"))]
mod module;
pub mod self_test;
mod unload;

#[cfg(all(feature = "module", target_family = "wasm"))]
#[doc(hidden)]
pub use instance::only;
pub use instance::{LOG_CATEGORIES, Library, LogCategory, guid, guid_of_source};
#[doc(hidden)]
pub use pneumatic_servo::model::Model;
#[cfg(feature = "module")]
#[doc(hidden)]
pub use pneumatic_servo_loop as looped;
