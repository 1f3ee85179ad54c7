//! Event indicators of a hybrid system.

use crate::numbers::Scalar;

/// Description of an event indicator, whose value has a fixed index in its system.
///
/// All are watched in one direction: an indicator is positive (or zero) while the present mode is valid, and an event
/// when it falls below zero. One that the present mode does not use is [`UNUSED`].
#[derive(Clone, Debug, PartialEq)]
pub struct Indicator {
    /// Its name within the model, `friction.breakAway` for example.
    pub name: String,
    /// Magnitude, in the unit of its value, that counts as 1 where indicators of different units are compared.
    pub nominal: f64,
    /// Effect when it falls below zero.
    pub text: &'static str,
}

/// Value of an indicator that the present mode does not use.
pub const UNUSED: f64 = 1.0;

/// The event indicators of a system, each in a fixed place: an array `[S; N]`, or the indicators of a contact.
pub trait IndicatorSet<S>: AsRef<[S]> + AsMut<[S]> + Copy + Send {
    /// Indicators of which the mode uses none.
    fn unused() -> Self;
}

impl<S: Scalar, const N: usize> IndicatorSet<S> for [S; N] {
    fn unused() -> Self {
        [S::constant(UNUSED); N]
    }
}
