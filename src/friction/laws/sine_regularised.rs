//! Friction as a function of velocity made of half sine waves.

use std::f64::consts::FRAC_PI_2;

use crate::friction::parts::of_velocity::VelocityLaw;
use crate::friction::parts::ramp::Ramp;
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
    /// Sine-regularised friction: [`StepRegularised`](super::step_regularised::StepRegularised) with the shape
    ///
    /// ```text
    /// S(q) = (1 - cos(pi*q))/2
    /// ```
    ///
    /// The two differ by at most 1.0009 % of `F_s`.
    ///
    /// # Validity
    /// No stiction: under any load the mass creeps, and small loads move it at about
    /// `v_s*2/pi*sqrt(F_applied/(lambda*F_s))`.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s` or `v_d <= v_s`.
    ///
    /// # Source
    /// The regularised friction of Simpack, as the literature on multibody programs describes it.
    SineRegularised {
        ramp: Ramp = Ramp::variables("Speed at which static friction is reached");
    }
}

impl VelocityLaw for SineRegularised {
    fn check(&self) -> Result<(), ParameterError> {
        self.ramp.check()
    }

    fn force<S: Scalar>(&self, velocity: S, level: S) -> S {
        self.ramp.at(velocity, level, half_wave)
    }
}

/// `(1 - cos(pi*q))/2`, written so that small values keep their digits.
fn half_wave<S: Scalar>(q: S) -> S {
    let sine = (q * FRAC_PI_2).sin();
    sine * sine
}
