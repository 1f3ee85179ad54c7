//! A friction-loaded pneumatic servo cylinder: friction models that stick, valve, chambers, carriage, and the solver that
//! runs them.
//!
//! ```
//! use pneumatic_servo::model::Setup;
//! use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
//!
//! let mut plant = Setup::new(&MODEL).set("friction.law", "Stribeck")?.set("valve.C", 5e-9)?.start(0.0)?;
//! for k in 0..1000 {
//!     let voltage = if plant.get("position")? < 0.3 { 6.0 } else { 5.0 };
//!     plant.set("valveVoltage", voltage)?;
//!     plant.advance_to(f64::from(k + 1) * 1e-3)?;
//! }
//! assert!(plant.get("position")? > 0.3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A model is built by name: [`Setup`](model::Setup) takes parameters, a [`Plant`](model::Plant) is stepped,
//! read, saved and restored. All quantities are in SI units. The same inputs give the same bits on every platform.
//!
//! | module | contents |
//! |---|---|
//! | [`numbers`], [`variables`] | numbers with exact derivatives; the variable table |
//! | [`solver`] | the hybrid integrator, which knows equations but no cylinder |
//! | [`friction`], [`pneumatics`], [`mechanics`], `sensor` | the physics |
//! | [`system`] | the trait of a model: hybrid equations with tables |
//! | [`sensitivity`] | derivatives of a run by parameters, inputs and states |
//! | [`model_exchange`], [`co_simulation`] | a run under the solver of an importer, or under the library's |
//! | [`model`] | a model built and run by name |
//! | [`models`] | the models of this library |
//! | [`prelude`] | items for a law, an actuator or a model of your own |
//! | [`conformance`] | promises of every law and model, as checks for their tests |
//!
//! [`guide`] explains how to write, test and pack a law, an actuator or a model of your own.
//!
//! Rust 1.89 or later. Features:
//!
//! | feature | on by default | contents |
//! |---|---|---|
//! | `all-models` | yes | the list [`models::ALL`], for which all models are compiled; without it a program compiles those it uses |
//! | `names` | yes | names of variables in the errors of runs |
//! | `sensitivities` | yes | derivatives along runs ([`sensitivity`]) |
//! | `small` | no | fewer compiled sizes of the vector of states: smaller programs, somewhat slower with options of the cylinder, with the same bits |

#![forbid(unsafe_code)]

// Macros name this crate from inside and from outside.
extern crate self as pneumatic_servo;

#[doc(hidden)]
pub use serde;

pub mod co_simulation;
pub mod conformance;
pub mod friction;
pub mod mechanics;
pub mod model;
pub mod model_exchange;
pub mod models;
pub mod numbers;
pub mod pneumatics;
pub mod prelude;
pub mod sensitivity;
#[doc(hidden)]
pub mod sensor;
#[doc(hidden)]
pub mod session;
pub mod solver;
pub mod system;
pub mod variables;

/// The Rust programs of the README, which are run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(any(doc, doctest))]
#[doc = include_str!("../docs/own.md")]
#[doc = include_str!("../docs/own-model.md")]
#[doc = include_str!("../docs/own-packing.md")]
pub mod guide {}
