//! The choice between methods: the cheaper a step, the shorter it must be.

use serde::{Deserialize, Serialize};

/// A step of the implicit method costs as much as this many of the explicit one; where states form a chain, whose matrix is
/// large, it costs more.
const RATIO: f64 = 3.0;
const RATIO_OF_CHAIN: f64 = 5.0;
/// The largest number of explicit steps before the implicit method is tried again.
const MOST_PATIENCE: u32 = 64;
/// Bounds of the reach of the midpoint rule in s at the begin of a communication step, and by what it grows in each.
const SHORTEST_REACH: f64 = 1e-6;
const LONGEST_REACH: f64 = 0.1;
const RECOVERY: f64 = 1.1;

/// Which method the adaptive scheme uses, where the equations may be stiff or not.
///
/// The explicit method goes first. Where many of its steps are needed, the implicit one tries a step as long as it must
/// be to pay, and goes on for as long as that succeeds, at most to the end of the communication step.
///
/// At loose tolerances the midpoint rule takes the rest of a communication step, or leaves it to the others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    is_implicit: bool,
    /// Explicit attempts in a row that were followed by many more.
    short: u32,
    /// Largest number of them.
    patience: u32,
    /// Step size in s of the explicit method when it was last given up.
    given_up_at: f64,
    /// Longest step in s that the midpoint rule is thought to make.
    reach: f64,
}

impl Default for Choice {
    fn default() -> Self {
        Self { is_implicit: false, short: 0, patience: 8, given_up_at: 0.0, reach: LONGEST_REACH }
    }
}

impl Choice {
    /// Whether the next attempt is one of the implicit method.
    pub fn is_implicit(&self) -> bool {
        self.is_implicit
    }

    /// Chooses a method for the next attempt, given the step size to try, the time that remains, and the longest explicit
    /// step, all in s; returns the step size it should try.
    pub fn choose(&mut self, step: f64, remaining: f64, longest: f64, is_chain: bool) -> f64 {
        let ratio = if is_chain { RATIO_OF_CHAIN } else { RATIO };
        if self.is_implicit {
            // Of a chain nothing but the explicit method is bound by how fast it swings.
            let step = if is_chain { step } else { step.min(longest) };
            if step >= ratio * self.given_up_at {
                return step;
            }
            self.patience = (2 * self.patience).clamp(1, MOST_PATIENCE);
            self.is_implicit = false;
            return step.min(self.given_up_at);
        }
        let step = step.min(longest);
        self.short = match ratio * step < remaining {
            true => self.short + 1,
            // Steps of a length that swings set are short in the first part of each communication step alone.
            false if is_chain => self.short.saturating_sub(1),
            false => 0,
        };
        if self.short <= self.patience {
            return step;
        }
        (self.is_implicit, self.short, self.given_up_at) = (true, 0, step);
        ratio * step
    }

    /// Whether the midpoint rule should try the time that remains in s, where its steps may be as long as `longest`.
    pub fn tries_midpoint(&self, remaining: f64, longest: f64) -> bool {
        remaining <= self.reach.min(longest) && !self.is_implicit
    }

    /// Notes that the midpoint rule can take no step beyond a size in s.
    pub fn limit_midpoint(&mut self, size: f64) {
        self.reach = size.clamp(f64::MIN_POSITIVE, LONGEST_REACH);
    }

    /// Notes that the end of a communication step, or a sample, is reached.
    pub fn arrive(&mut self) {
        self.reach = (RECOVERY * self.reach.max(SHORTEST_REACH)).min(LONGEST_REACH);
        if self.is_implicit {
            self.is_implicit = false;
            self.patience /= 2;
        }
    }

