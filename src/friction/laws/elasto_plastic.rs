//! The elasto-plastic bristle.

use std::f64::consts::PI;

use crate::friction::law::Contact;
use crate::friction::lubrication::{Film, Rated};
use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::one_bristle::BristleLaw;
use crate::friction::parts::parameters::{damping, stiffness, viscous};
use crate::numbers::{Scalar, Varying, sign};
use crate::parameters;
use crate::variables::{ParameterError, Tunable, Variable, units};

parameters! {
    /// Elasto-plastic friction: one state, the bristle deflection `z` in m, which is purely elastic at first.
    ///
    /// ```text
    /// dz/dt = v*(1 - alpha(z, v)*sgn(v)*z/z_max),  z_max = s(v)/sigma0               [m/s]
    /// alpha = 0                                                                      |z| <= z_ba or sgn(z) != sgn(v)
    ///       = 1/2*sin(pi*(|z| - (z_max + z_ba)/2)/(z_max - z_ba)) + 1/2              in between
    ///       = 1                                                                      |z| >= z_max
    /// z_ba  = zbaRatio*lambda*F_c/sigma0                                             [m]
    /// F     = sigma0*z + F_d + sigma2*v,  F_d = sigma1*dz/dt                         [N], s the Stribeck curve
    /// |F_d| <= (sigma0*z)^2/s(v)                                                     |z| > z_max and sgn(z) = sgn(v)
    /// ```
    ///
    /// At constant `v != 0`, `F -> s(v)*sgn(v) + sigma2*v`. Oscillating loads below `zbaRatio*F_c` cause no drift.
    ///
    /// # Validity
    /// `|z| <= lambda*F_s/sigma0` is invariant at a constant load factor. Passive at any level, however it varies, with the
    /// stored energy `sigma0*z^2/2`: a bristle that is bent beyond what `s` lets it bear goes back while the mass goes on, and
    /// the damping of that would push the mass; the bound leaves of it what the yielding takes up. The
    /// default cylinder does not reach it. Where `s` falls to 0, within the last micronewton, `z` goes to 0.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    ///
    /// # Source
    /// Dupont, Hayward, Armstrong, Altpeter (2002), IEEE Trans. Automatic Control 47(5):787-792.
    ElastoPlastic {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        stiffness: Tunable = stiffness(5, "sigma0", 1e6).text("Bristle stiffness");
        damping: Tunable = damping(6, "sigma1", 1000.0).text("Bristle damping");
        elastic_ratio: Tunable = Variable::parameter(7, "zbaRatio", units::ONE, 0.7)
            .range(0.0, 0.99)
            .text("Force up to which the bristle is purely elastic, as a fraction of the Coulomb friction");
    }
}

impl BristleLaw for ElastoPlastic {
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
        let elastic_limit = contact.level * (self.elastic_ratio * self.curve.coulomb_force);
        let spring = z * self.stiffness;
        let along = spring * sign(v.value());
        let plastic = plastic_share(along, elastic_limit, limit);
        // The quotient is exactly 1 unless the limit fades away: elastic deflections are free of rounding.
        let rate = v * (limit / divisor(limit)) - v.abs() * plastic * spring / divisor(limit);
        let mut damped = rate * self.damping;
        if along.value() > limit.value() {
            // The returning part pushes against `sgn(v)`.
            let most = along * along / divisor(limit);
            damped = if v.value() > 0.0 { damped.max(-most) } else { damped.min(most) };
        }
        (spring + damped + film.viscous(v * self.viscous), rate + fading_rate(z, limit))
    }
}

/// The share `alpha` of the motion that is plastic, from the spring force in the direction of motion and its limits.
fn plastic_share<S: Scalar>(spring: S, elastic_limit: S, limit: S) -> S {
    if limit.value() < divisor(limit).value() {
        // Where the limit fades away there is no elastic range left that a solver could resolve.
        S::constant(1.0)
    } else if spring.value() <= elastic_limit.value() || spring.value() <= 0.0 {
        S::zero()
    } else if spring.value() >= limit.value() {
        S::constant(1.0)
    } else {
        // Half of 1 + sin(angle), by the sine of half the angle to the nearer limit: within pi/4 it is cheap.
        let risen = |way: S| {
            let sine = (way * (0.5 * PI) / (limit - elastic_limit)).sin();
            sine * sine
        };
        let (begun, left) = (spring - elastic_limit, limit - spring);
        if begun.value() < left.value() { risen(begun) } else { -risen(left) + 1.0 }
    }
}
