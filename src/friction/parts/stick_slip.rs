//! True stiction: the two modes of a set-valued law.
//!
//! While stuck the velocity is exactly 0 and friction equals the applied force, until that exceeds the break-away
//! force. Sliding ends exactly when the velocity crosses 0; there the mass sticks again if the applied force allows.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw, Stiction};
use crate::numbers::{Real, Scalar, sign};
use crate::variables::{ParameterError, ParameterSet};

/// The mode of a set-valued law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// At rest, held by friction.
    Stuck,
    /// Sliding in a direction, +1 or -1.
    Sliding(#[serde(with = "crate::system::side")] f64),
}

impl Mode {
    /// The mode at a velocity: at rest, the applied force decides.
    pub fn at(contact: &Contact<f64>, velocity: f64, break_away: f64) -> Self {
        if velocity != 0.0 {
            Self::Sliding(sign(velocity))
        } else if contact.drive == Drive::Force && contact.applied.abs() > break_away {
            Self::Sliding(sign(contact.applied))
        } else {
            Self::Stuck
        }
    }

    /// Force while stuck: the applied force, within the break-away force.
    pub fn holding_force<S: Scalar>(contact: &Contact<S>, break_away: S) -> S {
        match contact.drive {
            // Events guarantee the bound, and an exact balance makes the acceleration exactly 0.
            Drive::Force => contact.applied,
            Drive::Motion => contact.applied.clamp(-break_away, break_away),
        }
    }

    /// The events of the two modes.
    pub const EVENTS: &'static [Event] = &[Event::Stop, Event::BreakAway];

    /// A prescribed motion has no events, since nothing that is integrated depends on the mode: it follows the velocity.
    pub const FOLLOWS: &'static [Drive] = &[Drive::Motion];

    /// Sets the indicator of the present mode: the reserve until break-away, a force that is asked for while stuck alone,
    /// or the speed.
    #[inline(always)]
    pub fn indicators(self, contact: &Contact<f64>, break_away: impl FnOnce() -> f64, out: &mut Indicators) {
        match (self, contact.drive) {
            (_, Drive::Motion) => {}
            (Self::Stuck, Drive::Force) => out[Event::BreakAway] = break_away() - contact.applied.abs(),
            (Self::Sliding(direction), Drive::Force) => out[Event::Stop] = direction * contact.velocity,
        }
    }

    /// The mode after an event of the present one; sets the velocity to exactly 0.
    pub fn switched(self, contact: &Contact<f64>, velocity: &mut f64, break_away: f64) -> Self {
        *velocity = 0.0;
        match self {
            Self::Stuck => Self::Sliding(sign(contact.applied)),
            Self::Sliding(_) => Self::at(contact, *velocity, break_away),
        }
    }
}

/// A law that is a break-away force and a kinetic curve, with the two modes above.
pub trait SetValued: ParameterSet {
    /// Checks that parameters which are legal one by one fit together.
    ///
    /// # Errors
    /// [`ParameterError`] if they do not.
    fn check(&self) -> Result<(), ParameterError> {
        Ok(())
    }

    /// Whether the kinetic force changes gently with the velocity.
    fn is_gentle(&self) -> bool {
        true
    }

    /// Largest force in N that holds the mass at a load level.
    fn break_away<S: Scalar>(&self, level: S) -> S;

    /// Force in N while sliding in a direction; smooth in the velocity across 0, where an event ends it.
    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S;
}

wrapper! {
    /// A set-valued law as a friction law.
    StickSlip
}

impl<L: SetValued> StickSlip<L> {
    fn break_away_at(&self, contact: &Contact<f64>) -> f64 {
        self.0.break_away(Real::of(contact.level)).value
    }
}

impl<L: SetValued> FrictionLaw for StickSlip<L> {
    type Memory = Mode;

    fn stiction(&self) -> Stiction {
        Stiction::Exact
    }

    fn events(&self) -> &'static [Event] {
        Mode::EVENTS
    }

    fn follows(&self) -> &'static [Drive] {
        Mode::FOLLOWS
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.0.check()
    }

    fn is_gentle(&self) -> bool {
        self.0.is_gentle()
    }

    fn start(&self, contact: &Contact<f64>) -> Mode {
        Mode::at(contact, contact.velocity, self.break_away_at(contact))
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], mode: &Mode, _rates: &mut [S]) -> S {
        match *mode {
            Mode::Stuck => Mode::holding_force(contact, self.0.break_away(contact.level)),
            Mode::Sliding(direction) => self.0.kinetic(contact.velocity, direction, contact.level),
        }
    }

    fn indicators(&self, contact: &Contact<f64>, _z: &[f64], mode: &Mode, out: &mut Indicators) {
        mode.indicators(contact, || self.break_away_at(contact), out);
    }

    fn switch(&self, _event: Event, contact: &Contact<f64>, velocity: &mut f64, _z: &mut [f64], mode: &mut Mode) {
        *mode = mode.switched(contact, velocity, self.break_away_at(contact));
    }

    fn follow(&self, contact: &Contact<f64>, _z: &[f64], mode: &mut Mode) -> bool {
        let before = *mode;
        *mode = Mode::at(contact, contact.velocity, self.break_away_at(contact));
        *mode != before
    }

    fn is_sticking(mode: &Mode) -> bool {
        *mode == Mode::Stuck
    }
}
