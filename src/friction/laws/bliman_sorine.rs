//! The Bliman-Sorine law of second order.

use crate::friction::law::{Contact, FrictionLaw, StateKind};
use crate::friction::parts::fading::fading_rate;
use crate::friction::parts::parameters::{force, length, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{ParameterError, Tunable, Variable, units};

parameters! {
    /// Bliman-Sorine friction: the difference of a fast and a slow Dahl element. Two states, their forces in N.
    ///
    /// ```text
    /// dz1/dt = |v|*( lambda*f1*sgn(v) - z1)/(eta*x_e)   [N/s]
    /// dz2/dt = |v|*(-lambda*f2*sgn(v) - z2)/x_e         [N/s]
    /// F      = z1 + z2 + sigma2*v                       [N]
    /// ```
    ///
    /// A function of the path, not of time: with `sigma2 = 0` the force does not depend on how fast the path is gone. From
    /// rest the force rises with the stiffness `f1/(eta*x_e) - f2/x_e` to the peak at the path
    /// `eta*x_e/(1 - eta)*ln(f1/(eta*f2))`, and falls to `f1 - f2`. After a reversal there is a peak, too: the law models
    /// stiction without a dependence on velocity.
    ///
    /// # Validity
    /// `|z1| <= lambda*f1` and `|z2| <= lambda*f2` are invariant. Little damping around `v = 0`. Where `lambda*f1` falls to
    /// 0, within the last micronewton, `z1` and `z2` go to 0.
    ///
    /// Passive for `f2 <= f1` and `eta < 1`, with the stored energy
    ///
    /// ```text
    /// E = (P1*z1^2 + 2*c*z1*z2 + P2*z2^2)/(2*lambda)                                   [J]
    /// c = 2*x_e*eta*(f1 - eta*f2)/(f1*f2*(1 - eta)^2),  P1 = eta*(x_e + c*f2)/f1,  P2 = (c*f1/eta - x_e)/f2
    /// ```
    ///
    /// `P1*f1/eta - c*f2 = c*f1/eta - P2*f2 = x_e`, so that the power of `F` less `dE/dt` is a quadratic form, which is
    /// never negative. Forces outlast the level at which they were built up: what they give back is `E` at the least level
    /// since.
    ///
    /// # Errors
    /// [`ParameterError`] for `f2 > f1`, which would drive the mass.
    ///
    /// # Source
    /// Bliman, Sorine (1995), Easy-to-use realistic dry friction models for automatic control, Proc. 3rd European Control
    /// Conference, Rome, 3788-3794.
    BlimanSorine {
        viscous: Tunable = viscous(30.0);
        fast_force: Tunable = force(5, "f1", 24.6).text("Steady force of the fast Dahl element");
        slow_force: Tunable = force(6, "f2", 16.3).text("Steady force of the slow Dahl element, which is subtracted");
        length_ratio: Tunable = Variable::parameter(7, "eta", units::ONE, 0.5)
            .range(1e-3, 1.0)
            .text("Path on which the fast element builds up, as a fraction of the path of the slow one");
        length: Tunable = length(8, "xe", 1e-5).text("Path on which the slow element builds up");
    }
}

impl FrictionLaw for BlimanSorine {
    type Memory<S: Varying> = ();

    fn check(&self) -> Result<(), ParameterError> {
        let [fast, slow] = [self.fast_force, self.slow_force].map(|force| force.value);
        if slow > fast {
            return Err(ParameterError::new("f2", slow, &format!("it must not exceed f1 = {fast}")));
        }
        Ok(())
    }

    fn states(&self) -> usize {
        2
    }

    fn state_kind(&self) -> StateKind {
        StateKind::Force
    }

    fn state_scale(&self) -> f64 {
        self.fast_force.value.max(1.0)
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], _memory: &(), rates: &mut [S]) -> S {
        let (v, level) = (contact.velocity, contact.level);
        let loaded = level * self.fast_force;
        rates[0] = (v * loaded - v.abs() * z[0]) / (self.length_ratio * self.length) + fading_rate(z[0], loaded);
        rates[1] = (-v * level * self.slow_force - v.abs() * z[1]) / self.length + fading_rate(z[1], loaded);
        z[0] + z[1] + v * self.viscous
    }
}
