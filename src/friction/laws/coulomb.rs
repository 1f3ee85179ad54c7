//! Coulomb friction with true stiction.

use crate::friction::parts::parameters::{coulomb_force, viscous};
use crate::friction::parts::stick_slip::SetValued;
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::Tunable;

parameters! {
    /// Coulomb friction, set-valued at rest.
    ///
    /// ```text
    /// stuck:    v = 0, F = F_applied               while |F_applied| <= lambda*F_c
    /// sliding:  F = lambda*F_c*sgn(v) + sigma2*v   [N]
    /// ```
    ///
    /// # Source
    /// Coulomb (1785), Theorie des machines simples.
    Coulomb {
        coulomb_force: Tunable = coulomb_force(8.3);
        viscous: Tunable = viscous(30.0);
    }
}

impl SetValued for Coulomb {
    fn break_away<S: Scalar>(&self, _direction: f64, level: S) -> S {
        level * self.coulomb_force
    }

    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        level * (self.coulomb_force * direction) + velocity * self.viscous
    }
}
