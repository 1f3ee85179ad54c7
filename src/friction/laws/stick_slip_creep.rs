//! Stiction as a bounded displacement, blended into kinetic friction by the speed.

use crate::friction::event::{Event, Indicators};
use crate::friction::law::Contact;
use crate::friction::parts::bounded::Mode;
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::one_bristle::BristleLaw;
use crate::friction::parts::parameters::{damping, length};
use crate::friction::parts::ramp::{Ramp, cubic};
use crate::numbers::{Scalar, Varying, sign};
use crate::parameters;
use crate::variables::{ParameterError, Tunable};

parameters! {
    /// Stick-slip-creep friction: one state, the stiction displacement `d` in m.
    ///
    /// ```text
    /// F     = beta*(lambda*F_s*d/Delta + sigma1*dd/dt) + (1 - beta)*lambda*F_c*sgn(v) + sigma2*v   [N]
    /// dd/dt = 0   at d = Delta while v > 0, and at d = -Delta while v < 0
    ///       = v   otherwise                                                                        [m/s]
    /// beta  = S((v_d - |v|)/(v_d - v_s)), 0 for |v| > v_d and 1 for |v| < v_s;  S(q) = 3*q^2 - 2*q^3
    /// ```
    ///
    /// Loads below `F_s` are held by a spring of stiffness `F_s/Delta`, without drift; above it friction stays at `F_s`
    /// up to the speed `v_s` and falls to `F_c` at `v_d`.
    ///
    /// # Validity
    /// `|d| <= Delta` is invariant. Where `lambda*F_s` falls to 0, within the last micronewton, `d` goes to 0.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s` or `v_d <= v_s`.
    ///
    /// # Source
    /// After the joint friction of MSC Adams and RecurDyn, which depends on speed and stiction displacement.
    StickSlipCreep {
        ramp: Ramp = Ramp::variables("Speed up to which friction is static");
        displacement: Tunable = length(6, "Delta", 1e-5).text("Largest stiction displacement");
        damping: Tunable = damping(7, "sigma1", 1000.0).text("Damping of the stiction displacement");
    }
}

impl BristleLaw for StickSlipCreep {
    type Memory<S: Varying> = Mode;

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::Distance]
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.ramp.check()
    }

    fn scale(&self) -> f64 {
        self.displacement.value
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, mode: &Mode) -> (S, S) {
        let (v, limit) = (contact.velocity, contact.level * self.ramp.static_force);
        let mut rate = mode.rate(v * (limit / divisor(limit)));
        if *mode == Mode::Following {
            rate += fading_rate(z, limit);
        }
        let displacement = mode.deflection(z, S::tuned(self.displacement));
        let stiction = limit * displacement / self.displacement + rate * self.damping;
        let kinetic = contact.level * (self.ramp.coulomb_force * sign(v.value()));
        let share = self.stiction_share(v.abs());
        (share * stiction + (-share + 1.0) * kinetic + v * self.ramp.viscous, rate)
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, z: S, mode: &Mode, out: &mut Indicators<S>) {
        mode.indicate(contact.velocity, z, S::tuned(self.displacement), out);
    }

    fn switch<S: Varying>(&self, _event: Event, _contact: &Contact<S>, z: &mut S, mode: &mut Mode) {
        *mode = mode.switched(z, S::tuned(self.displacement));
    }
}

impl StickSlipCreep {
    /// The share `beta` of stiction at a speed.
    fn stiction_share<S: Scalar>(&self, speed: S) -> S {
        let Ramp { static_velocity, kinetic_velocity, .. } = self.ramp;
        let share = (-speed + kinetic_velocity) / (kinetic_velocity - static_velocity);
        cubic(share.clamp(S::zero(), S::constant(1.0)))
    }
}
