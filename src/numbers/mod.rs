//! Numbers the equations are written for.
//!
//! | file | contents |
//! |---|---|
//! | `number` | operations of all numbers, without branches |
//! | `scalar` | single numbers, with transcendental functions and branches by their value |
//! | `dual` | single numbers with exact derivatives |
//! | `tangent` | tunable parameters, and numbers with the slopes that these hand on |
//! | `pair` | two numbers side by side |
//! | `monotone` | a smooth curve through points |
//! | `random` | random numbers that are the same everywhere |
//! | `singular` | singular values with the same bits everywhere |

mod dual;
mod monotone;
mod number;
mod pair;
#[doc(hidden)]
pub mod random;
mod scalar;
mod singular;
mod tangent;

pub use dual::{Dual, Real};
pub(crate) use monotone::MonotoneCurve;
pub use number::Number;
pub use pair::Pair;
pub(crate) use scalar::KEPT;
pub use scalar::{Scalar, Varying, sign};
pub use singular::{Singular, pseudo_inverse};
pub(crate) use tangent::first;
pub use tangent::{DIRECTIONS, STILL, Slopes, Tangent, Tangents};
