//! Bends: numbers that rise otherwise to one side of a point than to the other.

use super::memory::SHARE;

/// How much of a difference may be a kink.
pub(super) const ROUGH: f64 = 0.05;
/// The same of rates and computed variables by the memory: what anchors of stiff springs do to a force is next to what the position does,
/// and of the opposite sign, so that little of a kink is much of what is left of both.
pub(super) const EVEN: f64 = 1e-4;
/// How much nearer to stay where there is a kink.
pub(super) const NEAR: f64 = 0.01;

/// Whether numbers below, at and above a point rise otherwise to one side than to the other, by more than a part of what they rise; of
/// a magnitude in which that counts.
pub(super) fn is_bent([below, here, above]: [f64; 3], part: f64, magnitude: f64) -> bool {
    let (rise, fall) = (above - here, here - below);
    let rounding = 64.0 * f64::EPSILON * (above.abs() + here.abs() + below.abs());
    (rise - fall).abs() > part * (rise + fall).abs() + rounding + 1e-3 * SHARE * magnitude
}
