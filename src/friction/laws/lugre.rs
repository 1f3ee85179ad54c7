//! The LuGre bristle.

use crate::friction::law::Contact;
use crate::friction::lubrication::{Film, Rated};
use crate::friction::parts::curve::{StribeckCurve, faded};
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::one_bristle::BristleLaw;
use crate::friction::parts::parameters::{damping, stiffness, velocity, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{Field, Notice, ParameterError, Tunable};

parameters! {
    /// LuGre friction: one state, the mean bristle deflection `z` in m.
    ///
    /// ```text
    /// dz/dt = v - sigma0*|v|/s(v)*z                                [m/s]
    /// F     = sigma0*z + sigma1*exp(-(v/v_d)^2)*dz/dt + sigma2*v   [N], s the Stribeck curve
    /// ```
    ///
    /// `v_d = 0` stands for constant damping, no decay: the law as first published. The decay is by Olsson et al.
    ///
    /// At constant `v != 0`, `F -> s(v)*sgn(v) + sigma2*v`. Drifts under oscillating loads below `F_s`.
    ///
    /// # Validity
    /// `|z| <= lambda*F_s/sigma0` is invariant. Passive if `sigma1*v_d <= 9.3*lambda*F_c`, with the defaults by a factor of 8:
    /// the energy `sigma0*z^2/2` never grows by more than the work of `F` where `sigma1*exp(-(v/v_d)^2)*|v| <= 4*s(v)`, whose
    /// left side is at most `sigma1*v_d/sqrt(2*e)`. With constant damping (`v_d = 0`, or a large one) only if
    /// `sigma2 > sigma1*(F_s - F_c)/F_c`; beyond, the damping adds to the friction force while the bristle bends, which then
    /// exceeds `F_s` by far and breaks away later the faster the load grows. Where `s` falls to 0, within the last
    /// micronewton, `z` goes to 0.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    ///
    /// # Source
    /// Canudas de Wit, Olsson, Astrom, Lischinsky (1995), IEEE Trans. Automatic Control 40(3):419-425. Here `s` is in N.
    /// Decay: Olsson, Astrom, Canudas de Wit, Gafvert, Lischinsky (1998), European J. Control 4(3):176-195.
    LuGre {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        stiffness: Tunable = stiffness(5, "sigma0", STIFFNESS).text("Bristle stiffness");
        damping: Tunable = damping(6, "sigma1", DAMPING).text("Bristle damping at zero velocity");
        damping_velocity: Decay = velocity(7, "vd", DAMPING_VELOCITY).range(0.0, 1e6).plausible(1e-7, 1e6)
            .text("Velocity above which the bristle damping has decayed; 0: never, as in the published law");
    }
}

/// Defaults of what goes together: so stiff a bristle with constant damping would peak at four times the static friction.
pub(super) const STIFFNESS: f64 = 1e6;
pub(super) const DAMPING: f64 = 1000.0;
pub(super) const DAMPING_VELOCITY: f64 = 0.01;

/// A velocity in m/s with which something decays; 0 stands for an infinite one, with which nothing does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay(Tunable);

impl Decay {
    /// Share of a damping that remains at a velocity in m/s: `exp(-(v/v_d)^2)`.
    pub(super) fn left<S: Scalar>(self, velocity: S) -> S {
        faded((velocity / self.0).powf(2.0))
    }

    /// Warning of a stiffness and a damping that are not those for which this velocity is the default.
    pub(super) fn notice(self, variable: &'static str, [stiffness, damping]: [Tunable; 2]) -> Option<Notice> {
        // Both changed in proportion, as for another load, are allowed: contacts of other models have such defaults.
        let [ratio, default] = [stiffness.value / damping.value, STIFFNESS / DAMPING];
        let is_changed = ratio.is_finite() && (ratio / default - 1.0).abs() > 1e-9;
        let remark = "the default: the bristle damping sigma1 decays above this velocity (Olsson et al. 1998); vd = 0 is the law with constant damping (Canudas de Wit et al. 1995), which most published values of sigma0 and sigma1 are for";
        let notice = Notice { variable, value: DAMPING_VELOCITY, remark };
        (is_changed && self.0.value == DAMPING_VELOCITY).then_some(notice)
    }
}

impl Field for Decay {
    type Value = Self;
    const LEN: usize = 1;
    const IS_TUNABLE: bool = true;

    fn read(values: &[Tunable]) -> Option<Self> {
        let velocity = values[0];
        Some(Self(if velocity.value == 0.0 { Tunable::still(f64::INFINITY) } else { velocity }))
    }
}

impl BristleLaw for LuGre {
    type Memory<S: Varying> = ();

    const RELAXES_BY_SECANT: bool = true;

    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()
    }

    fn may_differ_by_direction(&self) -> bool {
        true
    }

    fn is_lubricated(&self) -> bool {
        true
    }

    fn is_non_stiff(&self) -> bool {
        self.curve.is_non_stiff()
    }

    fn notice(&self) -> Option<Notice> {
        self.damping_velocity.notice("friction.lugre.vd", [self.stiffness, self.damping])
    }

    fn scale(&self) -> f64 {
        self.curve.static_force.value.max(1.0) / self.stiffness.value
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, memory: &()) -> (S, S) {
        self.lubricated_force(contact, Rated, z, memory)
    }

    #[inline(always)]
    fn lubricated_force<S: Scalar>(&self, contact: &Contact<S>, film: impl Film<S>, z: S, _memory: &()) -> (S, S) {
        let v = contact.velocity;
        let limit = self.curve.at(film.on_curve(v.abs()), contact.level);
        let rate = (v * limit - v.abs() * z * self.stiffness) / divisor(limit) + fading_rate(z, limit);
        let decay = self.damping_velocity.left(v);
        (z * self.stiffness + decay * rate * self.damping + film.viscous(v * self.viscous), rate)
    }
}
