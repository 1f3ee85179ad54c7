//! Break-away after a rest: the mode of a set-valued law with the time since when it rests, and the growth of its break-away force.

use serde::{Deserialize, Serialize};

use super::parameters::dwell_time;
use super::stick_slip::Mode;
use crate::friction::law::Contact;
use crate::numbers::{Scalar, Varying};
use crate::parameter_group;
use crate::variables::{Tunable, Variable, units};

parameter_group! {
    /// Growth of the break-away force with the time `t` at rest, as a fraction of it.
    ///
    /// ```text
    /// F(t) = F*(1 + restGrowth*t/(t + gamma))   [N]
    /// ```
    ///
    /// Nothing of it is left once the contact slides, be it by micrometres. A run that starts at rest has rested for ever.
    Dwell() {
        growth: Tunable = Variable::parameter(90, "restGrowth", units::ONE, 0.0).range(0.0, 100.0).nominal(0.5)
            .text("Growth of the break-away force over a long time at rest, as a fraction of it; 0: none");
        time: Tunable = dwell_time(91, 0.1).counts_with("restGrowth").text("Time at rest in which half of the growth is done");
    }
}

impl Dwell {
    /// The break-away force in N after a time at rest in s, from that at once.
    #[inline(always)]
    pub fn grown<S: Scalar>(&self, force: S, dwell: impl FnOnce() -> S) -> S {
        if !self.growth.is_used() {
            return force;
        }
        risen(force * self.growth, self.time, dwell()) + force
    }
}

/// The part of a growth that is done after a time at rest in s: `t/(t + gamma)` of it, in a form that has its limits at 0 and at infinity.
pub fn risen<S: Scalar>(growth: S, time: Tunable, dwell: S) -> S {
    if dwell.value() == 0.0 {
        return S::zero();
    }
    growth / (S::tuned(time) / dwell + 1.0)
}

/// The mode, and since when it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resting<S> {
    /// Stuck or sliding.
    pub mode: Mode,
    /// Time in s at which the mode began.
    pub since: S,
}

impl<S: Varying> Resting<S> {
    /// The mode at the start of a run: one at rest has been so for ever, with the break-away force that has grown for as long.
    pub fn start(contact: &Contact<S>, break_away: impl FnOnce(S) -> S) -> Self {
        let break_away = break_away(S::of(f64::INFINITY));
        Self { mode: Mode::at(contact, contact.velocity, break_away), since: S::of(f64::NEG_INFINITY) }
    }

    /// Changes the mode at an event of the present one, and sets the velocity to exactly 0.
    pub fn switch(&mut self, contact: &Contact<S>, velocity: &mut S, break_away: impl FnOnce(S) -> S) {
        *self = Self { mode: self.mode.switched(contact, velocity, break_away(S::zero())), since: contact.time };
    }

    /// Follows a prescribed motion; returns whether the mode has changed.
    pub fn follow(&mut self, contact: &Contact<S>, break_away: impl FnOnce(S) -> S) -> bool {
        let mode = Mode::at(contact, contact.velocity, break_away(contact.time - self.since));
        if mode == self.mode {
            return false;
        }
        *self = Self { mode, since: contact.time };
        true
    }
}
