//! A law whose states depend on each other: a bristle whose force lags behind.

use pneumatic_servo::friction::parts::parameters::{force, length, viscous};
use pneumatic_servo::prelude::*;

parameters! {
    /// Dahl's bristle behind a film that passes its force on with a lag. The states are both forces at rated load.
    ///
    /// ```text
    /// dF_1/dt = (F_c*v - |v|*F_1)/z_c             [N/s]
    /// dF_2/dt = (F_1 - F_2)/tau                   [N/s]
    /// F       = lambda*F_2 + sigma2*v             [N]
    /// ```
    ///
    /// From rest at a constant velocity, with `a = v/z_c`: `F_2 = F_c*(1 - (exp(-a*t) - a*tau*exp(-t/tau))/(1 - a*tau))`.
    LaggedBristle {
        coulomb: Tunable = force(9, "Fc", 8.3).text("Force of the bristle");
        distance: Tunable = length(10, "zc", 1e-4).text("Distance over which the bristle yields");
        lag: Tunable = Variable::parameter(11, "tau", units::SECOND, 0.02).range(1e-4, 10.0).text("Lag of the film");
        viscous: Tunable = viscous(30.0);
    }
}

impl FrictionLaw for LaggedBristle {
    type Memory<S: Varying> = ();

    const STATES: &'static [LawState<Self>] = &[
        LawState::new("bristle", units::NEWTON, |law: &Self| law.coulomb.value)
            .text("Force of the bristle at rated load"),
        LawState::new("film", units::NEWTON, |law: &Self| law.coulomb.value)
            .text("Force that the film passes on at rated load"),
    ];

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, f: &[S], _memory: &(), rates: &mut [S]) -> S {
        let v = contact.velocity;
        rates[0] = (v * self.coulomb - v.abs() * f[0]) / self.distance;
        rates[1] = (f[0] - f[1]) / self.lag;
        contact.level * f[1] + v * self.viscous
    }
}
