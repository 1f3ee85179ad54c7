//! A set-valued law: a break-away force, and a curve for sliding.

use pneumatic_servo::friction::parts::parameters::{
    check_forces, coulomb_force, static_force, stribeck_velocity, viscous,
};
use pneumatic_servo::prelude::*;

parameters! {
    /// A Stribeck curve that falls as a hyperbola, with true stiction.
    ///
    /// ```text
    /// at rest:  |F| <= lambda*F_s
    /// sliding:  F = lambda*(F_c + (F_s - F_c)/(1 + (v/v_s)^2))*sgn(v) + sigma2*v
    /// ```
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    HyperbolicStribeck {
        static_force: Tunable = static_force(11.0);
        coulomb_force: Tunable = coulomb_force(8.3);
        stribeck_velocity: Tunable = stribeck_velocity(0.01);
        viscous: Tunable = viscous(30.0);
    }
}

impl SetValued for HyperbolicStribeck {
    fn check(&self) -> Result<(), ParameterError> {
        check_forces(self.static_force, "Fc", self.coulomb_force)
    }

    fn break_away<S: Scalar>(&self, _direction: f64, level: S) -> S {
        level * self.static_force
    }

    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        let ratio = velocity / self.stribeck_velocity;
        let excess = level * (self.static_force - self.coulomb_force) / (ratio * ratio + 1.0);
        (level * self.coulomb_force + excess) * direction + self.viscous * velocity
    }
}
