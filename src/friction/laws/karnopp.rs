//! Karnopp's zero-velocity band.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw, Stiction};
use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::parameters::{velocity, viscous};
use crate::friction::parts::stick_slip::Mode as StickSlip;
use crate::numbers::{Scalar, Varying, sign};
use crate::parameters;
use crate::variables::{ParameterError, Tunable};

parameters! {
    /// Karnopp friction: the velocity is a state `w` that is reported as 0 inside a band.
    ///
    /// ```text
    /// |w| < DV:  v = 0, dx/dt = 0, F = clamp(F_applied, -lambda*F_s, lambda*F_s)
    /// otherwise: v = w, F = s(v)*sgn(v) + sigma2*v   [N], s the Stribeck curve
    /// ```
    ///
    /// Where the force just outside the band exceeds `lambda*F_s`, an applied force between the two would drive `w`
    /// towards the edge from both sides; `w` then rests on the edge with `F = F_applied` (the solution of Filippov).
    ///
    /// # Validity
    /// An applied force that falls as soon as the mass moves (through a damper, or a spring stiffer than the motion is
    /// fast) drives `w` back into the band at once. Each return within 0.1 ms of leaving the band raises what the edge holds,
    /// from a millionth of the friction force on, so that leaving and returning do not follow each other without end.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    ///
    /// # Source
    /// Karnopp (1985), ASME J. Dynamic Systems, Measurement, and Control 107(1):100-103.
    Karnopp {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        band: Tunable = velocity(5, "DV", 1e-4).text("Half width of the band of velocities that count as rest");
    }
}

/// Mode of `w`: inside or outside the band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// In the band, `w` constant: friction balances the applied force.
    Held,
    /// In the band, `w` moving in a direction under the force beyond `F_s`.
    Crossing(f64),
    /// Outside the band, in a direction.
    Sliding(f64),
}

/// The mode, and the widening of the band that ends a chain of changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<S> {
    mode: Mode,
    /// Time in s at which `w` left the band last.
    left: S,
    /// Force in N that the edge holds beyond the law.
    margin: S,
}

/// Slides shorter than this, in s, count as returning at once.
const AT_ONCE: f64 = 1e-4;

impl FrictionLaw for Karnopp {
    type Memory<S: Varying> = Memory<S>;

    fn stiction(&self) -> Stiction {
        Stiction::Exact
    }

    fn may_differ_by_direction(&self) -> bool {
        true
    }

    fn sliding_direction<S: Varying>(memory: &Memory<S>) -> Option<f64> {
        match memory.mode {
            Mode::Held => None,
            Mode::Crossing(direction) | Mode::Sliding(direction) => Some(direction),
        }
    }

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::BreakAway, Event::Edge, Event::Fall]
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()
    }

    fn is_non_stiff(&self) -> bool {
        self.curve.is_non_stiff()
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Memory<S> {
        Memory { mode: self.mode_at(contact), left: S::of(f64::NEG_INFINITY), margin: S::zero() }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S::Held>, _rates: &mut [S]) -> S {
        match memory.mode {
            Mode::Held => StickSlip::holding_force(contact, contact.level * self.curve.static_force),
            Mode::Crossing(direction) => contact.level * (self.curve.static_force * direction),
            Mode::Sliding(direction) => self.sliding(contact.velocity, direction, contact.level),
        }
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S>, out: &mut Indicators<S>) {
        let w = contact.velocity;
        match (memory.mode, contact.drive) {
            (Mode::Held, Drive::Force) => out[Event::BreakAway] = self.reserve(contact, w, memory.margin),
            (Mode::Held, Drive::Motion) => out[Event::Edge] = -w.abs() + self.band,
            (Mode::Crossing(direction), _) => {
                out[Event::Edge] = -(w * direction) + self.band;
                out[Event::Fall] = contact.applied * direction - contact.level * self.curve.static_force;
            }
            (Mode::Sliding(direction), _) => out[Event::Stop] = w * direction - self.band,
        }
    }

    fn switch<S: Varying>(
        &self,
        event: Event,
        contact: &Contact<S>,
        velocity: &mut S,
        _z: &mut [S],
        memory: &mut Memory<S>,
    ) {
        if contact.drive == Drive::Motion {
            memory.mode = self.mode_at(contact);
            return;
        }
        memory.mode = match memory.mode {
            Mode::Sliding(direction) => {
                *velocity = S::tuned(self.band) * direction;
                memory.margin = self.margin_after(contact, memory);
                self.in_band(contact, *velocity, memory.margin)
            }
            Mode::Crossing(direction) if event == Event::Edge => {
                *velocity = S::tuned(self.band) * direction;
                self.in_band(contact, *velocity, S::zero())
            }
            Mode::Crossing(_) => Mode::Held,
            Mode::Held => self.in_band(contact, *velocity, memory.margin),
        };
        if matches!(memory.mode, Mode::Sliding(_)) {
            memory.left = contact.time;
        }
    }

    fn is_sticking<S: Varying>(memory: &Memory<S>) -> bool {
        !matches!(memory.mode, Mode::Sliding(_))
    }
}

