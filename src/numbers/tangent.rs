//! A number and its slopes in a few directions, in which tunable parameters may vary, too.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::scalar::KEPT;
use super::{Dual, Pair, Scalar, Varying};

/// Directions in which a [`Tangent`] has slopes. Runs that differ in nothing but the direction share values, steps and events.
pub const DIRECTIONS: usize = if cfg!(feature = "sensitivities") { 2 } else { 1 };

/// A slope in each direction.
pub type Slopes = [f64; DIRECTIONS];

/// No slope in any direction.
pub const STILL: Slopes = [0.0; DIRECTIONS];

/// A number with its slopes in [`DIRECTIONS`].
///
/// Tunable parameters are such numbers, and every [`Number`](super::Number) can be combined with them. Slopes of parameters are handed
/// on where the equations are evaluated with tangents; all other numbers see the values alone, so that a run costs no
/// more than with plain parameters.
///
/// A plain `f64` combined with a tangent is a tangent, on either side: `1.0 - b` has the slope of `-b`. Only who asks for the
/// [value](Self::value) leaves the slope behind. A tangent combined with a number of the equations is such a number, on either
/// side: `v * damping`, `damping * v`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tangent {
    /// The value.
    pub value: f64,
    /// Derivatives in the directions.
    pub slopes: Slopes,
}

impl Tangent {
    /// A number that does not vary.
    pub const fn still(value: f64) -> Self {
        Self { value, slopes: STILL }
    }

    /// A number that varies in the first direction alone.
    pub fn varying(value: f64, slope: f64) -> Self {
        Self { value, slopes: first(slope) }
    }

    /// Whether a part that is off at 0 is there: it has a value, or is differentiated by.
    pub fn is_used(self) -> bool {
        self.value != 0.0 || self.slopes != STILL
    }

    fn dual(self) -> Dual<DIRECTIONS> {
        Dual::new(self.value, self.slopes)
    }
}

/// A slope in the first direction alone.
pub(crate) fn first(slope: f64) -> Slopes {
    let mut slopes = STILL;
    slopes[0] = slope;
    slopes
}

/// A number that does not vary.
impl From<f64> for Tangent {
    fn from(value: f64) -> Self {
        Self::still(value)
    }
}

impl From<Dual<DIRECTIONS>> for Tangent {
    fn from(Dual { value, slope: slopes, .. }: Dual<DIRECTIONS>) -> Self {
        Self { value, slopes }
    }
}

impl Varying for Tangent {
    const VARIES: bool = true;

    fn with(value: f64, slopes: Slopes) -> Self {
        Self { value, slopes }
    }
    fn slopes(self) -> Slopes {
        self.slopes
    }
}

impl Serialize for Tangent {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_newtype_struct(KEPT, &(self.value, self.slopes))
    }
}

impl<'de> Deserialize<'de> for Tangent {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        <(f64, Slopes)>::deserialize(deserializer).map(|(value, slopes)| Self { value, slopes })
    }
}

impl Scalar for Tangent {
    type Held = Self;

    fn held(value: Self) -> Self {
        value
    }
    fn of(value: f64) -> Self {
        Self::still(value)
    }
    fn along(tangent: Tangent) -> Self {
        tangent
    }
    fn value(self) -> f64 {
        self.value
    }
    // Loops, since `map` and `from_fn` of arrays are not always inlined, and these are called at every operation.
    #[inline(always)]
    fn chain(self, value: f64, derivative: f64) -> Self {
        let mut slopes = self.slopes;
        for slope in &mut slopes {
            *slope *= derivative;
        }
        Self { value, slopes }
    }
    #[inline(always)]
    fn chain_with(self, value: f64, derivative: f64, parameter: Tangent, by_parameter: f64) -> Self {
        let mut slopes = self.slopes;
        for (slope, other) in slopes.iter_mut().zip(parameter.slopes) {
            *slope = derivative * *slope + by_parameter * other;
        }
        Self { value, slopes }
    }
    fn with_exponent(self, Self { value, slopes }: Self, exponent: Tangent) -> Self {
        // The logarithm of 0 times the power, which is 0 there.
        let by_exponent = if self.value > 0.0 { value * libm::log(self.value) } else { 0.0 };
        Self { value, slopes: std::array::from_fn(|i| slopes[i] + by_exponent * exponent.slopes[i]) }
    }
}

impl Neg for Tangent {
    type Output = Self;
    fn neg(self) -> Self {
        (-self.dual()).into()
    }
}

