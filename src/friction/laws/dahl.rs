//! The Dahl bristle.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::Contact;
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::one_bristle::BristleLaw;
use crate::friction::parts::parameters::{force, stiffness, viscous};
use crate::numbers::{Scalar, Varying, sign};
use crate::parameters;
use crate::variables::{Meaning, Tunable, Variable, units};

/// A bristle of a brittle contact counts as saturated when its force lacks this fraction of the limit.
const SATURATED: f64 = 1e-8;
/// Fraction by which its force must fall below the limit before it deflects again: far more than rounding and the errors of
/// steps, so that a bristle which follows a rising limit stays saturated.
const RELEASED: f64 = 1e-3;

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
    /// For `n < 1` the bristle saturates on a finite path `s`, `|a|^(1-n) = |a_0|^(1-n) - (1-n)*sigma0*s/(lambda*F_c)`
    /// down to `a = 0`, where the slope of its equation is infinite: that is an event. From there it follows its limit by
    /// the chord `a*r^(n-1)` of `|a|^n` up to `a = r`, 1e-3, until the motion turns back or `a` exceeds `r`. Behind a limit
    /// that changes by `F'` in N/m along the path the force is `lambda*F_c*F'/sigma0*r^(1-n)`, where the equation has
    /// `lambda*F_c*(F'/sigma0)^(1/n)`: with `n = 0.5`, the defaults and 1 N/mm, 42 uN where it has 0.2 uN.
    ///
    /// # Validity
    /// `|z| <= lambda*F_c/sigma0` is invariant. Where `lambda*F_c` falls to 0, within the last micronewton, `z` goes to 0.
    ///
    /// # Source
    /// Dahl (1968), A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1.
    Dahl {
        coulomb_force: Tunable = force(1, "Fc", 10.6).meaning(Meaning::CoulombFriction).text("Coulomb friction: force of steady sliding");
        stiffness: Tunable = stiffness(5, "sigma0", 8e6).text("Bristle stiffness at zero deflection");
        exponent: Tunable = Variable::parameter(6, "n", units::ONE, 1.0)
            .range(0.1, 10.0)
            .text("Shape exponent: below 1 brittle, above 1 ductile contact");
        viscous: Tunable = viscous(0.0);
    }
}

/// Whether the bristle deflects or is saturated; only a brittle contact's saturates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// The deflection follows its equation.
    #[default]
    Bending,
    /// The deflection is at its limit, or follows it closely, in a direction, +1 or -1, in which the motion points.
    Saturated(f64),
}

impl BristleLaw for Dahl {
    type Memory<S: Varying> = Mode;

    fn events(&self) -> &'static [Event] {
        if self.is_brittle() { &[Event::Stop, Event::Distance, Event::Rise] } else { &[] }
    }

    /// The slope of a brittle contact is infinite at the limit.
    fn may_differ_by_direction(&self) -> bool {
        true
    }

    fn is_non_stiff(&self) -> bool {
        !self.is_brittle()
    }

    fn scale(&self) -> f64 {
        self.coulomb_force.value.max(1.0) / self.stiffness.value
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, mode: &Mode) -> (S, S) {
        let v = contact.velocity;
        let limit = contact.level * self.coulomb_force;
        let spring = z * self.stiffness;
        if let Mode::Saturated(direction) = *mode
            && self.is_brittle()
        {
            let lacking = (limit - spring * direction) / divisor(limit);
            let share = lacking * (S::constant(RELEASED).pow(self.exponent) / RELEASED);
            return (spring + v * self.viscous, v * share + fading_rate(z, limit));
        }
        let reserve = self.reserve(contact, z);
        // A bristle that lacks nothing has the slope of one that lacks little.
        let side = if reserve.value() < 0.0 { -1.0 } else { 1.0 };
        let rate = v * reserve.abs().pow(self.exponent) * side + fading_rate(z, limit);
        (spring + v * self.viscous, rate)
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, z: S, mode: &Mode, out: &mut Indicators<S>) {
        if !self.is_brittle() {
            return;
        }
        match *mode {
            Mode::Bending => {
                out[Event::Distance] = (self.reserve(contact, z) - SATURATED) * (self.coulomb_force / self.stiffness);
            }
            Mode::Saturated(direction) => {
                let limit = contact.level * self.coulomb_force;
                out[Event::Stop] = contact.velocity * direction;
                out[Event::Rise] = z * direction * self.stiffness - limit * (1.0 - RELEASED);
            }
        }
    }

    fn switch<S: Varying>(&self, _event: Event, contact: &Contact<S>, z: &mut S, mode: &mut Mode) {
        let limit = contact.level * self.coulomb_force / self.stiffness;
        *mode = match *mode {
            Mode::Bending => {
                let direction = sign(contact.velocity.value());
                *z = limit.max(*z * direction) * direction;
                Mode::Saturated(direction)
            }
            Mode::Saturated(_) => Mode::Bending,
        };
    }
}

impl Dahl {
    fn is_brittle(&self) -> bool {
        self.exponent.value < 1.0
    }

    /// `a`: the part of the limit that the bristle lacks in the direction of motion.
    fn reserve<S: Scalar>(&self, contact: &Contact<S>, z: S) -> S {
        let limit = contact.level * self.coulomb_force;
        (limit - z * (self.stiffness * sign(contact.velocity.value()))) / divisor(limit)
    }
}
