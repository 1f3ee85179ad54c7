//! A law that is a function of velocity.

use pneumatic_servo::friction::parts::parameters::{coulomb_force, viscous};
use pneumatic_servo::prelude::*;

parameters! {
    /// Coulomb friction smoothed by a root.
    ///
    /// ```text
    /// F = lambda*F_c*v/sqrt(v^2 + v_c^2) + sigma2*v  [N]
    /// ```
    RootedCoulomb {
        coulomb_force: Tunable = coulomb_force(8.3);
        creep: Tunable = Variable::parameter(9, "vc", units::METRE_PER_SECOND, 1e-3).range(1e-6, 1.0).shown_in("mm/s")
            .text("Velocity up to which the contact creeps");
        viscous: Tunable = viscous(30.0);
    }
}

impl VelocityLaw for RootedCoulomb {
    fn force<S: Scalar>(&self, v: S, level: S) -> S {
        let speed = (v * v + self.creep * self.creep).sqrt();
        level * v / speed * self.coulomb_force + v * self.viscous
    }
}
