//! A law with two states of different units, which depend on each other: a bristle that softens as it warms.

use pneumatic_servo::friction::parts::parameters::{coulomb_force, length, viscous};
use pneumatic_servo::prelude::*;
use pneumatic_servo::variables::Unit;

// Units that the library does not have, by the exponents of kg, m, s, A, K, mol, cd and rad.
const WATT_PER_KELVIN: Unit = Unit { name: "W/K", base: [1, 2, -3, 0, -1, 0, 0, 0], display: &[] };
const PER_KELVIN: Unit = Unit { name: "1/K", base: [0, 0, 0, 0, -1, 0, 0, 0], display: &[] };

parameters! {
    /// Dahl's bristle whose friction fades with the temperature that its work brings about.
    ///
    /// ```text
    /// dz/dt = v - |v|*z/z_c                                [m/s]
    /// dT/dt = (F_b*v/C - (T - T_0))/tau                    [K/s]
    /// F_b   = lambda*F_c*z/z_c/(1 + beta*(T - T_0))        [N]
    /// F     = F_b + sigma2*v                               [N]
    /// ```
    ///
    /// In steady sliding at `v > 0` the warming `w = T - T_0` solves `C*w*(1 + beta*w) = lambda*F_c*v`.
    WarmBristle {
        coulomb: Tunable = coulomb_force(8.3);
        distance: Tunable = length(9, "zc", 1e-5).text("Distance over which the bristle yields");
        conductance: Tunable = Variable::parameter(10, "C", WATT_PER_KELVIN, 0.2).range(1e-3, 1e6)
            .text("Heat that the contact gives off");
        lag: Tunable = Variable::parameter(11, "tau", units::SECOND, 0.1).range(1e-3, 1e6)
            .text("Time constant of the warming");
        fading: Tunable = Variable::parameter(12, "beta", PER_KELVIN, 0.02).range(0.0, 10.0)
            .text("Fading of friction with temperature");
        ambient: Tunable = Variable::parameter(13, "T0", units::KELVIN, 293.15).range(200.0, 500.0)
            .text("Ambient temperature");
        viscous: Tunable = viscous(30.0);
    }
}

impl FrictionLaw for WarmBristle {
    type Memory<S: Varying> = ();

    const STATES: &'static [LawState<Self>] = &[
        LawState::new("bristle", units::METRE, |law: &Self| law.distance.value).text("Deflection of the bristle"),
        LawState::new("temperature", units::KELVIN, |_| 10.0).range(1.0, 2000.0).text("Temperature of the contact"),
    ];

    fn start_states<S: Varying>(&self, _contact: &Contact<S>, z: &mut [S]) {
        z[1] = S::tuned(self.ambient);
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], _memory: &(), rates: &mut [S]) -> S {
        let (v, [bristle, temperature]) = (contact.velocity, [z[0], z[1]]);
        let warming = temperature - self.ambient;
        let force = contact.level * self.coulomb * bristle / self.distance / (self.fading * warming + 1.0);
        rates[0] = v - v.abs() * bristle / self.distance;
        rates[1] = (force * v / self.conductance - warming) / self.lag;
        force + self.viscous * v
    }
}
