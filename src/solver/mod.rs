//! A hybrid integrator: smooth segments with error control, events located between them.
//!
//! It knows the equations only through [`System`](crate::system::System).

mod balance;
mod error;
mod event;
mod implicit_euler;
mod linear;
#[cfg(feature = "sensitivities")]
mod linear_map;
mod relaxing;
mod rosenbrock;
mod run;
mod runge_kutta;
mod settings;
mod trial;

use crate::numbers::Scalar;
pub use crate::system::{Counters, Scheme, Tuning};
pub use balance::Balance;
pub use error::{Rejection, StateAtStart, StepError};
#[doc(hidden)]
pub use linear::Inverse;
#[doc(hidden)]
pub use run::{Crossing, Progress, Run};
#[cfg(feature = "sensitivities")]
pub(crate) use run::{Trail, Variation};
#[doc(hidden)]
pub use settings::Settings;

/// The values of numbers.
#[inline(always)]
fn values<S: Scalar, const N: usize>(numbers: &[S; N]) -> [f64; N] {
    array(|i| numbers[i].value())
}

/// Numbers of values, none of which varies.
#[inline(always)]
fn numbers<S: Scalar, const N: usize>(values: &[f64; N]) -> [S; N] {
    array(|i| S::of(values[i]))
}

/// Numbers made one by one from their indices, as by `std::array::from_fn`: each use of that is several functions to
/// compile, and all of them again for each system.
#[inline(always)]
fn array<T: Copy + Default, const N: usize>(number: impl Fn(usize) -> T) -> [T; N] {
    let mut array = [T::default(); N];
    for (i, slot) in array.iter_mut().enumerate() {
        *slot = number(i);
    }
    array
}
