//! A law with one continuous state: a bristle whose stiffness grows with the load.

use pneumatic_servo::friction::parts::parameters::{coulomb_force, length, viscous};
use pneumatic_servo::prelude::*;

parameters! {
    /// Dahl's bristle on a contact that yields over the same distance at any load, so that its stiffness is in proportion
    /// to the load.
    ///
    /// ```text
    /// dz/dt = v - |v|*z/z_c              [m/s]
    /// F     = lambda*F_c*z/z_c + sigma2*v  [N]
    /// ```
    ///
    /// From rest, after a way `s` in one direction: `z = z_c*(1 - exp(-s/z_c))`.
    LoadedDahl {
        coulomb_force: Tunable = coulomb_force(10.0);
        distance: Tunable = length(9, "zc", 1e-5).text("Distance over which the contact yields");
        viscous: Tunable = viscous(0.0);
    }
}

impl BristleLaw for LoadedDahl {
    type Memory<S: Varying> = ();

    fn scale(&self) -> f64 {
        self.distance.value
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, _memory: &()) -> (S, S) {
        let v = contact.velocity;
        let rate = v - v.abs() * z / self.distance;
        (contact.level * self.coulomb_force * z / self.distance + self.viscous * v, rate)
    }
}
