//! Friction as a function of velocity made of half sine waves.

use std::f64::consts::FRAC_PI_2;

use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::ramp::Parameters;
use crate::numbers::Scalar;
use crate::variables::ParameterError;

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
#[derive(Clone, Debug)]
pub struct SineRegularised(Parameters);

impl FrictionLaw for SineRegularised {
    type Memory = ();
    type Parameters = Parameters;

    fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.checked().map(Self)
    }

    fn start(&self, _contact: &Contact<f64>, _z: &mut [f64]) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
        self.0.force(contact.velocity, contact.level, half_wave)
    }
}

/// `(1 - cos(pi*q))/2`, written so that small values keep their digits.
fn half_wave<S: Scalar>(q: S) -> S {
    let sine = (q * FRAC_PI_2).sin();
    sine * sine
}
