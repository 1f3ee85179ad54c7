//! Stiction as a bounded displacement, blended into kinetic friction by the speed.

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::bounded::Mode;
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::parameters::{
    check_levels, coulomb_force, damping, length, static_force, velocity, viscous,
};
use crate::friction::parts::ramp::{check_velocities, cubic};
use crate::numbers::{Scalar, sign};
use crate::parameters;
use crate::variables::ParameterError;

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
        static_force: f64 = static_force(11.0);
        coulomb_force: f64 = coulomb_force(8.3);
        static_velocity: f64 = velocity(2, "vs", 1e-3).text("Speed up to which friction is static");
        viscous: f64 = viscous(30.0);
        kinetic_velocity: f64 = velocity(5, "vd", 1e-2).text("Speed above which friction is Coulomb friction");
        displacement: f64 = length(6, "Delta", 1e-5).text("Largest stiction displacement");
        damping: f64 = damping(7, "sigma1", 1000.0).text("Damping of the stiction displacement");
    }
}

impl FrictionLaw for StickSlipCreep {
    type Memory = Mode;
    type Parameters = Self;

    const EVENTS: &'static [Event] = &[Event::Stop, Event::Distance];

    fn new(parameters: Self) -> Result<Self, ParameterError> {
        check_levels(parameters.static_force, "Fc", parameters.coulomb_force)?;
        check_velocities(parameters.static_velocity, parameters.kinetic_velocity)?;
        Ok(parameters)
    }

    fn states(&self) -> usize {
        1
    }

    fn state_scale(&self) -> f64 {
        self.displacement
    }

    fn start(&self, _contact: &Contact<f64>, _z: &mut [f64]) -> Mode {
        Mode::Following
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], mode: &Mode, rates: &mut [S]) -> S {
        let (v, limit) = (contact.velocity, contact.level * self.static_force);
        rates[0] = mode.rate(v * (limit / divisor(limit)));
        if *mode == Mode::Following {
            rates[0] += fading_rate(z[0], limit);
        }
        let displacement = mode.deflection(z[0], S::constant(self.displacement));
        let stiction = limit * displacement / self.displacement + rates[0] * self.damping;
        let kinetic = contact.level * (self.coulomb_force * sign(v.value()));
        let share = self.stiction_share(v.abs());
        share * stiction + (-share + 1.0) * kinetic + v * self.viscous
    }

    fn indicators(&self, contact: &Contact<f64>, z: &[f64], mode: &Mode, out: &mut Indicators) {
        mode.indicate(contact.velocity, z[0], self.displacement, out);
    }

    fn switch(&self, _event: Event, _contact: &Contact<f64>, _v: &mut f64, z: &mut [f64], mode: &mut Mode) {
        *mode = mode.switched(&mut z[0], self.displacement);
    }
}

impl StickSlipCreep {
    /// The share `beta` of stiction at a speed.
    fn stiction_share<S: Scalar>(&self, speed: S) -> S {
        let share = (-speed + self.kinetic_velocity) / (self.kinetic_velocity - self.static_velocity);
        cubic(share.clamp(S::zero(), S::constant(1.0)))
    }
}
