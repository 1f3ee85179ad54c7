//! The LuGre bristle on a lubricant film.

use super::lugre::{DAMPING, DAMPING_VELOCITY, Decay, STIFFNESS};
use crate::friction::law::{Contact, FrictionLaw, LawState};
use crate::friction::lubrication::{Film, Rated};
use crate::friction::parts::curve::{StribeckCurve, faded};
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::parameters::{damping, stiffness, velocity, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{Notice, ParameterError, Tunable, Variable, units};

parameters! {
    /// Revised LuGre friction: the bristle deflection `z` in m, and the thickness `h` of a lubricant film, without unit.
    ///
    /// ```text
    /// dz/dt = v - sigma0*|v|/g(v, h)*z                                                [m/s]
    /// g     = lambda*(F_c + ((1 - h)*F_s - F_c)*exp(-(|v|/v_s)^delta))                [N]
    /// dh/dt = (h_ss(v) - h)/tau                                                       [1/s]
    /// h_ss  = (1 - F_c/F_s)*m*min(|v|/v_b, 1)^(2/3)
    /// tau   = tau_hp                                    h <= h_ss: the film grows
    /// 1/tau = 1/tau_h0 + (1/tau_hn - 1/tau_h0)*m        h > h_ss: it is squeezed out
    /// m     = 1 - exp(-(v/v_0)^2)
    /// F     = sigma0*z + sigma1*exp(-(v/v_d)^2)*dz/dt + sigma2*v                      [N]
    /// ```
    ///
    /// At constant `v != 0`, `F -> g(v, h_ss(v))*sgn(v) + sigma2*v`. The film lags behind the velocity: friction is higher while the
    /// speed rises than while it falls, most where the period fits the time constants of the film. It outlasts a stop: contacts break away at
    /// `(1 - h)*F_s`, and at `F_s` after a rest much longer than `tau_h0`, as at the start of a run.
    ///
    /// As published, a contact rests at `v = 0` alone, which is the limit `v_0 -> 0`. A mass that bristles hold is never at rest
    /// exactly, so that speeds below `v_0` count as rest here. `v_d = 0` stands for constant damping, as published;
    /// [`LuGre`](super::lugre::LuGre) has the same decay.
    ///
    /// Left out: the fluid inertia `T` of the published `sigma2*(v + T*dv/dt)`, since no law is given an acceleration. A mass
    /// larger by `sigma2*T` moves the same way; the friction force then lacks `sigma2*T*dv/dt`.
    ///
    /// # Validity
    /// `|z| <= lambda*F_s/sigma0` and `0 <= h <= 1 - F_c/F_s` are invariant, so that `lambda*F_c <= g <= lambda*F_s`: passive where
    /// [`LuGre`](super::lugre::LuGre) is. Drifts under oscillating loads below `F_s`. Where `g` falls to 0, within the last
    /// micronewton, `z` goes to 0.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    ///
    /// # Source
    /// Tran, Yanada (2013), Dynamic friction behaviors of pneumatic cylinders, Intelligent Control and Automation 4(2); for hydraulic
    /// cylinders Tran, Hafizah, Yanada (2012), Modeling of dynamic friction behaviors of hydraulic cylinders. The new
    /// modified LuGre model of 2013 is the revised one of Tran, Nguyen, Tran (2019), Effects of friction models on simulation of
    /// pneumatic cylinder, Mechanical Sciences 10:517. They state `h_ss = K_f*|v|^(2/3)`. Here `K_f` is such that the film at `v_b`
    /// leaves `F_c` of `F_s`, and grows no further.
    RevisedLuGre {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        stiffness: Tunable = stiffness(5, "sigma0", STIFFNESS).text("Bristle stiffness");
        damping: Tunable = damping(6, "sigma1", DAMPING).text("Bristle damping at zero velocity");
        film_velocity: Tunable = velocity(7, "vb", 0.05).text("Speed from which on the lubricant film grows no more");
        growing: Tunable = film_time(8, "tauHp", 0.25).text("Time constant of the lubricant film while it grows");
        shrinking: Tunable = film_time(9, "tauHn", 1.0).text("Time constant of the lubricant film while it shrinks in motion");
        dwelling: Tunable = film_time(10, "tauH0", 40.0).text("Time constant of the lubricant film at rest");
        rest_velocity: Tunable = velocity(11, "v0", 1e-4).text("Speed below which the lubricant film counts as at rest");
        damping_velocity: Decay = velocity(12, "vd", DAMPING_VELOCITY).range(0.0, 1e6).plausible(1e-7, 1e6)
            .text("Velocity above which the bristle damping has decayed; 0: never, as in the published law");
    }
}

fn film_time(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::SECOND, default).range(1e-6, 1e6).plausible(1e-6, 200.0)
}

