//! Coulomb friction smoothed by a hyperbolic tangent.

use crate::friction::parts::of_velocity::VelocityLaw;
use crate::friction::parts::parameters::{coulomb_force, velocity, viscous};
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::Tunable;

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
        coulomb_force: Tunable = coulomb_force(8.3);
        smoothing_velocity: Tunable = velocity(5, "vd", 1e-3).text("Smoothing velocity of the hyperbolic tangent");
        viscous: Tunable = viscous(30.0);
    }
}

impl VelocityLaw for SmoothCoulomb {
    fn force<S: Scalar>(&self, velocity: S, level: S) -> S {
        let smoothed = (velocity / self.smoothing_velocity).tanh();
        level * smoothed * self.coulomb_force + velocity * self.viscous
    }
}
