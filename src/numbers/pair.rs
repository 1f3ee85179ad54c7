//! Two numbers side by side: two parts with the same equations are evaluated at the same time.
//!
//! Every processor of today adds, multiplies, divides and takes roots of two numbers with one instruction, and the
//! compiler finds these as long as both numbers take the same path: a [`Number`] offers selections in place of branches.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Dual, Number, Scalar, Tangent, Tangents};

/// Two numbers side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<S>(pub [S; 2]);

impl<S: Scalar> Pair<S> {
    /// The sum of both.
    pub fn sum(self) -> S {
        let Self([a, b]) = self;
        a + b
    }

    /// Both in the other order.
    pub fn swapped(self) -> Self {
        let Self([a, b]) = self;
        Self([b, a])
    }

    fn zip(self, other: Self, rule: impl Fn(S, S) -> S) -> Self {
        let (Self([a, b]), Self([c, d])) = (self, other);
        Self([rule(a, c), rule(b, d)])
    }

    fn with<T>(self, [c, d]: [T; 2], rule: impl Fn(S, T) -> S) -> Self {
        let Self([a, b]) = self;
        Self([rule(a, c), rule(b, d)])
    }
}

impl<const D: usize, H> Pair<Dual<D, H>> {
    /// The same numbers among those with further directions, in which they do not vary.
    pub fn widened<const W: usize>(self) -> Pair<Dual<W, H>> {
        Pair(self.0.map(Dual::widened))
    }
}

/// Arithmetic with another pair, and with constants and parameters: one for both numbers or one for each.
macro_rules! pair_arithmetic {
    ($($operator:ident $name:ident;)*) => {$(
        impl<S: Scalar> $operator for Pair<S> {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                self.zip(other, S::$name)
            }
        }
        impl<S: Scalar> $operator<f64> for Pair<S> {
            type Output = Self;
            fn $name(self, other: f64) -> Self {
                self.with([other; 2], S::$name)
            }
        }
        impl<S: Scalar> $operator<[f64; 2]> for Pair<S> {
            type Output = Self;
            fn $name(self, others: [f64; 2]) -> Self {
                self.with(others, S::$name)
            }
        }
        impl<S: Scalar> $operator<Tangent> for Pair<S> {
            type Output = Self;
            fn $name(self, other: Tangent) -> Self {
                self.with([other; 2], S::$name)
            }
        }
        impl<S: Scalar> $operator<Tangents> for Pair<S> {
            type Output = Self;
            fn $name(self, others: Tangents) -> Self {
                self.with([others.side(0), others.side(1)], S::$name)
            }
        }
    )*};
}

pair_arithmetic! {
    Add add;
    Sub sub;
    Mul mul;
    Div div;
}

impl<S: Scalar> Neg for Pair<S> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(S::neg))
    }
}

impl<S: Scalar> Number for Pair<S> {
    fn constant(value: f64) -> Self {
        Self([S::constant(value); 2])
    }
    fn tuned(parameter: Tangent) -> Self {
        Self([S::tuned(parameter); 2])
    }
    fn zero() -> Self {
        Self([S::zero(); 2])
    }
    fn sqrt(self) -> Self {
        Self(self.0.map(S::sqrt))
    }
    fn powf(self, exponent: f64) -> Self {
        Self(self.0.map(|it| it.powf(exponent)))
    }
    fn pow(self, exponent: Tangent) -> Self {
        Self(self.0.map(|it| it.pow(exponent)))
    }
    fn max(self, other: Self) -> Self {
        self.zip(other, S::max)
    }
    fn min(self, other: Self) -> Self {
        self.zip(other, S::min)
    }
    fn if_at_least(left: Self, right: Self, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| S::if_at_least(left.0[i], right.0[i], yes.0[i], no.0[i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    /// Both numbers of a pair have the bits that they have alone.
    #[test]
    fn pair_does_what_its_numbers_do() {
        fn equation<N: Number>(x: N, y: N) -> N {
            let root = (x.max(y) / x.min(y) + 0.5).sqrt();
            N::if_at_least(x, y, root, -root.powf(0.3) * 2.0) - x * y
        }
        let (x, y) = (Real::all(&[0.7, 3.1]), Real::all(&[1.9, 0.2]));
        let Pair(both) = equation(Pair(x), Pair(y));
        assert_eq!(both, [0, 1].map(|i| equation(x[i], y[i])));
        assert_eq!(Pair(x) * [2.0, 3.0] - [0.1, 0.2], Pair([x[0] * 2.0 - 0.1, x[1] * 3.0 - 0.2]));
    }
}
