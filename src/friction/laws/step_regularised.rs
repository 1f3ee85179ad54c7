//! Friction as a cubic-step function of velocity.

use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::ramp::{Parameters, cubic};
use crate::numbers::Scalar;
use crate::variables::ParameterError;

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
#[derive(Clone, Debug)]
pub struct StepRegularised(Parameters);

impl FrictionLaw for StepRegularised {
    type Memory = ();
    type Parameters = Parameters;

    fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.checked().map(Self)
    }

    fn start(&self, _contact: &Contact<f64>, _z: &mut [f64]) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
        self.0.force(contact.velocity, contact.level, cubic)
    }
}
