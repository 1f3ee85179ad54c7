//! No friction.

use crate::friction::parts::of_velocity::VelocityLaw;
use crate::numbers::Scalar;
use crate::parameters;

parameters! {
    /// No friction: `F = 0`.
    NoFriction {}
}

impl VelocityLaw for NoFriction {
    const IS_NON_STIFF: bool = true;

    fn force<S: Scalar>(&self, _velocity: S, _level: S) -> S {
        S::zero()
    }
}
