//! Single numbers: [`Real`](super::Real) ones, or [`Dual`](super::Dual) numbers that carry exact derivatives.
//!
//! Every transcendental function goes through the `libm` crate, so that the same inputs give the same bits on
//! every platform; square roots are correctly rounded by the hardware everywhere.

use std::fmt::Debug;
use std::ops::{AddAssign, SubAssign};

use serde::{Serialize, de::DeserializeOwned};

use super::{Number, Slopes, Tangent};

/// A real number the equations can be evaluated with.
///
/// Comparisons (`abs`, `max`, `clamp`, ...) look at the value only and hand on the derivative of the branch taken.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no number of the equations",
    note = "`Real::of(value)` makes one of an `f64`, and `.value` gives it back; so nothing that varies is taken for a constant"
)]
pub trait Scalar: Number + AddAssign + SubAssign + Default + PartialEq + Debug + Send + Sync + 'static {
    /// The number in which a discrete state keeps what goes into equations of this number: the same for numbers that vary with
    /// parameters and start values, and a [`Real`](super::Real) for numbers that vary with the continuous states.
    type Held: Varying;

    /// A number of the discrete state in an equation.
    fn held(value: Self::Held) -> Self;
    /// The value without its derivatives.
    fn value(self) -> f64;
    /// The number with a value and no derivatives.
    fn of(value: f64) -> Self;
    /// A parameter, with its slope if these numbers are tangents.
    fn along(parameter: Tangent) -> Self {
        Self::of(parameter.value)
    }
    /// Applies a function of one variable given its value and its derivative at `self`.
    fn chain(self, value: f64, derivative: f64) -> Self;
    /// The same for a function that depends on a parameter, too, given its derivative by that.
    fn chain_with(self, value: f64, derivative: f64, _parameter: Tangent, _by_parameter: f64) -> Self {
        self.chain(value, derivative)
    }
    /// A power of `self`, which varies with its exponent, too, if these numbers are tangents.
    fn with_exponent(self, power: Self, _exponent: Tangent) -> Self {
        power
    }

    /// `e` to the power `self`.
    fn exp(self) -> Self {
        let value = libm::exp(self.value());
        self.chain(value, value)
    }
    /// Natural logarithm of a positive number.
    fn ln(self) -> Self {
        let x = self.value();
        self.chain(libm::log(x), 1.0 / x)
    }
    /// Inverse hyperbolic sine.
    fn asinh(self) -> Self {
        let x = self.value();
        self.chain(libm::asinh(x), 1.0 / (1.0 + x * x).sqrt())
    }
    /// Sine.
    fn sin(self) -> Self {
        self.chain(libm::sin(self.value()), libm::cos(self.value()))
    }
    /// Cosine.
    fn cos(self) -> Self {
        self.chain(libm::cos(self.value()), -libm::sin(self.value()))
    }
    /// Hyperbolic tangent.
    fn tanh(self) -> Self {
        let value = libm::tanh(self.value());
        self.chain(value, 1.0 - value * value)
    }
    /// Arc tangent.
    fn atan(self) -> Self {
        let x = self.value();
        self.chain(libm::atan(x), 1.0 / (1.0 + x * x))
    }
    /// Magnitude; the derivative at 0 is the right-hand one.
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
    /// The number nearest to `self` in `[low, high]`.
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
}

/// Name of a number of a discrete state for the serializer; nothing of it is written.
pub(crate) const KEPT: &str = "number of a discrete state";

/// A number that a discrete state can keep: what happens at events and samples is evaluated with it.
///
/// It is saved as its value, and its slopes if it has any.
pub trait Varying: Scalar<Held = Self> + Serialize + DeserializeOwned {
    /// Whether it has slopes.
    const VARIES: bool;

    /// A number with slopes, if it has any.
    fn with(value: f64, slopes: Slopes) -> Self;

    /// Its slopes; 0 if it has none.
    fn slopes(self) -> Slopes;

    /// Another number of the same value in some of the directions.
    fn or(self, other: Self, is_other: impl Fn(usize) -> bool) -> Self {
        if !Self::VARIES {
            return self;
        }
        let (own, others) = (self.slopes(), other.slopes());
        Self::with(self.value(), std::array::from_fn(|i| if is_other(i) { others[i] } else { own[i] }))
    }

    /// The same where a limit may be just reached: a number of the same value with another slope leaves none, since more of the
    /// direction leads to one of both, and less to the other.
    fn unless_tied(self, limit: Self) -> Self {
        if !Self::VARIES || self.value() != limit.value() {
            return self;
        }
        let (own, limits) = (self.slopes(), limit.slopes());
        Self::with(self.value(), std::array::from_fn(|i| if own[i] == limits[i] { own[i] } else { f64::NAN }))
    }
}

impl<S: Scalar> Number for S {
    fn constant(value: f64) -> Self {
        Self::of(value)
    }
    fn tuned(parameter: Tangent) -> Self {
        Self::along(parameter)
    }
    fn zero() -> Self {
        Self::of(0.0)
    }
    fn sqrt(self) -> Self {
        let value = self.value().sqrt();
        self.chain(value, if value > 0.0 { 0.5 / value } else { 0.0 })
    }
    fn powf(self, exponent: f64) -> Self {
        let x = self.value();
        if exponent == 1.0 {
            return self;
        }
        if exponent == 2.0 {
            return self * self;
        }
        if x <= 0.0 {
            return self.chain(libm::pow(x, exponent), 0.0);
        }
        let value = libm::pow(x, exponent);
        self.chain(value, exponent * value / x)
    }
    fn pow(self, exponent: Tangent) -> Self {
        let power = self.powf(exponent.value);
        self.with_exponent(power, exponent)
    }
    fn max(self, other: Self) -> Self {
        if self.value() < other.value() { other } else { self }
    }
    fn min(self, other: Self) -> Self {
        if self.value() > other.value() { other } else { self }
    }
    fn if_at_least(left: Self, right: Self, yes: Self, no: Self) -> Self {
        if left.value() >= right.value() { yes } else { no }
    }
}

/// The sign of a number: -1, 0 or 1 (`f64::signum` knows no 0).
pub fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}
