//! The Dahl bristle.

use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::parameters::{force_level, stiffness, viscous};
use crate::numbers::{Scalar, sign};
use crate::parameters;
use crate::variables::{ParameterError, Variable, units};

parameters! {
    /// Dahl friction: one state, the bristle deflection `z` in m.
    ///
    /// ```text
    /// dz/dt = v*sgn(a)*|a|^n,   a = 1 - sgn(v)*sigma0*z/(lambda*F_c)   [m/s]
    /// F     = sigma0*z + sigma2*v                                       [N]
    /// ```
    ///
    /// Rate-independent hysteresis before sliding, no stiction peak, drifts under oscillating loads below `F_c`.
    ///
    /// # Validity
    /// `|z| <= lambda*F_c/sigma0` is invariant. Where `lambda*F_c` falls to 0, within the last micronewton, `z` goes to 0.
    ///
    /// # Source
    /// Dahl (1968), A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1.
    Dahl {
        coulomb_force: f64 = force_level(1, "Fc", 10.6).text("Coulomb friction: force of steady sliding");
        stiffness: f64 = stiffness(5, "sigma0", 8e6).text("Bristle stiffness at zero deflection");
        exponent: f64 = Variable::parameter(6, "n", units::ONE, 1.0)
            .range(0.1, 10.0)
            .tunable()
            .text("Shape exponent: below 1 brittle, above 1 ductile contact");
        viscous: f64 = viscous(0.0);
    }
}

impl FrictionLaw for Dahl {
    type Memory = ();
    type Parameters = Self;

    fn new(parameters: Self) -> Result<Self, ParameterError> {
        Ok(parameters)
    }

    fn states(&self) -> usize {
        1
    }

    fn state_scale(&self) -> f64 {
        self.coulomb_force.max(1.0) / self.stiffness
    }

    fn start(&self, _contact: &Contact<f64>, _z: &mut [f64]) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], _memory: &(), rates: &mut [S]) -> S {
        let (v, z) = (contact.velocity, z[0]);
        let limit = contact.level * self.coulomb_force;
        let reserve = (limit - z * (sign(v.value()) * self.stiffness)) / divisor(limit);
        rates[0] = v * reserve.abs().powf(self.exponent) * sign(reserve.value()) + fading_rate(z, limit);
        z * self.stiffness + v * self.viscous
    }
}
