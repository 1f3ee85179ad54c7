//! Models as FMUs: the C interface of FMI 2.0 and 3.0 to any list of [`Model`]s. A crate that
//! is compiled as a `cdylib` says once which models its library serves, by [`export_fmu!`].
//!
//! | place | what lives there |
//! |---|---|
//! | `instance` | instances, their values, steps, saved states and messages; knows no version of the standard |
//! | `calls` | which call is allowed in which mode, as data |
//! | `failure` | how a call ends that did not succeed |
//! | `host` | the host's memory: arrays and strings that are read and written through pointers |
//! | `memory`, `unload` | whether there is room for an instance; what is freed when the library is unloaded |
//! | `face` | what the faces have in common |
//! | `export` | the one line by which a library says which models it serves |
//! | [`self_test`](mod@self_test), `module` | sources in C: a short run that shows exact arithmetic, and what they need besides the faces |
//! | [`fmi2`], [`fmi3`] | the faces of FMI 2.0 and 3.0: C types and functions |
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
mod face;
mod export;
mod failure;
pub mod fmi2;
pub mod fmi3;
mod fnv;
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
