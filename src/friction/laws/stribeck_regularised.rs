//! The Stribeck curve with a linear part through zero velocity.

use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::parameters::{coulomb_force, exponent, static_force, stribeck_velocity, velocity, viscous};
use crate::numbers::{Scalar, sign};
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
    /// Parameters of [`StribeckRegularised`].
    Parameters {
        static_force: f64 = static_force(11.0);
        coulomb_force: f64 = coulomb_force(8.3);
        stribeck_velocity: f64 = stribeck_velocity(0.01);
        exponent: f64 = exponent();
        viscous: f64 = viscous(30.0);
        linear_velocity: f64 = velocity(5, "eps", 1e-3).text("Speed below which the force is proportional to velocity");
    }
}

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
#[derive(Clone, Debug)]
pub struct StribeckRegularised {
    curve: StribeckCurve,
    viscous: f64,
    linear_velocity: f64,
}

impl FrictionLaw for StribeckRegularised {
    type Memory = ();
    type Parameters = Parameters;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        let curve = StribeckCurve::new(p.static_force, p.coulomb_force, p.stribeck_velocity, p.exponent)?;
        Ok(Self { curve, viscous: p.viscous, linear_velocity: p.linear_velocity })
    }

    fn start(&self, _contact: &Contact<f64>, _z: &mut [f64]) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
        let v = contact.velocity;
        let level = self.curve.level(v.abs(), contact.level);
        let dry = if v.value().abs() < self.linear_velocity {
            level * v / self.linear_velocity
        } else {
            level * sign(v.value())
        };
        dry + v * self.viscous
    }
}
