//! The longest explicit steps of the cylinder.

use crate::friction::{FrictionContact, FrictionLaw};
use crate::system::LongestSteps;

/// Longest explicit steps. At equal pressures the flow through an open valve settles within some ten milliseconds.
const LONGEST: LongestSteps = LongestSteps { classical: 0.01, midpoint: 0.005 };

/// Step size in s from which on explicit steps are cheaper than implicit ones where nothing but waves in hoses bounds them.
pub(super) const WORTHWHILE: f64 = 7e-5;

/// The longest explicit steps: bristles that hold the carriage are springs, on which it swings, and so are the stops.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExplicitSteps {
    /// While bristles hold.
    at_rest: LongestSteps,
    /// In contact with a stop.
    at_stop: LongestSteps,
    /// Speed in m/s from which on a bristle relaxes faster than the carriage swings.
    slipping: f64,
}

impl ExplicitSteps {
    /// Those of a friction law and stops of a stiffness in N/m under a mass in kg.
    pub(super) fn new<L: FrictionLaw>(friction: &FrictionContact<L>, stop: f64, mass: f64) -> Self {
        let [stiffness, damping] = friction.resistance();
        let swing = |stiffness: f64| (stiffness.max(0.0) / mass).sqrt();
        let longest = |swing: f64| LongestSteps::of_swing(swing, damping.max(0.0) / mass).min(LONGEST);
        Self {
            at_rest: longest(swing(stiffness)),
            at_stop: longest(swing(stiffness + stop)),
            slipping: if friction.relaxes() { 2.0 * swing(stiffness) * friction.state_scale() } else { f64::INFINITY },
        }
    }

    /// The longest steps where stops are touched or not, at a velocity in m/s.
    #[inline(always)]
    pub(super) fn longest(&self, touched: [bool; 2], velocity: f64) -> LongestSteps {
        if touched[0] | touched[1] {
            self.at_stop
        } else if velocity.abs() < self.slipping {
            self.at_rest
        } else {
            LONGEST
        }
    }
}
