//! Bristles whose friction level falls to zero fade away.

use crate::numbers::Scalar;

/// A friction level in N below which bristles fade away, so that no law divides by a level of zero.
const LEAST_LEVEL: f64 = 1e-6;

/// What a bristle law divides by in place of a friction level: the same except where that fades away.
pub fn divisor<S: Scalar>(level: S) -> S {
    level.max(S::constant(LEAST_LEVEL))
}

/// Rate at which a bristle goes back to zero deflection (or force) where its friction level fades away; 0 elsewhere.
pub fn fading_rate<S: Scalar>(z: S, level: S) -> S {
    const RELAXATION: f64 = 1e6; // 1/s: at once, on the scale of any step
    let share = -level / LEAST_LEVEL + 1.0;
    if share.value() > 0.0 { -z * share * RELAXATION } else { S::zero() }
}
