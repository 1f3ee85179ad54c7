//! What a hybrid system is: smooth equations within a mode, indicators that end it, switches, samples.
//!
//! Nothing here knows friction, and nothing a solver.

mod couplings;
mod indicators;
mod limits;
mod longest_steps;
mod sample;
mod system;

pub(crate) use couplings::bits;
pub use couplings::{Couplings, jacobian_by_couplings};
pub use indicators::{Indicator, UNUSED};
pub use limits::Limits;
pub use longest_steps::LongestSteps;
pub use sample::Sample;
pub use system::{Groups, Held, HybridSystem, Led, QUANTITIES, Stride, jacobian_by_duals};
