//! A law of no special kind, with as many states as it likes: here the forces of two bristles.

use pneumatic_servo::friction::parts::parameters::{force, length, viscous};
use pneumatic_servo::prelude::*;

parameters! {
    /// Two of Dahl's bristles side by side, one of which yields earlier. The states are their forces at rated load.
    ///
    /// ```text
    /// dF_i/dt = (W_i*v - |v|*F_i)/z_ci            [N/s]
    /// F       = lambda*(F_1 + F_2) + sigma2*v     [N]
    /// ```
    ///
    /// From rest, after a way `s` in one direction: `F_i = W_i*(1 - exp(-s/z_ci))`.
    TwoBristles {
        stiff_force: Tunable = force(9, "W1", 4.0).text("Force of the stiff bristle");
        stiff_distance: Tunable = length(10, "zc1", 1e-5).text("Distance over which the stiff bristle yields");
        soft_force: Tunable = force(11, "W2", 6.0).text("Force of the soft bristle");
        soft_distance: Tunable = length(12, "zc2", 5e-5).text("Distance over which the soft bristle yields");
        viscous: Tunable = viscous(0.0);
    }
}

impl FrictionLaw for TwoBristles {
    type Memory<S: Varying> = ();

    fn states(&self) -> usize {
        2
    }

    // A law has one deflection, or up to ten forces.
    fn state_kind(&self) -> StateKind {
        StateKind::Force
    }

    fn state_scale(&self) -> f64 {
        10.0
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, f: &[S], _memory: &(), rates: &mut [S]) -> S {
        let v = contact.velocity;
        rates[0] = (v * self.stiff_force - v.abs() * f[0]) / self.stiff_distance;
        rates[1] = (v * self.soft_force - v.abs() * f[1]) / self.soft_distance;
        contact.level * (f[0] + f[1]) + v * self.viscous
    }
}
