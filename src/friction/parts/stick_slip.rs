//! True stiction: the two modes of a set-valued law.
//!
//! While stuck the velocity is exactly 0 and friction equals the applied force, until that exceeds the break-away
//! force. Sliding ends exactly when the velocity crosses 0; there the mass sticks again if the applied force allows.

use serde::{Deserialize, Serialize};

use super::dwell::{Dwell, Resting};
use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw};
use crate::numbers::{Real, Scalar, sign};
use crate::variables::{Field, ParameterError, ParameterSet, Tunable, Variable, declared};

/// The mode of a set-valued law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// At rest, held by friction.
    Stuck,
    /// Sliding in a direction, +1 or -1.
    Sliding(f64),
}

impl Mode {
    /// The mode at a velocity: at rest, the applied force decides.
    pub fn at<S: Scalar>(contact: &Contact<S>, velocity: S, break_away: S) -> Self {
        let [velocity, applied, break_away] = [velocity, contact.applied, break_away].map(S::value);
        if velocity != 0.0 {
            Self::Sliding(sign(velocity))
        } else if contact.drive == Drive::Force && applied.abs() > break_away {
            Self::Sliding(sign(applied))
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

    /// Direction while sliding.
    pub fn direction(self) -> Option<f64> {
        match self {
            Self::Stuck => None,
            Self::Sliding(direction) => Some(direction),
        }
    }

    /// The events of the two modes.
    pub const EVENTS: &'static [Event] = &[Event::Stop, Event::BreakAway];

    /// A prescribed motion has no events, since nothing that is integrated depends on the mode: it follows the velocity.
    pub const FOLLOWS: &'static [Drive] = &[Drive::Motion];

    /// Sets the indicator of the present mode: the reserve until break-away, a force that is asked for while stuck alone,
    /// or the speed.
    #[inline(always)]
    pub fn indicators<S: Scalar>(self, contact: &Contact<S>, break_away: impl FnOnce() -> S, out: &mut Indicators<S>) {
        match (self, contact.drive) {
            (_, Drive::Motion) => {}
            (Self::Stuck, Drive::Force) => out[Event::BreakAway] = break_away() - contact.applied.abs(),
            (Self::Sliding(direction), Drive::Force) => out[Event::Stop] = contact.velocity * direction,
        }
    }

    /// The mode after an event of the present one; sets the velocity to exactly 0.
    pub fn switched<S: Scalar>(self, contact: &Contact<S>, velocity: &mut S, break_away: S) -> Self {
        *velocity = S::zero();
        match self {
            Self::Stuck => Self::Sliding(sign(contact.applied.value())),
            Self::Sliding(_) => Self::at(contact, *velocity, break_away),
        }
    }
}

/// A law that is a break-away force and a kinetic curve, with the two modes above.
///
/// At every load factor the kinetic force at zero velocity must not exceed the break-away force. Under an applied force between
/// the two the contact would break away and stop again without end. Parameters that lead there are refused at the start.
pub trait SetValued: ParameterSet {
    /// Checks that parameters which are legal one by one fit together.
    ///
    /// # Errors
    /// [`ParameterError`] if they do not.
    fn check(&self) -> Result<(), ParameterError> {
        Ok(())
    }

    /// Whether the kinetic force changes gently with the velocity.
    fn is_non_stiff(&self) -> bool {
        true
    }

    /// Largest force in N that holds the mass against an applied force in a direction, +1 or -1, at a load factor; not negative.
    fn break_away<S: Scalar>(&self, direction: f64, level: S) -> S;

    /// Force in N while sliding in a direction; smooth in the velocity across 0, where an event ends it, and there no larger
    /// than the break-away force.
    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S;
}

/// A set-valued law as a friction law, whose break-away force may grow with the time at rest.
#[derive(Clone, Debug)]
pub struct StickSlip<L> {
    law: L,
    dwell: Dwell,
}

/// The parameters of the law, then those of the break-away force that grows at rest.
impl<L: ParameterSet> ParameterSet for StickSlip<L> {
    const LEN: usize = L::LEN + Dwell::LEN;

    fn table() -> Vec<Variable> {
        L::table().into_iter().chain(declared::<Dwell, _>(Dwell::variables())).collect()
    }

    fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
        let (own, rest) = values.split_at(L::LEN);
        let dwell = Dwell::read(rest).expect("numbers make a group of them");
        Ok(Self { law: L::read(own)?, dwell })
    }
}

/// Load factors at which the kinetic force is compared with the break-away force.
const LEVELS: [f64; 4] = [0.0, 0.5, 1.0, 2.0];
/// Share by which rounding may raise the kinetic force above the break-away force.
const ROUNDING: f64 = 1e-9;

impl<L: SetValued> StickSlip<L> {
    /// Refuses a contact that breaks away under a force against which it cannot start to slide.
    fn check_rest(&self) -> Result<(), ParameterError> {
        for level in LEVELS {
            for direction in [1.0, -1.0] {
                let break_away = self.law.break_away(direction, Real::of(level)).value;
                if break_away < 0.0 {
                    let reason = format!("at the load factor {level} it must not be negative");
                    return Err(ParameterError::new("break-away force", break_away, &reason));
                }
                let kinetic = direction * self.law.kinetic(Real::of(0.0), direction, Real::of(level)).value;
                if kinetic > break_away * (1.0 + ROUNDING) {
                    let side = if direction > 0.0 { "+0" } else { "-0" };
                    let reason = format!(
                        "at the velocity {side} and the load factor {level} it must not exceed the break-away force of \
                         {break_away} N, or break-away and stop follow each other without end"
                    );
                    return Err(ParameterError::new("kinetic force", kinetic, &reason));
                }
            }
        }
        Ok(())
    }

