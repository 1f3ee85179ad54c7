//! A hybrid integrator: smooth segments with error control, events located between them.
//!
//! It knows the equations only through [`HybridSystem`](crate::hybrid::HybridSystem).

mod balance;
mod counters;
mod error;
mod event;
mod implicit_euler;
mod linear;
mod rosenbrock;
mod run;
mod runge_kutta;
mod settings;

pub use balance::Balance;
pub use counters::Counters;
pub use error::{Rejection, StepError};
pub use linear::Inverse;
pub use run::{Progress, Run};
pub use settings::{Scheme, Settings, Tuning};
