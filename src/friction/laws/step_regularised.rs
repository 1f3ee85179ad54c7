//! Friction as a cubic-step function of velocity.

use crate::friction::parts::of_velocity::VelocityLaw;
use crate::friction::parts::ramp::{Ramp, cubic};
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
    /// Step-regularised friction, as the contacts of multibody programs have it:
    ///
    /// ```text
    /// F = lambda*F_s*S(|v|/v_s)*sgn(v)                               + sigma2*v   |v| <= v_s
    /// F = lambda*(F_s + (F_c - F_s)*S((|v| - v_s)/(v_d - v_s)))*sgn(v) + sigma2*v   v_s < |v| <= v_d
    /// F = lambda*F_c*sgn(v)                                          + sigma2*v   v_d < |v|   [N]
    /// S(q) = 3*q^2 - 2*q^3
    /// ```
    ///
    /// # Validity
    /// No stiction: under any load the mass creeps, and small loads move it at about
    /// `v_s*sqrt(F_applied/(3*lambda*F_s))`, since the curve starts flat.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s` or `v_d <= v_s`.
    ///
    /// # Source
    /// The Coulomb friction of contacts in MSC Adams, with its function STEP.
    StepRegularised {
        ramp: Ramp = Ramp::variables("Speed at which static friction is reached");
    }
}

impl VelocityLaw for StepRegularised {
    fn check(&self) -> Result<(), ParameterError> {
        self.ramp.check()
    }

    fn force<S: Scalar>(&self, velocity: S, level: S) -> S {
        self.ramp.at(velocity, level, cubic)
    }
}
