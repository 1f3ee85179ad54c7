//! Friction between two speeds: static at the lower one, Coulomb friction from the higher one on.

use super::parameters::{check_forces, coulomb_force, static_force, velocity, viscous};
use crate::numbers::{Scalar, sign};
use crate::parameter_group;
use crate::variables::{ParameterError, Tunable};

parameter_group! {
    /// Static and Coulomb friction and their speeds, of which the first has a meaning of its own in each law.
    Ramp(meaning: &str) {
        static_force: Tunable = static_force(11.0);
        coulomb_force: Tunable = coulomb_force(8.3);
        static_velocity: Tunable = velocity(2, "vs", 1e-3).text(meaning);
        viscous: Tunable = viscous(30.0);
        kinetic_velocity: Tunable = velocity(5, "vd", 1e-2).text("Speed above which friction is Coulomb friction");
    }
}

impl Ramp {
    /// Checks that forces and velocities fit together.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s` or `v_d <= v_s`.
    pub fn check(&self) -> Result<(), ParameterError> {
        check_forces(self.static_force, "Fc", self.coulomb_force)?;
        let [slow, fast] = [self.static_velocity, self.kinetic_velocity].map(|velocity| velocity.value);
        if fast <= slow {
            return Err(ParameterError::new("vd", fast, &format!("it must exceed vs = {slow}")));
        }
        Ok(())
    }

    /// Friction in N at a velocity and load factor that climbs from zero and descends along a shape, which leads from
    /// `(0, 0)` to `(1, 1)`.
    pub fn at<S: Scalar>(&self, velocity: S, level: S, shape: impl Fn(S) -> S) -> S {
        let speed = velocity.abs();
        let dry = if speed.value() < self.static_velocity.value {
            shape(speed / self.static_velocity) * self.static_force
        } else {
            let descent = (speed - self.static_velocity) / (self.kinetic_velocity - self.static_velocity);
            let fallen = shape(descent.min(S::constant(1.0)));
            fallen * (self.coulomb_force - self.static_force) + self.static_force
        };
        level * dry * sign(velocity.value()) + velocity * self.viscous
    }
}

/// The cubic step `3*q^2 - 2*q^3` between 0 and 1.
pub fn cubic<S: Scalar>(q: S) -> S {
    q * q * (-q * 2.0 + 3.0)
}