    /// Largest force in N that holds the mass against the applied force after a time at rest in s.
    fn break_away<S: Scalar>(&self, contact: &Contact<S>, dwell: impl FnOnce() -> S) -> S {
        let direction = if contact.applied.value() < 0.0 { -1.0 } else { 1.0 };
        self.dwell.grown(self.law.break_away(direction, contact.level), dwell)
    }
}

/// Methods of a [`FrictionLaw`] with the two modes. `break_away(&self, contact, dwell)` is the largest force in N that holds the mass
/// after a time at rest in s.
macro_rules! two_modes {
    () => {
        type Memory<S: $crate::numbers::Varying> = $crate::friction::parts::dwell::Resting<S>;

        fn stiction(&self) -> $crate::friction::Stiction {
            $crate::friction::Stiction::Exact
        }

        fn may_differ_by_direction(&self) -> bool {
            true
        }

        fn is_set_valued(&self) -> bool {
            true
        }

        fn sliding_direction<S: $crate::numbers::Varying>(memory: &Self::Memory<S>) -> Option<f64> {
            memory.mode.direction()
        }

        fn events(&self) -> &'static [$crate::friction::Event] {
            $crate::friction::parts::stick_slip::Mode::EVENTS
        }

        fn follows(&self) -> &'static [$crate::friction::Drive] {
            $crate::friction::parts::stick_slip::Mode::FOLLOWS
        }

        fn start<S: $crate::numbers::Varying>(&self, contact: &Contact<S>) -> Self::Memory<S> {
            Self::Memory::start(contact, |dwell| self.break_away(contact, || dwell))
        }

        fn indicators<S: $crate::numbers::Varying>(
            &self,
            contact: &Contact<S>,
            _z: &[S],
            memory: &Self::Memory<S>,
            out: &mut $crate::friction::Indicators<S>,
        ) {
            let break_away = || self.break_away(contact, || contact.time - memory.since);
            memory.mode.indicators(contact, break_away, out);
        }

        fn switch<S: $crate::numbers::Varying>(
            &self,
            _event: $crate::friction::Event,
            contact: &Contact<S>,
            velocity: &mut S,
            _z: &mut [S],
            memory: &mut Self::Memory<S>,
        ) {
            memory.switch(contact, velocity, |dwell| self.break_away(contact, || dwell));
        }

        fn follow<S: $crate::numbers::Varying>(
            &self,
            contact: &Contact<S>,
            _z: &[S],
            memory: &mut Self::Memory<S>,
        ) -> bool {
            memory.follow(contact, |dwell| self.break_away(contact, || dwell))
        }

        fn is_sticking<S: $crate::numbers::Varying>(memory: &Self::Memory<S>) -> bool {
            memory.mode == $crate::friction::parts::stick_slip::Mode::Stuck
        }
    };
}
pub(crate) use two_modes;

impl<L: SetValued> FrictionLaw for StickSlip<L> {
    two_modes!();

    fn check(&self) -> Result<(), ParameterError> {
        self.law.check()?;
        self.check_rest()
    }

    fn is_non_stiff(&self) -> bool {
        self.law.is_non_stiff()
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], memory: &Resting<S::Held>, _rates: &mut [S]) -> S {
        match memory.mode {
            Mode::Stuck => {
                let dwell = || contact.time - S::held(memory.since);
                Mode::holding_force(contact, self.break_away(contact, dwell))
            }
            Mode::Sliding(direction) => self.law.kinetic(contact.velocity, direction, contact.level),
        }
    }
}