impl FrictionLaw for RevisedLuGre {
    type Memory<S: Varying> = ();

    const STATES: &'static [LawState<Self>] = &[
        LawState::new("deflection", units::METRE, |law: &Self| {
            law.curve.static_force.value.max(1.0) / law.stiffness.value
        })
        .text("Mean deflection of the bristles"),
        LawState::new("film", units::ONE, |_| 0.1)
            .range(-1.0, 1.0)
            .alone()
            .text("Thickness of the lubricant film, without unit"),
    ];

    fn may_differ_by_direction(&self) -> bool {
        true
    }

    fn is_lubricated(&self) -> bool {
        true
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()
    }

    fn notice(&self) -> Option<Notice> {
        self.damping_velocity.notice("friction.revisedLuGre.vd", [self.stiffness, self.damping])
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &(), rates: &mut [S]) -> S {
        self.lubricated_force(contact, Rated, z, memory, rates)
    }

    #[inline(always)]
    fn lubricated_force<S: Scalar>(
        &self,
        contact: &Contact<S>,
        lubrication: impl Film<S>,
        z: &[S],
        _memory: &(),
        rates: &mut [S],
    ) -> S {
        let (v, [deflection, film]) = (contact.velocity, [z[0], z[1]]);
        let (speed, StribeckCurve { static_force, coulomb_force, .. }) = (v.abs(), self.curve);
        let excess = (-film + 1.0) * static_force - coulomb_force;
        let limit = contact.level * (self.curve.decay(lubrication.on_curve(speed)) * excess + coulomb_force);
        let bending =
            (v * limit - speed * deflection * self.stiffness) / divisor(limit) + fading_rate(deflection, limit);
        rates[0] = bending;
        rates[1] = self.film_rate(v, film);
        let damping = self.damping_velocity.left(v) * self.damping;
        deflection * self.stiffness + bending * damping + lubrication.viscous(v * self.viscous)
    }
}

impl RevisedLuGre {
    /// Rate of the thickness of the film in 1/s, at a velocity in m/s.
    fn film_rate<S: Scalar>(&self, velocity: S, film: S) -> S {
        let rest = faded((velocity / self.rest_velocity).powf(2.0));
        let missing = (-rest + 1.0) * self.thickness(velocity.abs()) - film;
        if missing.value() >= 0.0 {
            return missing / self.growing;
        }
        let [at_rest, sliding] = [1.0 / self.dwelling, 1.0 / self.shrinking];
        missing * (rest * (at_rest - sliding) + sliding)
    }

    /// Thickness of the film at a constant speed in m/s that does not count as rest.
    fn thickness<S: Scalar>(&self, speed: S) -> S {
        let [static_force, coulomb_force] = [self.curve.static_force, self.curve.coulomb_force].map(S::tuned);
        if static_force.value() == 0.0 {
            return S::zero();
        }
        let share = (speed / self.film_velocity).min(S::constant(1.0));
        share.powf(2.0 / 3.0) * ((static_force - coulomb_force) / static_force)
    }
}
