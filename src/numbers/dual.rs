//! Numbers with derivatives: forward-mode automatic differentiation.

use std::marker::PhantomData;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::scalar::KEPT;
use super::{STILL, Scalar, Slopes, Tangent, Varying};

/// A number of the equations without derivatives, for plain runs.
///
/// It is as fast as an `f64`, and an `f64` is no number of the equations, so that nothing that varies is taken for a constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Real {
    /// The value.
    pub value: f64,
}

/// A number with its derivatives in `D` directions of the continuous states, inputs or time (forward-mode automatic
/// differentiation), in a run whose discrete state keeps numbers `H`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const D: usize, H = Real> {
    /// The value.
    pub value: f64,
    /// The derivative of the value in each direction.
    pub slope: [f64; D],
    held: PhantomData<H>,
}

impl<const D: usize, H> Dual<D, H> {
    /// A number with its derivatives.
    pub const fn new(value: f64, slope: [f64; D]) -> Self {
        Self { value, slope, held: PhantomData }
    }

    /// A number that varies with rate 1 in one direction.
    pub fn variable(value: f64, direction: usize) -> Self {
        let mut slope = [0.0; D];
        slope[direction] = 1.0;
        Self::new(value, slope)
    }

    /// The same number among those with further directions, in which it does not vary.
    pub fn widened<const W: usize>(self) -> Dual<W, H> {
        Dual::new(self.value, std::array::from_fn(|i| if i < D { self.slope[i] } else { 0.0 }))
    }

    fn map(self, value: f64, rule: impl Fn(f64) -> f64) -> Self {
        Self::new(value, self.slope.map(rule))
    }

    fn zip(self, other: Self, value: f64, rule: impl Fn(f64, f64) -> f64) -> Self {
        let mut slope = self.slope;
        for (a, b) in slope.iter_mut().zip(other.slope) {
            *a = rule(*a, b);
        }
        Self::new(value, slope)
    }
}

impl Real {
    /// Numbers of the equations for plain ones.
    #[inline(always)]
    pub fn all<const N: usize>(values: &[f64; N]) -> [Self; N] {
        values.map(Self::of)
    }
}

impl Varying for Real {
    const VARIES: bool = false;

    fn with(value: f64, _slopes: Slopes) -> Self {
        Self { value }
    }
    fn slopes(self) -> Slopes {
        STILL
    }
}

impl Serialize for Real {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_newtype_struct(KEPT, &self.value)
    }
}

impl<'de> Deserialize<'de> for Real {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        f64::deserialize(deserializer).map(Self::of)
    }
}

impl Scalar for Real {
    type Held = Self;

    fn held(value: Self) -> Self {
        value
    }
    fn of(value: f64) -> Self {
        Self { value }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn chain(self, value: f64, _derivative: f64) -> Self {
        Self { value }
    }
}

impl<const D: usize, H> Default for Dual<D, H> {
    fn default() -> Self {
        Self::new(0.0, [0.0; D])
    }
}

impl<const D: usize, H: Varying> Scalar for Dual<D, H> {
    type Held = H;

    fn held(value: H) -> Self {
        Self::of(value.value())
    }
    fn of(value: f64) -> Self {
        Self::new(value, [0.0; D])
    }
    fn value(self) -> f64 {
        self.value
    }
    fn chain(self, value: f64, derivative: f64) -> Self {
        self.map(value, |a| derivative * a)
    }
}

impl<const D: usize, H: Varying> Add for Dual<D, H> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, self.value + other.value, |a, b| a + b)
    }
}

impl<const D: usize, H: Varying> Sub for Dual<D, H> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, self.value - other.value, |a, b| a - b)
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
impl<const D: usize, H: Varying> Mul for Dual<D, H> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.zip(other, self.value * other.value, |a, b| a * other.value + self.value * b)
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the quotient rule subtracts and multiplies")]
impl<const D: usize, H: Varying> Div for Dual<D, H> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let value = self.value * inverse;
        // The value is divided, not multiplied by the inverse, so that it has the bits of the plain `f64` equation.
        self.zip(other, self.value / other.value, |a, b| (a - value * b) * inverse)
    }
}

impl<const D: usize, H: Varying> Neg for Dual<D, H> {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(-self.value, |a| -a)
    }
}

impl Neg for Real {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value }
    }
}

