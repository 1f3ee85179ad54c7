//! What a hybrid system is: smooth equations within a mode, indicators that end it, switches, samples.
//!
//! Nothing here knows friction, and nothing a solver.

mod couplings;
mod indicators;
mod limits;
mod longest_steps;
mod sample;
pub mod side;
mod system;

pub use couplings::Couplings;
pub(crate) use couplings::bits;
pub use indicators::{Indicator, UNUSED};
pub use limits::Limits;
pub use longest_steps::LongestSteps;
pub use sample::Sample;
#[doc(hidden)]
pub use system::Held;
pub use system::{Groups, Led, QUANTITIES, Stride};
