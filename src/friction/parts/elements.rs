//! Parallel elements, each a spring in series with a slider: which of them stick and which slip.
//!
//! An element starts to slip when its force reaches its limit *and* the motion loads it further; all slipping elements
//! stick again when the velocity reverses. Since both rules look at the sign of the velocity, an element whose limit
//! falls below its force (limits may depend on pressure and on speed) unloads as a spring and cannot chatter.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::MAX_STATES;
use crate::numbers::{Scalar, sign};
use crate::system::UNUSED;
use crate::variables::Variable;

/// The largest number of elements, each of which may have a state.
pub const MAX_ELEMENTS: usize = MAX_STATES;

/// Elements closer to their limit than this fraction of it count as having reached it.
const AT_LIMIT: f64 = 1e-12;

/// Number of elements in use `N`, value reference 5.
pub fn count(default: i32) -> Variable {
    Variable::count(5, "N", default).range(1.0, MAX_ELEMENTS as f64).text("Number of elements; those beyond are unused")
}

/// The modes of the elements.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    /// Direction of slipping, +1 or -1; 0 while none slips.
    direction: f64,
    slips: [bool; MAX_ELEMENTS],
}

/// An element as it is loaded: the force it carries, and the largest it can carry, in N.
#[derive(Clone, Copy, Debug)]
pub struct Load<S> {
    /// Force in N.
    pub force: S,
    /// Limit in N, not negative.
    pub limit: S,
}

impl<S: Scalar> Load<S> {
    /// Positive while an element may stick: below the limit, or while the motion unloads it.
    fn reserve(self, velocity: S) -> S {
        let unloading = velocity * -sign(self.force.value());
        (self.limit * (1.0 - AT_LIMIT) - self.force.abs()).max(unloading)
    }
}

impl Modes {
    /// Direction in which an element slips, or `None` if it sticks.
    pub fn slip(&self, element: usize) -> Option<f64> {
        self.slips[element].then_some(self.direction)
    }

    /// Sets two indicators: until the slipping elements stick again, and until the next one slips.
    pub fn indicators<S: Scalar>(&self, velocity: S, loads: impl Iterator<Item = Load<S>>, out: &mut Indicators<S>) {
        match self.direction {
            0.0 => {}
            _ if velocity.value() == 0.0 => out[Event::Stop] = S::of(-f64::MIN_POSITIVE),
            direction => out[Event::Stop] = velocity * direction,
        }
        let reserves = self.reserves(velocity, loads);
        out[Event::BreakAway] = reserves.fold(S::of(UNUSED), |least, (_, reserve)| least.min(reserve));
    }

    /// Handles the end of slipping.
    pub fn stick(&mut self) {
        *self = Self::default();
    }

    /// Lets the elements slip that have no reserve, at least the one that has least.
    pub fn slip_next<S: Scalar>(&mut self, velocity: S, loads: impl Iterator<Item = Load<S>> + Clone) {
        let least = self.reserves(velocity, loads.clone()).min_by(|(_, a), (_, b)| a.value().total_cmp(&b.value()));
        let Some((weakest, least)) = least else { return };
        let force = loads.clone().nth(weakest).map_or(0.0, |load| load.force.value());
        self.direction = if velocity.value() == 0.0 { sign(force) } else { sign(velocity.value()) };
        let mut slips = self.slips;
        for (element, reserve) in self.reserves(velocity, loads) {
            slips[element] = reserve.value() <= least.value().max(0.0);
        }
        self.slips = slips;
    }

    /// The sticking elements and their reserves.
    fn reserves<S: Scalar>(
        &self,
        velocity: S,
        loads: impl Iterator<Item = Load<S>>,
    ) -> impl Iterator<Item = (usize, S)> {
        let sticking = loads.enumerate().filter(|(element, _)| !self.slips[*element]);
        sticking.map(move |(element, load)| (element, load.reserve(velocity)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    fn loads(forces: [f64; 3]) -> impl Iterator<Item = Load<Real>> + Clone {
        forces.into_iter().map(|force| Load { force: Real::of(force), limit: Real::of(1.0) })
    }

    fn indicators(modes: &Modes, velocity: f64, forces: [f64; 3]) -> Indicators {
        let mut out = Indicators::default();
        modes.indicators(Real::of(velocity), loads(forces), &mut out);
        out
    }

    #[test]
    fn elements_that_reach_the_limit_together_slip_together() {
        let mut modes = Modes::default();
        modes.slip_next(Real::of(0.1), loads([1.0, 0.5, 1.0]));
        assert_eq!([0, 1, 2].map(|element| modes.slip(element)), [Some(1.0), None, Some(1.0)]);
    }

    #[test]
    fn force_beyond_a_limit_that_fell_is_no_event_while_it_is_unloaded() {
        let modes = Modes::default();
        assert_eq!(indicators(&modes, -1e-6, [1.5, 0.0, 0.0]).due(), None);
        assert_eq!(indicators(&modes, 1e-6, [1.5, 0.0, 0.0]).due(), Some(Event::BreakAway));
    }

    #[test]
    fn slipping_ends_at_rest_and_at_reversal_only() {
        let mut modes = Modes::default();
        modes.slip_next(Real::of(0.1), loads([1.0, 0.0, 0.0]));
        assert!(indicators(&modes, 1e-9, [1.0, 0.0, 0.0])[Event::Stop].value > 0.0);
        assert!(indicators(&modes, 0.0, [1.0, 0.0, 0.0])[Event::Stop].value < 0.0);
        assert!(indicators(&modes, -1e-9, [1.0, 0.0, 0.0])[Event::Stop].value < 0.0);
    }
}
