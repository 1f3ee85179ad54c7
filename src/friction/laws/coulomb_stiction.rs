//! Coulomb friction with a break-away force above the kinetic force.

use crate::friction::parts::parameters::{check_forces, coulomb_force, static_force, viscous};
use crate::friction::parts::stick_slip::SetValued;
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::{ParameterError, Tunable};

parameters! {
    /// Coulomb friction with stiction, set-valued at rest.
    ///
    /// ```text
    /// stuck:    v = 0, F = F_applied               while |F_applied| <= lambda*F_s
    /// sliding:  F = lambda*F_c*sgn(v) + sigma2*v   [N]
    /// ```
    ///
    /// The force jumps from `F_s` to `F_c` when sliding starts.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    CoulombStiction {
        static_force: Tunable = static_force(11.0);
        coulomb_force: Tunable = coulomb_force(8.3);
        viscous: Tunable = viscous(30.0);
    }
}

impl SetValued for CoulombStiction {
    fn check(&self) -> Result<(), ParameterError> {
        check_forces(self.static_force, "Fc", self.coulomb_force)
    }

    fn break_away<S: Scalar>(&self, _direction: f64, level: S) -> S {
        level * self.static_force
    }

    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        level * (self.coulomb_force * direction) + velocity * self.viscous
    }
}