impl Karnopp {
    fn sliding<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        self.curve.at(velocity.abs(), level) * direction + velocity * self.viscous
    }

    /// The sliding force on the edge of the band.
    fn outside<S: Scalar>(&self, contact: &Contact<S>) -> S {
        self.sliding(S::tuned(self.band), 1.0, contact.level)
    }

    fn mode_at<S: Scalar>(&self, contact: &Contact<S>) -> Mode {
        if contact.velocity.value().abs() >= self.band.value {
            Mode::Sliding(sign(contact.velocity.value()))
        } else {
            self.in_band(contact, contact.velocity, S::zero())
        }
    }

    /// The mode at a `w` inside the band or on its edge.
    fn in_band<S: Scalar>(&self, contact: &Contact<S>, w: S, margin: S) -> Mode {
        if contact.drive == Drive::Motion || self.reserve(contact, w, margin).value() >= 0.0 {
            return Mode::Held;
        }
        let direction = sign(contact.applied.value());
        if direction * w.value() >= self.band.value { Mode::Sliding(direction) } else { Mode::Crossing(direction) }
    }

    /// By how much the holding force, on the edge with a margin, exceeds the applied force.
    fn reserve<S: Scalar>(&self, contact: &Contact<S>, w: S, margin: S) -> S {
        let static_force = contact.level * self.curve.static_force;
        let direction = sign(contact.applied.value());
        let outside = self.outside(contact);
        let limit =
            if direction * w.value() >= self.band.value { static_force.max(outside) + margin } else { static_force };
        limit - contact.applied.abs()
    }

    /// The margin of the edge when `w` comes back to it: grows after short slides, and is nothing after long ones.
    fn margin_after<S: Varying>(&self, contact: &Contact<S>, memory: &Memory<S>) -> S {
        let slid = (contact.time - memory.left).value();
        if slid < AT_ONCE {
            (memory.margin * 2.0).max(self.outside(contact) * 1e-6)
        } else if slid < 10.0 * AT_ONCE {
            memory.margin * 0.9
        } else {
            S::zero()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;
    use crate::variables::ParameterSet;

    /// Under Coulomb friction of 10 N alone, after slides of 0.05, 0.5 and 2 ms.
    #[test]
    fn edge_holds_more_after_short_slides_and_forgets_it_in_long_ones() {
        let law = Karnopp::read(&[10.0, 10.0, 0.01, 2.0, 0.0, 1e-4].map(Tunable::still)).unwrap();
        let held = |margin: f64, slid: f64| {
            let memory = Memory { mode: Mode::Sliding(1.0), left: Real::of(3.0), margin: Real::of(margin) };
            let velocity = 1e-4;
            let contact =
                Contact { time: 3.0 + slid, position: 0.0, velocity, applied: 0.0, level: 1.0, drive: Drive::Force };
            law.margin_after(&contact.still(), &memory).value
        };
        assert_eq!([5e-5, 5e-4, 2e-3].map(|slid| held(1.0, slid)), [2.0, 0.9, 0.0]);
        assert_eq!([5e-5, 5e-4, 2e-3].map(|slid| held(0.0, slid)), [1e-6 * 10.0, 0.0, 0.0]);
    }
}
