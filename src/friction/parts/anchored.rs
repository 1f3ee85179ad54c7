//! Stiction as a spring and damper anchored where the mass stuck: the two modes of such laws.
//!
//! While sticking the spring-damper carries the mass, until its force exceeds the break-away force. Sliding ends when
//! the velocity crosses 0; there the spring is anchored such that the force stays as it is.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive};
use crate::numbers::{Real, Scalar, sign};
use crate::variables::{Field, Tunable};

/// A spring that is anchored at its limit is loaded by this fraction less, so that rounding does not break it at once.
const BELOW_LIMIT: f64 = 1e-12;

/// Sticking on an anchor or sliding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// Held by the spring-damper.
    Sticking {
        /// Position in m where the mass stuck.
        place: f64,
        /// Load in N that the spring took over there: exactly that, however stiff the spring.
        load: f64,
    },
    /// Sliding.
    Sliding {
        /// Direction of sliding, +1 or -1.
        #[serde(with = "crate::system::side")]
        direction: f64,
    },
}

/// Friction magnitudes in N that decide on the mode.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest force while sticking.
    pub break_away: f64,
    /// Sliding force at zero velocity.
    pub sliding: f64,
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
    const LEN: usize = 2;
    const IS_TUNABLE: bool = true;

    fn read(values: &[Tunable]) -> Option<Self> {
        let [stiffness, damping] = Field::read(values)?;
        Some(Self { stiffness, damping })
    }
}

impl Spring {
    /// The mode of a mass that was not in contact before; where there is no stiction, it slides.
    pub fn start(contact: &Contact<f64>, limits: Limits) -> Mode {
        if limits.break_away > 0.0 {
            Mode::Sticking { place: contact.position, load: 0.0 }
        } else {
            Mode::Sliding { direction: direction(contact, 1.0) }
        }
    }

    /// Force in N while sticking.
    pub fn force<S: Scalar>(&self, contact: &Contact<S>, place: f64, load: f64) -> S {
        (contact.position - place) * self.stiffness + contact.velocity * self.damping + load
    }

    fn load(&self, contact: &Contact<f64>, place: f64, load: f64) -> f64 {
        self.force(&contact.held::<Real>(), place, load).value
    }

    /// Sets the event indicator: the reserve until break-away, or the speed.
    pub fn indicate(&self, mode: Mode, contact: &Contact<f64>, limits: Limits, out: &mut Indicators) {
        let has_stiction = limits.break_away > 0.0;
        match mode {
            Mode::Sticking { place, load } if has_stiction => {
                out[Event::BreakAway] = limits.break_away - self.load(contact, place, load).abs();
            }
            Mode::Sticking { .. } => out[Event::BreakAway] = -f64::MIN_POSITIVE,
            Mode::Sliding { .. } if is_at_rest(contact) && has_stiction => out[Event::Stop] = -f64::MIN_POSITIVE,
            Mode::Sliding { direction } => out[Event::Stop] = direction * contact.velocity,
        }
    }

    /// The mode after an event of the present one.
    pub fn switched(&self, mode: Mode, contact: &Contact<f64>, limits: Limits) -> Mode {
        if limits.break_away <= 0.0 {
            let previous = if let Mode::Sliding { direction } = mode { direction } else { 1.0 };
            return Mode::Sliding { direction: direction(contact, -previous) };
        }
        match mode {
            // At rest the break-away force fell below the present one: the spring yields, and the motion will tell.
            Mode::Sticking { place, load } if contact.velocity == 0.0 => {
                Self::anchored(contact, sign(self.load(contact, place, load)), limits.break_away, limits)
            }
            Mode::Sticking { .. } => Mode::Sliding { direction: sign(contact.velocity) },
            Mode::Sliding { direction } => Self::anchored(contact, direction, limits.sliding, limits),
        }
    }

    /// Sticking with a force in a direction.
    fn anchored(contact: &Contact<f64>, direction: f64, force: f64, limits: Limits) -> Mode {
        let load = direction * force.min(limits.break_away * (1.0 - BELOW_LIMIT));
        Mode::Sticking { place: contact.position, load }
    }
}

/// Whether a prescribed motion rests, where sliding ends even though the velocity does not cross 0.
fn is_at_rest(contact: &Contact<f64>) -> bool {
    contact.drive == Drive::Motion && contact.velocity == 0.0
}

/// Direction of motion; at rest that of the applied force, or else the one given.
fn direction(contact: &Contact<f64>, otherwise: f64) -> f64 {
    [contact.velocity, contact.applied].map(sign).into_iter().find(|sign| *sign != 0.0).unwrap_or(otherwise)
}
