//! Deviations held against bounds. NaN passes none of them. A bound is at most ten times what is observed, or says why.

use std::fmt::Display;

/// The larger of two numbers; NaN if one of them is.
pub fn larger(one: f64, other: f64) -> f64 {
    if one.is_nan() || other <= one { one } else { other }
}

/// The smaller of two numbers; NaN if one of them is.
pub fn smaller(one: f64, other: f64) -> f64 {
    -larger(-one, -other)
}

/// The largest of numbers that are not negative; NaN if one of them is, 0 if there is none.
pub fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(0.0, larger)
}

/// The largest distance between numbers in pairs; NaN if one of them is.
///
/// # Panics
/// When there are more of one than of the other.
pub fn farthest<'a>(
    some: impl IntoIterator<Item = &'a f64, IntoIter: ExactSizeIterator>,
    others: impl IntoIterator<Item = &'a f64, IntoIter: ExactSizeIterator>,
) -> f64 {
    let (some, others) = (some.into_iter(), others.into_iter());
    assert_eq!(some.len(), others.len(), "as many of one as of the other");
    largest(some.zip(others).map(|(one, other)| (one - other).abs()))
}

/// Demands that a deviation is at most as large as its bound.
///
/// # Panics
/// When it is larger, or NaN.
#[track_caller]
pub fn within(deviation: f64, bound: f64, at: impl Display) {
    assert!(deviation <= bound, "{at}: {deviation:e}, beyond {bound:e}");
}

/// Demands that a number is another one but for a deviation within a bound.
///
/// # Panics
/// When it is farther away, or one of them is NaN.
#[track_caller]
pub fn close(found: f64, expected: f64, bound: f64, at: impl Display) {
    let deviation = (found - expected).abs();
    assert!(deviation <= bound, "{at}: {found:?}, not {expected:?}; {deviation:e} apart, beyond {bound:e}");
}

/// As [`within`], where there is a reason for a bound of more than ten times what is observed.
///
/// # Panics
/// When the deviation is larger, or NaN.
#[track_caller]
pub fn loosely(deviation: f64, bound: f64, reason: &str, at: impl Display) {
    assert!(deviation <= bound, "{at}: {deviation:e}, beyond {bound:e}, which is wide because of {reason}");
}
