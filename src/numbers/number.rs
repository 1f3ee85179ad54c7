//! Operations that all numbers of the equations have, single ones and pairs.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Tangent;

/// A number or two of them side by side, for equations without branches.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no number of the equations",
    note = "`Real::of(value)` makes one of an `f64`, and `.value` gives it back; so nothing that varies is taken for a constant"
)]
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + Add<Tangent, Output = Self>
    + Sub<Tangent, Output = Self>
    + Mul<Tangent, Output = Self>
    + Div<Tangent, Output = Self>
{
    /// A number whose derivatives are zero.
    fn constant(value: f64) -> Self;
    /// A parameter, with its slope if these numbers are [`Tangent`]s.
    fn tuned(parameter: Tangent) -> Self;
    /// Zero.
    fn zero() -> Self;
    /// Square root; its derivative at 0, which is infinite, is taken as 0.
    fn sqrt(self) -> Self;
    /// `self` to a constant power, for `self >= 0`.
    ///
    /// At 0 the derivative for an exponent below 1 is infinite; 0 is handed on instead, so that Jacobians stay finite.
    fn powf(self, exponent: f64) -> Self;
    /// `self` to the power of a parameter, as [`powf`](Self::powf).
    fn pow(self, exponent: Tangent) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
    /// The smaller of two numbers.
    fn min(self, other: Self) -> Self;
    /// `yes` where `left >= right`, and `no` elsewhere.
    fn if_at_least(left: Self, right: Self, yes: Self, no: Self) -> Self;
}
