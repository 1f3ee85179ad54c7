//! Stiction as a spring and damper anchored where the mass stuck: the two modes of such laws.
//!
//! While sticking the spring-damper carries the mass, until its force exceeds the break-away force. Sliding ends when
//! the velocity crosses 0; there the spring is anchored such that the force stays as it is. While a prescribed motion rests or
//! unloads the spring, the spring yields to a break-away force that falls.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive};
use crate::numbers::{Scalar, Varying, sign};
use crate::variables::{Field, Tunable};

/// A spring that is anchored at its limit is loaded by this fraction less, so that rounding does not break it at once.
const BELOW_LIMIT: f64 = 1e-12;

/// Sticking on an anchor or sliding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode<S> {
    /// Held by the spring-damper.
    Sticking {
        /// Position in m where the mass stuck.
        place: S,
        /// Load in N that the spring took over there: exactly that, however stiff the spring.
        load: S,
    },
    /// Sliding.
    Sliding {
        /// Direction of sliding, +1 or -1.
        direction: f64,
    },
}

/// Friction magnitudes in N that decide on the mode.
#[derive(Clone, Copy, Debug)]
pub struct Limits<S> {
    /// Largest force while sticking.
    pub break_away: S,
    /// Sliding force at zero velocity.
    pub sliding: S,
}

/// The spring-damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Stiffness in N/m.
    pub stiffness: Tunable,
    /// Damping coefficient in N s/m.
    pub damping: Tunable,
}

/// Stiffness and damping, two parameters of a law.
impl Field for Spring {
    type Value = Self;
    const LEN: usize = 2;
    const IS_TUNABLE: bool = true;

    fn read(values: &[Tunable]) -> Option<Self> {
        let [stiffness, damping] = <[Tunable; 2]>::read(values)?;
        Some(Self { stiffness, damping })
    }
}

impl Spring {
    /// The mode of a mass that was not in contact before; where there is no stiction, it slides.
    pub fn start<S: Varying>(contact: &Contact<S>, limits: Limits<S>) -> Mode<S> {
        if limits.break_away.value() > 0.0 {
            Mode::Sticking { place: contact.position, load: S::zero() }
        } else {
            Mode::Sliding { direction: direction(contact, 1.0) }
        }
    }

    /// Force in N while sticking.
    pub fn force<S: Scalar>(&self, contact: &Contact<S>, place: S::Held, load: S::Held) -> S {
        (contact.position - S::held(place)) * self.stiffness + contact.velocity * self.damping + S::held(load)
    }

    /// Force in N of a contact that sticks. A prescribed motion that rests, or unloads the spring, cannot break it away: there the
    /// spring yields to a break-away force that falls below its own.
    pub fn holding<S: Scalar>(
        &self,
        contact: &Contact<S>,
        place: S::Held,
        load: S::Held,
        break_away: impl FnOnce() -> S,
    ) -> S {
        let force = self.force(contact, place, load);
        if contact.drive == Drive::Force || force.value() * contact.velocity.value() > 0.0 {
            return force;
        }
        let most = break_away().max(S::zero());
        force.clamp(-most, most)
    }

    /// The mode behind a step in which the spring has yielded, if it has: it keeps the force that is left.
    pub fn yielded<S: Varying>(&self, mode: Mode<S>, contact: &Contact<S>, limits: Limits<S>) -> Option<Mode<S>> {
        let Mode::Sticking { place, load } = mode else { return None };
        let force = self.force(contact, place, load);
        let held = self.holding(contact, place, load, || limits.break_away);
        let has_yielded = held.value() != force.value();
        has_yielded.then(|| Mode::Sticking { place, load: load + held * (1.0 - BELOW_LIMIT) - force })
    }

    /// Sets the event indicator: the reserve until break-away, or the speed.
    pub fn indicate<S: Varying>(
        &self,
        mode: Mode<S>,
        contact: &Contact<S>,
        limits: Limits<S>,
        out: &mut Indicators<S>,
    ) {
        let (has_stiction, due) = (limits.break_away.value() > 0.0, S::of(-f64::MIN_POSITIVE));
        match mode {
            Mode::Sticking { place, load } if has_stiction => {
                // Where it yields there is no event: a limit that falls on and on would end one mode after the other.
                let force = self.holding(contact, place, load, || limits.break_away);
                out[Event::BreakAway] = limits.break_away - force.abs();
            }
            Mode::Sticking { .. } => out[Event::BreakAway] = due,
            Mode::Sliding { .. } if is_at_rest(contact) && has_stiction => out[Event::Stop] = due,
            Mode::Sliding { direction } => out[Event::Stop] = contact.velocity * direction,
        }
    }

    /// The mode after an event of the present one.
    pub fn switched<S: Varying>(&self, mode: Mode<S>, contact: &Contact<S>, limits: Limits<S>) -> Mode<S> {
        if limits.break_away.value() <= 0.0 {
            let previous = if let Mode::Sliding { direction } = mode { direction } else { 1.0 };
            return Mode::Sliding { direction: direction(contact, -previous) };
        }
        match mode {
            // At rest the break-away force fell below the present one: the spring yields, and the motion will tell.
            Mode::Sticking { place, load } if contact.velocity.value() == 0.0 => {
                let direction = sign(self.force(contact, place, load).value());
                Self::anchored(contact, direction, limits.break_away, limits)
            }
            Mode::Sticking { .. } => Mode::Sliding { direction: sign(contact.velocity.value()) },
            Mode::Sliding { direction } => Self::anchored(contact, direction, limits.sliding, limits),
        }
    }

    /// Sticking with a force in a direction.
    fn anchored<S: Varying>(contact: &Contact<S>, direction: f64, force: S, limits: Limits<S>) -> Mode<S> {
        let load = force.min(limits.break_away * (1.0 - BELOW_LIMIT)) * direction;
        Mode::Sticking { place: contact.position, load }
    }
}

/// Whether a prescribed motion rests, where sliding ends even though the velocity does not cross 0.
fn is_at_rest<S: Scalar>(contact: &Contact<S>) -> bool {
    contact.drive == Drive::Motion && contact.velocity.value() == 0.0
}

/// Direction of motion; at rest of the applied force; without one the given direction.
fn direction<S: Scalar>(contact: &Contact<S>, otherwise: f64) -> f64 {
    [contact.velocity, contact.applied]
        .map(|it| sign(it.value()))
        .into_iter()
        .find(|sign| *sign != 0.0)
        .unwrap_or(otherwise)
}
