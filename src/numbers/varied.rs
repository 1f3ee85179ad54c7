//! A number with slopes in several directions, in which tunable parameters vary, too.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::{Dual, Number, Scalar, Tangent};

/// A number with its slopes in `K` directions at once, the first of those in which tunable parameters vary.
///
/// Its value has the bits of a [`Real`](super::Real).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Varied<const K: usize>(pub Dual<K>);

impl<const K: usize> Varied<K> {
    /// A number with its slopes.
    pub fn new(value: f64, slope: [f64; K]) -> Self {
        Self(Dual { value, slope })
    }
}

impl<const K: usize> Scalar for Varied<K> {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Self(Dual::of(value))
    }
    #[inline(always)]
    fn along(parameter: Tangent) -> Self {
        Self(parameter.narrow())
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.0.value
    }
    #[inline(always)]
    fn chain(self, value: f64, derivative: f64) -> Self {
        Self(self.0.chain(value, derivative))
    }
    #[inline(always)]
    fn chain_with(self, value: f64, derivative: f64, parameter: Tangent, by_parameter: f64) -> Self {
        let slope = std::array::from_fn(|i| derivative * self.0.slope[i] + by_parameter * parameter.slopes[i]);
        Self(Dual { value, slope })
    }
    #[inline(always)]
    fn pow(self, exponent: Tangent) -> Self {
        let Self(Dual { value, slope }) = self.powf(exponent.value);
        // The logarithm of 0 times the power, which is 0 there.
        let by_exponent = if self.0.value > 0.0 && exponent.slopes != [0.0; super::WAYS] {
            value * libm::log(self.0.value)
        } else {
            0.0
        };
        Self(Dual { value, slope: std::array::from_fn(|i| slope[i] + by_exponent * exponent.slopes[i]) })
    }
}

impl<const K: usize> Neg for Varied<K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! arithmetic {
    ($($operator:ident $name:ident;)*) => {$(
        impl<const K: usize> $operator for Varied<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0))
            }
        }
        impl<const K: usize> $operator<f64> for Varied<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                Self(self.0.$name(other))
            }
        }
        impl<const K: usize> $operator<Tangent> for Varied<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Tangent) -> Self {
                Self(self.0.$name(other.narrow::<K>()))
            }
        }
    )*};
}

arithmetic! {
    Add add;
    Sub sub;
    Mul mul;
    Div div;
}

impl<const K: usize> AddAssign for Varied<K> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const K: usize> SubAssign for Varied<K> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
