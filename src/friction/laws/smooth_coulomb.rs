//! Coulomb friction smoothed by a hyperbolic tangent.

use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::parameters::{coulomb_force, velocity, viscous};
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
    /// Smooth Coulomb friction.
    ///
    /// ```text
    /// F = lambda*F_c*tanh(v/v_d) + sigma2*v   [N]
    /// ```
    ///
    /// # Validity
    /// No stiction: under any load the mass creeps, at about `v_d*F_applied/F_c` for small loads.
    SmoothCoulomb {
        coulomb_force: f64 = coulomb_force(8.3);
        smoothing_velocity: f64 = velocity(5, "vd", 1e-3).text("Smoothing velocity of the hyperbolic tangent");
        viscous: f64 = viscous(30.0);
    }
}

impl FrictionLaw for SmoothCoulomb {
    type Memory = ();
    type Parameters = Self;

    fn new(parameters: Self) -> Result<Self, ParameterError> {
        Ok(parameters)
    }

    fn start(&self, _contact: &Contact<f64>, _z: &mut [f64]) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
        let smoothed = (contact.velocity / self.smoothing_velocity).tanh();
        contact.level * smoothed * self.coulomb_force + contact.velocity * self.viscous
    }
}
