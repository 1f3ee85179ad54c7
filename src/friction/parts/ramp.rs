//! Curves that climb from zero to static friction and descend to Coulomb friction along a given shape.

use crate::friction::parts::parameters::{check_levels, coulomb_force, static_force, velocity, viscous};
use crate::numbers::{Scalar, sign};
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
    /// Parameters of the curves.
    Parameters {
        static_force: f64 = static_force(11.0);
        coulomb_force: f64 = coulomb_force(8.3);
        peak_velocity: f64 = velocity(2, "vs", 1e-3).text("Speed at which static friction is reached");
        viscous: f64 = viscous(30.0);
        kinetic_velocity: f64 = velocity(5, "vd", 1e-2).text("Speed above which friction is Coulomb friction");
    }
}

impl Parameters {
    /// Checks that levels and velocities fit together.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s` or `v_d <= v_s`.
    pub fn checked(self) -> Result<Self, ParameterError> {
        check_levels(self.static_force, "Fc", self.coulomb_force)?;
        check_velocities(self.peak_velocity, self.kinetic_velocity)?;
        Ok(self)
    }

    /// Friction force in N at a velocity and load level, for a shape from `(0, 0)` to `(1, 1)`.
    pub fn force<S: Scalar>(&self, velocity: S, level: S, shape: impl Fn(S) -> S) -> S {
        let speed = velocity.abs();
        let dry = if speed.value() < self.peak_velocity {
            shape(speed / self.peak_velocity) * self.static_force
        } else {
            let descent = (speed - self.peak_velocity) / (self.kinetic_velocity - self.peak_velocity);
            let fallen = shape(descent.min(S::constant(1.0)));
            fallen * (self.coulomb_force - self.static_force) + self.static_force
        };
        level * dry * sign(velocity.value()) + velocity * self.viscous
    }
}

/// Refuses velocities `vs`, `vd` in the wrong order.
///
/// # Errors
/// [`ParameterError`] that names `vd`.
pub fn check_velocities(peak: f64, kinetic: f64) -> Result<(), ParameterError> {
    if kinetic <= peak {
        return Err(ParameterError::new("vd", kinetic, &format!("it must exceed vs = {peak}")));
    }
    Ok(())
}

/// The cubic step `3*q^2 - 2*q^3` between 0 and 1.
pub fn cubic<S: Scalar>(q: S) -> S {
    q * q * (-q * 2.0 + 3.0)
}