    /// Whether a run can have come to this.
    pub fn is_sound(&self) -> bool {
        self.patience <= MOST_PATIENCE
            && self.short <= MOST_PATIENCE
            && self.given_up_at.is_finite()
            && self.reach > 0.0
            && self.reach <= LONGEST_REACH
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Choice where only errors limit explicit steps.
    fn choose(choice: &mut Choice, step: f64, remaining: f64) -> f64 {
        choice.choose(step, remaining, f64::INFINITY, false)
    }

    #[test]
    fn steps_that_reach_the_end_are_explicit() {
        let mut choice = Choice::default();
        for _ in 0..1000 {
            assert_eq!((choose(&mut choice, 0.5, 1.0), choice.is_implicit()), (0.5, false));
            choice.arrive();
        }
    }

    #[test]
    fn implicit_method_takes_over_where_it_pays_until_the_end() {
        let mut choice = Choice::default();
        while !choice.is_implicit() {
            assert!(choose(&mut choice, 1e-3, 1.0) <= 3e-3);
        }
        assert_eq!((choose(&mut choice, 1e-2, 0.5), choice.is_implicit()), (1e-2, true));
        choice.arrive();
        assert!(!choice.is_implicit() && choice.patience == 4, "the next time it takes over sooner");
    }

    /// Twelve steps in a communication step, as a swing sets them, of which the last five are long enough beside what remains.
    #[test]
    fn chain_whose_swing_bounds_explicit_steps_comes_to_the_implicit_method_and_is_not_bound_there() {
        let mut choice = Choice::default();
        let remaining = (1..=12).rev().cycle().map(f64::from);
        let tried: Vec<f64> = remaining
            .take(100)
            .take_while(|remaining| {
                let step = choice.choose(3.0, *remaining, 1.0, true);
                assert_eq!(step, if choice.is_implicit() { 5.0 } else { 1.0 });
                !choice.is_implicit()
            })
            .collect();
        assert!((12..24).contains(&tried.len()), "in the second communication step, not after {} steps", tried.len());
        assert_eq!((choice.choose(9.0, 9.0, 1.0, true), choice.is_implicit()), (9.0, true));
        assert_eq!((choice.choose(4.0, 9.0, 1.0, true), choice.is_implicit()), (1.0, false), "it does not pay");
    }

    #[test]
    fn midpoint_rule_takes_what_is_within_its_reach_which_grows_again() {
        let mut choice = Choice::default();
        assert!(choice.tries_midpoint(1e-3, 5e-3) && !choice.tries_midpoint(6e-3, 5e-3), "no more than is stable");
        choice.limit_midpoint(5e-4);
        let mut waits = 0;
        while !choice.tries_midpoint(1e-3, 5e-3) {
            choice.arrive();
            waits += 1;
        }
        assert_eq!(waits, 8, "1.1^8 = 2.1");
        for size in [0.0, f64::INFINITY] {
            choice.limit_midpoint(size);
            assert!(choice.is_sound(), "after {size}");
        }
    }

    /// The rest behind an event may be shorter than the shortest first reach of a communication step.
    #[test]
    fn midpoint_rule_does_not_try_again_what_it_has_given_up() {
        let mut choice = Choice::default();
        choice.limit_midpoint(1e-7);
        assert!(choice.is_sound() && !choice.tries_midpoint(5e-7, 1.0));
        choice.arrive();
        assert!(choice.tries_midpoint(1e-6, 1.0));
    }

    #[test]
    fn implicit_method_that_does_not_pay_is_left_alone_for_longer() {
        let mut choice = Choice::default();
        for _ in 0..5 {
            while !choice.is_implicit() {
                choose(&mut choice, 1e-3, 1.0);
            }
            assert_eq!((choose(&mut choice, 2e-3, 1.0), choice.is_implicit()), (1e-3, false));
        }
        assert_eq!(choice.patience, MOST_PATIENCE);
        assert!(choice.is_sound());
    }
    #[test]
    fn choices_that_no_run_makes_are_not_sound() {
        let sound = Choice { short: MOST_PATIENCE, patience: MOST_PATIENCE, ..Choice::default() };
        assert!(sound.is_sound());
        for choice in [
            Choice { short: MOST_PATIENCE + 1, ..sound },
            Choice { patience: MOST_PATIENCE + 1, ..sound },
            Choice { given_up_at: f64::NAN, ..sound },
            Choice { given_up_at: f64::INFINITY, ..sound },
            Choice { reach: f64::NAN, ..sound },
            Choice { reach: 0.0, ..sound },
            Choice { reach: 2.0 * LONGEST_REACH, ..sound },
        ] {
            assert!(!choice.is_sound(), "{choice:?}");
        }
    }
}
