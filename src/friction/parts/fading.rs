//! Bristles whose limit falls to zero fade away.

use crate::numbers::Scalar;

/// A limit of friction in N below which bristles fade away, so that no law divides by zero.
const LEAST_LIMIT: f64 = 1e-6;

/// Divisor of a bristle law for its limit in N: the limit itself except where it fades away.
pub fn divisor<S: Scalar>(limit: S) -> S {
    limit.max(S::constant(LEAST_LIMIT))
}

/// Rate at which a bristle goes back to zero deflection (or force) where its limit in N fades away; 0 elsewhere.
pub fn fading_rate<S: Scalar>(z: S, limit: S) -> S {
    const RELAXATION: f64 = 1e6; // 1/s: at once, on the scale of any step
    let share = -limit / LEAST_LIMIT + 1.0;
    if share.value() > 0.0 { -z * share * RELAXATION } else { S::zero() }
}
