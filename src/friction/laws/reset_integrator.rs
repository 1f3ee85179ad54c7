//! The reset integrator.

use crate::friction::event::{Event, Indicators};
use crate::friction::law::Contact;
use crate::friction::parts::bounded::Mode;
use crate::friction::parts::one_bristle::BristleLaw;
use crate::friction::parts::parameters::{damping, length, stiffness, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{Tunable, Variable, units};

parameters! {
    /// Reset-integrator friction: one state, the strain `z` in m of a bond that yields at `lambda*z0`.
    ///
    /// ```text
    /// z     = lambda*z0    while v > 0, once there; -lambda*z0 while v < 0   [m]
    /// dz/dt = v            otherwise                                         [m/s]
    /// F     = (1 + a(z))*sigma0*z + sigma1*dz/dt + sigma2*v                  [N], dz/dt = 0 at the limit
    /// a(z)  = a for |z| < lambda*z0, otherwise 0
    /// ```
    ///
    /// The bond holds up to `(1 + a)*sigma0*lambda*z0` and carries `sigma0*lambda*z0` while sliding. Without drift; when
    /// the motion reverses the force jumps to the bond's.
    ///
    /// # Validity
    /// None of the parameters is a force: the load factor `lambda` scales the limit of the strain, not the stiffness. At
    /// constant level `|z| <= lambda*z0` is invariant; a bond stretched beyond a limit that falls yields as soon as the
    /// motion stretches it further. While it yields, the state stays where yielding began.
    ///
    /// # Source
    /// Haessig, Friedland (1991), ASME J. Dynamic Systems, Measurement, and Control 113(3):354-362.
    ResetIntegrator {
        viscous: Tunable = viscous(30.0);
        stiffness: Tunable = stiffness(5, "sigma0", 1e6).text("Stiffness of the bond while sliding");
        yield_strain: Tunable = length(6, "z0", 8.3e-6).text("Strain at which the bond yields at load factor 1");
        stiction_gain: Tunable = Variable::parameter(7, "a", units::ONE, 0.325)
            .range(0.0, 100.0)
            .text("Excess of the break-away force over the sliding force, relative to the latter");
        damping: Tunable = damping(8, "sigma1", 1000.0).text("Damping while the bond strains");
    }
}

impl BristleLaw for ResetIntegrator {
    type Memory<S: Varying> = Mode;

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::Distance]
    }

    fn scale(&self) -> f64 {
        self.yield_strain.value
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, mode: &Mode) -> (S, S) {
        let rate = mode.rate(contact.velocity);
        let stiffness = match mode {
            Mode::Following => (self.stiction_gain + 1.0) * self.stiffness,
            Mode::Limited(_) => self.stiffness,
        };
        let strain = mode.deflection(z, self.limit(contact.level));
        (strain * stiffness + rate * self.damping + contact.velocity * self.viscous, rate)
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, z: S, mode: &Mode, out: &mut Indicators<S>) {
        mode.indicate(contact.velocity, z, self.limit(contact.level), out);
    }

    fn switch<S: Varying>(&self, _event: Event, contact: &Contact<S>, z: &mut S, mode: &mut Mode) {
        *mode = mode.switched(z, self.limit(contact.level));
    }
}

impl ResetIntegrator {
    /// Strain in m at which the bond yields at a load factor.
    fn limit<S: Scalar>(&self, level: S) -> S {
        level * self.yield_strain
    }
}