impl AddAssign for Real {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Real {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const D: usize, H: Varying> AddAssign for Dual<D, H> {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const D: usize, H: Varying> SubAssign for Dual<D, H> {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const D: usize, H: Varying> Add<f64> for Dual<D, H> {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const D: usize, H: Varying> Sub<f64> for Dual<D, H> {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const D: usize, H: Varying> Mul<f64> for Dual<D, H> {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self.map(self.value * other, |a| a * other)
    }
}

impl<const D: usize, H: Varying> Div<f64> for Dual<D, H> {
    type Output = Self;
    fn div(self, other: f64) -> Self {
        self.map(self.value / other, |a| a / other)
    }
}

/// Constants on the left, and the arithmetic of plain numbers.
macro_rules! constants_on_the_left {
    ($($operator:ident $name:ident;)*) => {$(
        impl<const D: usize, H: Varying> $operator<Dual<D, H>> for f64 {
            type Output = Dual<D, H>;
            #[inline(always)]
            fn $name(self, other: Dual<D, H>) -> Dual<D, H> {
                Dual::of(self).$name(other)
            }
        }
        impl $operator<Real> for f64 {
            type Output = Real;
            #[inline(always)]
            fn $name(self, other: Real) -> Real {
                Real { value: self.$name(other.value) }
            }
        }
        impl $operator for Real {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self { value: self.value.$name(other.value) }
            }
        }
        impl $operator<f64> for Real {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                Self { value: self.value.$name(other) }
            }
        }
        impl $operator<Tangent> for Real {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Tangent) -> Self {
                Self { value: self.value.$name(other.value) }
            }
        }
    )*};
}

constants_on_the_left! {
    Add add;
    Sub sub;
    Mul mul;
    Div div;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Number;

    /// Derivatives of textbook functions, written out by hand.
    #[test]
    fn derivatives_are_those_of_calculus() {
        let x = Dual::<1>::variable(0.7, 0);
        let cases = [
            (x.exp(), 0.7f64.exp()),
            (x.ln(), 1.0 / 0.7),
            (x.asinh(), 1.0 / 1.49f64.sqrt()),
            (x.sqrt(), 0.5 / 0.7f64.sqrt()),
            (x.sin(), 0.7f64.cos()),
            (x.cos(), -0.7f64.sin()),
            (x.tanh(), 1.0 / 0.7f64.cosh().powi(2)),
            (x.atan(), 1.0 / 1.49),
            (x.powf(2.5), 2.5 * 0.7f64.powf(1.5)),
            (x * x / (x + 1.0), (0.49 + 1.4) / 2.89),
            ((-x).abs(), 1.0),
        ];
        for (index, (dual, expected)) in cases.into_iter().enumerate() {
            assert!((dual.slope[0] - expected).abs() < 1e-14, "case {index}: {dual:?}, not {expected}");
        }
    }

    #[test]
    fn value_of_a_dual_has_the_bits_of_the_plain_number() {
        fn equation<S: Scalar>(x: S) -> S {
            (x.powf(0.5) + x.exp() / (x * 3.0 - 0.1)).tanh() / x
        }
        for step in 1..100 {
            let x = f64::from(step) * 0.037;
            assert_eq!(equation(Real::of(x)).value.to_bits(), equation(Dual::<3>::variable(x, 1)).value.to_bits());
        }
    }

    /// The equation of the sums and products of `f64`, with constants on either side.
    #[test]
    fn plain_numbers_have_the_bits_of_f64() {
        for step in 1..100 {
            let x = f64::from(step) * 0.037;
            let (real, plain) = (Real::of(x), (1.0 - x) * 3.0 / (2.0 + x / 7.0) - 0.1 / -x);
            assert_eq!(((1.0 - real) * 3.0 / (2.0 + real / 7.0) - 0.1 / -real).value.to_bits(), plain.to_bits());
        }
    }

    #[test]
    fn constants_on_the_left_keep_the_slope() {
        let x = Dual::<1>::variable(2.0, 0);
        let slopes = [3.0 + x, 3.0 - x, 3.0 * x, 3.0 / x].map(|it| (it.value, it.slope[0]));
        assert_eq!(slopes, [(5.0, 1.0), (1.0, -1.0), (6.0, 3.0), (1.5, -0.75)]);
    }

    #[test]
    fn roots_and_powers_keep_finite_slopes_at_zero() {
        let zero = Dual::<1>::variable(0.0, 0);
        assert!(zero.sqrt().slope[0].is_finite());
        assert!(zero.powf(0.5).slope[0].is_finite());
    }
}
