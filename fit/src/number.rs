//! A type of numbers with the functions of `libm`, for crates that are generic in the type of numbers.
//!
//! Such a crate takes the functions of `f64` from num-traits, and these are the system's as soon as any crate of a program asks for its
//! feature `std`: the last bits of `hypot` or `ln` would differ from one platform to the next.

use std::iter::Sum;
use std::num::{FpCategory, ParseFloatError};
use std::ops::{Add, Div, Mul, Neg, Rem, Sub};

use num_traits::{Float, FromPrimitive, Num, NumCast, One, ToPrimitive, Zero};

/// A number.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Number(pub f64);

/// Numbers of plain ones.
pub fn numbers(values: &[f64]) -> Vec<Number> {
    values.iter().copied().map(Number).collect()
}

/// Plain numbers.
pub fn plain(numbers: &[Number]) -> Vec<f64> {
    numbers.iter().map(|number| number.0).collect()
}

macro_rules! operators {
    ($($operator:ident::$name:ident),*) => {$(
        impl $operator for Number {
            type Output = Self;

            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0))
            }
        }
    )*};
}

operators! { Add::add, Sub::sub, Mul::mul, Div::div, Rem::rem }

impl Neg for Number {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Sum for Number {
    fn sum<I: Iterator<Item = Self>>(numbers: I) -> Self {
        Self(numbers.map(|number| number.0).sum())
    }
}

impl Zero for Number {
    fn zero() -> Self {
        Self(0.0)
    }

    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

impl One for Number {
    fn one() -> Self {
        Self(1.0)
    }
}

impl Num for Number {
    type FromStrRadixErr = ParseFloatError;

    fn from_str_radix(text: &str, _: u32) -> Result<Self, ParseFloatError> {
        text.parse().map(Self)
    }
}

impl ToPrimitive for Number {
    fn to_i64(&self) -> Option<i64> {
        self.0.to_i64()
    }

    fn to_u64(&self) -> Option<u64> {
        self.0.to_u64()
    }

    fn to_f64(&self) -> Option<f64> {
        Some(self.0)
    }
}

impl NumCast for Number {
    fn from<T: ToPrimitive>(value: T) -> Option<Self> {
        value.to_f64().map(Self)
    }
}

impl FromPrimitive for Number {
    fn from_i64(value: i64) -> Option<Self> {
        value.to_f64().map(Self)
    }

    fn from_u64(value: u64) -> Option<Self> {
        value.to_f64().map(Self)
    }

    fn from_f64(value: f64) -> Option<Self> {
        Some(Self(value))
    }
}

/// Implements [`Float`]: by constants and by functions of `libm` of one and of two numbers; the rest is exact on every platform.
macro_rules! functions {
    ($($constant:ident = $value:expr),*; $($one:ident = $of_one:ident),*; $($two:ident = $of_two:ident),*;) => {
        impl Float for Number {
            $(fn $constant() -> Self {
                Self($value)
            })*

            $(fn $one(self) -> Self {
                Self(libm::$of_one(self.0))
            })*

            $(fn $two(self, other: Self) -> Self {
                Self(libm::$of_two(self.0, other.0))
            })*

            fn is_nan(self) -> bool {
                self.0.is_nan()
            }

            fn is_infinite(self) -> bool {
                self.0.is_infinite()
            }

            fn is_finite(self) -> bool {
                self.0.is_finite()
            }

            fn is_normal(self) -> bool {
                self.0.is_normal()
            }

            fn classify(self) -> FpCategory {
                self.0.classify()
            }

            fn fract(self) -> Self {
                Self(self.0 - libm::trunc(self.0))
            }

            fn signum(self) -> Self {
                Self(self.0.signum())
            }

            fn is_sign_positive(self) -> bool {
                self.0.is_sign_positive()
            }

            fn is_sign_negative(self) -> bool {
                self.0.is_sign_negative()
            }

            fn mul_add(self, factor: Self, summand: Self) -> Self {
                Self(libm::fma(self.0, factor.0, summand.0))
            }

            fn recip(self) -> Self {
                Self(1.0 / self.0)
            }

            /// By products, in an order that is the same everywhere.
            fn powi(self, power: i32) -> Self {
                let mut product = 1.0;
                let (mut factor, mut left) = (self.0, power.unsigned_abs());
                while left > 0 {
                    if left % 2 == 1 {
                        product *= factor;
                    }
                    factor *= factor;
                    left /= 2;
                }
                Self(if power < 0 { 1.0 / product } else { product })
            }

            fn log(self, base: Self) -> Self {
                self.ln() / base.ln()
            }

            fn sin_cos(self) -> (Self, Self) {
                (self.sin(), self.cos())
            }

            fn integer_decode(self) -> (u64, i16, i8) {
                self.0.integer_decode()
            }
        }
    };
}

functions! {
    nan = f64::NAN, infinity = f64::INFINITY, neg_infinity = f64::NEG_INFINITY, neg_zero = -0.0, epsilon = f64::EPSILON,
    min_value = f64::MIN, min_positive_value = f64::MIN_POSITIVE, max_value = f64::MAX;
    floor = floor, ceil = ceil, round = round, trunc = trunc, abs = fabs, sqrt = sqrt, cbrt = cbrt,
    exp = exp, exp2 = exp2, exp_m1 = expm1, ln = log, ln_1p = log1p, log2 = log2, log10 = log10,
    sin = sin, cos = cos, tan = tan, asin = asin, acos = acos, atan = atan,
    sinh = sinh, cosh = cosh, tanh = tanh, asinh = asinh, acosh = acosh, atanh = atanh;
    max = fmax, min = fmin, abs_sub = fdim, powf = pow, hypot = hypot, atan2 = atan2, copysign = copysign;
}