/// Arithmetic of tangents with `f64`, and of the numbers of the equations with the value of a tangent.
macro_rules! arithmetic {
    ($($operator:ident $name:ident: |$p:ident, $x:ident| [$by_number:expr, $by_parameter:expr];)*) => {$(
        impl $operator<f64> for Tangent {
            type Output = Self;
            fn $name(self, other: f64) -> Self {
                self.dual().$name(other).into()
            }
        }
        impl $operator<Tangent> for f64 {
            type Output = Tangent;
            fn $name(self, other: Tangent) -> Tangent {
                Tangent::still(self).dual().$name(other.dual()).into()
            }
        }
        impl<const D: usize, H: Varying> $operator<Tangent> for Dual<D, H> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Tangent) -> Self {
                self.$name(other.value)
            }
        }
        /// A parameter on the left; of two tangents both vary.
        impl<S: Scalar> $operator<S> for Tangent {
            type Output = S;
            #[inline(always)]
            fn $name(self, other: S) -> S {
                let ($p, $x) = (self.value, other.value());
                other.chain_with($p.$name($x), $by_number, self, $by_parameter)
            }
        }
        impl<S: Scalar> $operator<Pair<S>> for Tangent {
            type Output = Pair<S>;
            #[inline(always)]
            fn $name(self, other: Pair<S>) -> Pair<S> {
                Pair(other.0.map(|number| self.$name(number)))
            }
        }
    )*};
}

arithmetic! {
    Add add: |p, x| [1.0, 1.0];
    Sub sub: |p, x| [-1.0, 1.0];
    Mul mul: |p, x| [p, x];
    Div div: |p, x| [-(p / x) / x, 1.0 / x];
}

/// By its value.
impl PartialEq<f64> for Tangent {
    fn eq(&self, other: &f64) -> bool {
        self.value == *other
    }
}

/// By its value.
impl PartialOrd<f64> for Tangent {
    fn partial_cmp(&self, other: &f64) -> Option<std::cmp::Ordering> {
        self.value.partial_cmp(other)
    }
}

impl AddAssign for Tangent {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Tangent {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Two tangents side by side, for a [`Pair`](super::Pair): the two values are contiguous in memory, as in the pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangents {
    /// The values.
    pub values: [f64; 2],
    /// The slopes.
    pub slopes: [Slopes; 2],
}

impl Tangents {
    /// Both, one after the other.
    pub fn each(self) -> [Tangent; 2] {
        [self.side(0), self.side(1)]
    }

    /// One of them.
    #[inline(always)]
    pub fn side(self, side: usize) -> Tangent {
        Tangent { value: self.values[side], slopes: self.slopes[side] }
    }
}

impl From<[Tangent; 2]> for Tangents {
    fn from(both: [Tangent; 2]) -> Self {
        Self { values: both.map(|it| it.value), slopes: both.map(|it| it.slopes) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::{Number, Real};

    /// A varying parameter gives the slope of a variable in the same place.
    #[test]
    fn slopes_of_parameters_are_those_of_variables() {
        fn equation<S: Scalar>(x: S, p: Tangent) -> S {
            ((x * p + S::along(p)).pow(p) / p - p).abs().sqrt()
        }
        let (x, p) = (Tangent::still(0.7), Tangent::varying(1.3, 2.0));
        let plain = |p: f64| equation(Real::of(0.7), Tangent::still(p)).value;
        let step = 1e-6;
        let expected = 2.0 * (plain(1.3 + step) - plain(1.3 - step)) / (2.0 * step);
        let Tangent { value, slopes: [slope, ..] } = equation(x, p);
        assert_eq!(value, plain(1.3));
        assert!((slope / expected - 1.0).abs() < 1e-8, "{slope}, not {expected}");
    }

    /// `c - p` has the slope of `-p + c`, in each operation.
    #[test]
    fn constants_on_the_left_keep_the_slope() {
        let p = Tangent::varying(2.0, 5.0);
        let of = Tangent::varying;
        assert_eq!([3.0 + p, 3.0 - p, 3.0 * p, 3.0 / p], [of(5.0, 5.0), of(1.0, -5.0), of(6.0, 15.0), of(1.5, -3.75)]);
    }

    /// A parameter on the left of a number of the equations.
    #[test]
    fn parameters_on_the_left_are_those_on_the_right() {
        fn of<S: Scalar>(p: Tangent, x: S) -> [S; 4] {
            [p + x, p - x, p * x, p / x]
        }
        let p = Tangent::varying(2.0, 5.0);
        let at = Tangent::varying;
        assert_eq!(of(p, at(4.0, 3.0)), [at(6.0, 8.0), at(-2.0, 2.0), at(8.0, 26.0), at(0.5, 0.875)]);
        let dual = |value: f64, slope: f64| Dual::<1>::new(value, [slope]);
        assert_eq!(of(p, dual(4.0, 1.0)), [dual(6.0, 1.0), dual(-2.0, -1.0), dual(8.0, 2.0), dual(0.5, -0.125)]);
        assert_eq!(of(p, Real::of(4.0)).map(Real::value), [6.0, -2.0, 8.0, 0.5]);
        assert_eq!(p - Pair([Real::of(4.0), Real::of(1.0)]), Pair([Real::of(-2.0), Real::of(1.0)]));
    }

    #[test]
    fn other_numbers_see_values_alone() {
        let p = Tangent::varying(3.0, 1.0);
        let two = Real::of(2.0);
        assert_eq!([two - p, Real::along(p), two.pow(p)].map(Real::value), [-1.0, 3.0, 8.0]);
        assert_eq!(Dual::<2>::variable(2.0, 1) * p, Dual::<2>::variable(2.0, 1) * 3.0);
    }
}
