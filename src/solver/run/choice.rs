//! The choice between two methods: one with cheap steps, and one whose steps may be longer.

use serde::{Deserialize, Serialize};

/// A step of the implicit method costs as much as this many of the explicit one.
const RATIO: f64 = 3.0;
/// The largest number of explicit steps before the implicit method is tried again.
const MOST_PATIENCE: u32 = 64;

/// Which method the adaptive scheme uses, where the equations may turn out to be gentle or stiff.
///
/// The explicit method goes first. Where many of its steps are needed, the implicit one tries a step as long as it must
/// be to pay, and goes on for as long as that succeeds, at most to the end of the communication step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    is_implicit: bool,
    /// Explicit attempts in a row that were followed by many more.
    short: u32,
    /// How many of them there may be.
    patience: u32,
    /// Step size in s of the explicit method when it was last given up.
    given_up_at: f64,
}

impl Default for Choice {
    fn default() -> Self {
        Self { is_implicit: false, short: 0, patience: 8, given_up_at: 0.0 }
    }
}

impl Choice {
    /// Whether the next attempt is one of the implicit method.
    pub fn is_implicit(&self) -> bool {
        self.is_implicit
    }

    /// Chooses a method for the next attempt, given the step size to try and the time that remains, both in s; returns
    /// the step size it should try.
    pub fn choose(&mut self, step: f64, remaining: f64) -> f64 {
        let is_short = RATIO * step < remaining;
        if self.is_implicit {
            if step >= RATIO * self.given_up_at {
                return step;
            }
            self.patience = (2 * self.patience).clamp(1, MOST_PATIENCE);
            self.is_implicit = false;
            return step.min(self.given_up_at);
        }
        self.short = if is_short { self.short + 1 } else { 0 };
        if self.short <= self.patience {
            return step;
        }
        (self.is_implicit, self.short, self.given_up_at) = (true, 0, step);
        RATIO * step
    }

    /// Notes that the end of a communication step, or a sample, is reached.
    pub fn arrive(&mut self) {
        if self.is_implicit {
            self.is_implicit = false;
            self.patience /= 2;
        }
    }

    /// Whether a run can have come to this.
    pub fn is_sound(&self) -> bool {
        self.patience <= MOST_PATIENCE && self.short <= MOST_PATIENCE && self.given_up_at.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_reach_the_end_are_explicit() {
        let mut choice = Choice::default();
        for _ in 0..1000 {
            assert_eq!((choice.choose(0.5, 1.0), choice.is_implicit()), (0.5, false));
            choice.arrive();
        }
    }

    #[test]
    fn implicit_method_takes_over_where_it_pays_until_the_end() {
        let mut choice = Choice::default();
        while !choice.is_implicit() {
            assert!(choice.choose(1e-3, 1.0) <= 3e-3);
        }
        assert_eq!((choice.choose(1e-2, 0.5), choice.is_implicit()), (1e-2, true));
        choice.arrive();
        assert!(!choice.is_implicit() && choice.patience == 4, "the next time it takes over sooner");
    }

    #[test]
    fn implicit_method_that_does_not_pay_is_left_alone_for_longer() {
        let mut choice = Choice::default();
        for _ in 0..5 {
            while !choice.is_implicit() {
                choice.choose(1e-3, 1.0);
            }
            assert_eq!((choice.choose(2e-3, 1.0), choice.is_implicit()), (1e-3, false));
        }
        assert_eq!(choice.patience, MOST_PATIENCE);
        assert!(choice.is_sound());
    }
}
