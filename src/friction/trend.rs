//! The acceleration of a prescribed motion, by its sign.

use serde::{Deserialize, Serialize};

use super::law::FrictionLaw;
use crate::numbers::{Scalar, sign};

/// A force in N beyond everything that a friction law can answer with.
pub const OVERWHELMING: f64 = 1e12;

/// Last change of the speed of a prescribed motion, also from one held value of the input to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trend<S> {
    /// Velocity last seen in m/s.
    velocity: S,
    /// 1 if its magnitude grew, or after a reversal; -1 if it fell.
    pub sign: f64,
}

impl<S: Scalar> Trend<S> {
    /// The trend of a motion that begins with a velocity in m/s.
    pub fn new(velocity: S) -> Self {
        Self { velocity, sign: 1.0 }
    }

    /// Takes notice of the present velocity.
    pub fn follow(&mut self, velocity: S) {
        let [now, before] = [velocity, self.velocity].map(S::value);
        if now != before {
            let is_reversed = now != 0.0 && (now > 0.0) != (before > 0.0);
            let falls = !is_reversed && now.abs() < before.abs();
            self.sign = if falls { -1.0 } else { 1.0 };
            self.velocity = velocity;
        }
    }

    /// The applied force in N as a law sees it at a velocity in m/s, under a [sign](Self::sign): the given one, or a force beyond
    /// all friction for a law that [asks](FrictionLaw::asks_for_applied_force) for the force on a sliding mass.
    pub fn applied(sign_of_trend: f64, law: &impl FrictionLaw, velocity: S, given: S) -> S {
        let accelerates = sign_of_trend * sign(velocity.value());
        if accelerates != 0.0 && law.asks_for_applied_force() {
            return S::constant(accelerates * OVERWHELMING);
        }
        given
    }

    /// Whether a run can have it.
    pub fn is_sound(&self) -> bool {
        self.velocity.value().is_finite()
    }
}
