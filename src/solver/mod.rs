//! A hybrid integrator: smooth segments with error control, events located between them.
//!
//! It knows the equations only through [`HybridSystem`].

mod balance;
mod event;
mod implicit_euler;
mod linear;
mod rosenbrock;
mod run;
mod runge_kutta;
mod settings;
mod system;

pub use balance::{Balance, QUANTITIES};
pub use linear::Groups;
pub use run::Run;
pub use settings::{Scheme, Settings, Tuning};
pub use system::{Held, HybridSystem, jacobian_by_duals};
