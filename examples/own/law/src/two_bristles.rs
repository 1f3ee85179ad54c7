//! A law of no special kind, with states that it names: here the deflections of two bristles.

use pneumatic_servo::friction::parts::parameters::{force, length, viscous};
use pneumatic_servo::prelude::*;

parameters! {
    /// Two of Dahl's bristles side by side, one of which yields earlier.
    ///
    /// ```text
    /// dz_i/dt = v - |v|*z_i/z_ci                                    [m/s]
    /// F       = lambda*(W_1*z_1/z_c1 + W_2*z_2/z_c2) + sigma2*v     [N]
    /// ```
    ///
    /// From rest, after a way `s` in one direction: `z_i = z_ci*(1 - exp(-s/z_ci))`.
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

    const STATES: &'static [LawState<Self>] = &[
        LawState::new("stiff", units::METRE, |law: &Self| law.stiff_distance.value)
            .text("Deflection of the stiff bristle"),
        LawState::new("soft", units::METRE, |law: &Self| law.soft_distance.value)
            .text("Deflection of the soft bristle"),
    ];

    // Each bristle yields by itself.
    fn couples_states() -> bool {
        false
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], _memory: &(), rates: &mut [S]) -> S {
        let (v, [stiff, soft]) = (contact.velocity, [z[0] / self.stiff_distance, z[1] / self.soft_distance]);
        rates[0] = v - v.abs() * stiff;
        rates[1] = v - v.abs() * soft;
        contact.level * (self.stiff_force * stiff + self.soft_force * soft) + self.viscous * v
    }
}
