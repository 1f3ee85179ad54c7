//! A hybrid integrator: smooth segments with error control, events located between them.
//!
//! It knows the equations only through [`HybridSystem`](crate::hybrid::HybridSystem).

mod balance;
mod event;
mod implicit_euler;
mod linear;
mod rosenbrock;
mod run;
mod runge_kutta;
mod settings;

pub use balance::Balance;
pub use run::Run;
pub use settings::{Scheme, Settings, Tuning};
