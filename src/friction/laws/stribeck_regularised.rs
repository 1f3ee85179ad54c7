//! The Stribeck curve with a linear part through zero velocity.

use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::of_velocity::VelocityLaw;
use crate::friction::parts::parameters::{velocity, viscous};
use crate::numbers::{Scalar, sign};
use crate::parameters;
use crate::variables::{ParameterError, Tunable};

parameters! {
    /// Regularised Stribeck friction.
    ///
    /// ```text
    /// F = s(v)*v/eps   + sigma2*v   for |v| < eps
    /// F = s(v)*sgn(v)  + sigma2*v   otherwise   [N], s the Stribeck curve
    /// ```
    ///
    /// With `F_s = F_c` this is the linearly smoothed Coulomb law.
    ///
    /// # Validity
    /// No stiction: under any load the mass creeps.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    StribeckRegularised {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        linear_velocity: Tunable = velocity(5, "eps", 1e-3).text("Speed below which the force is proportional to velocity");
    }
}

impl VelocityLaw for StribeckRegularised {
    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()
    }

    fn force<S: Scalar>(&self, velocity: S, level: S) -> S {
        let limit = self.curve.at(velocity.abs(), level);
        let dry = if velocity.value().abs() < self.linear_velocity.value {
            limit * velocity / self.linear_velocity
        } else {
            limit * sign(velocity.value())
        };
        dry + velocity * self.viscous
    }
}
