//! Kinks: non-smooth points of the equations within a mode. Steps end on them.

use std::ops::Range;

use super::Run;
use crate::numbers::Varying;
use crate::solver::event::Hermite;
use crate::solver::values;
use crate::system::System;

/// Accuracy of the location of a kink, as a fraction of the step.
const RESOLUTION: f64 = 1.0 / 4096.0;
/// Where in a step a kink is taken for the reason of an error.
const WELL_WITHIN: Range<f64> = 1e-3..0.98;
/// Distance from an end of a step, as a fraction of it, from which on a kink counts as one in the middle.
const FAR: f64 = 0.125;

/// The first kink within a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kink {
    /// The fraction of the step before it.
    place: f64,
    /// Whether the equations are smooth from there on.
    is_last: bool,
}

impl Kink {
    /// Whether it is so far from the ends that the step cannot do without ending on it.
    pub(super) fn is_well_within(&self) -> bool {
        WELL_WITHIN.contains(&self.place)
    }

    /// Weight of the error estimate of order 2: the effect of a kink grows with the square of its distance from the nearer
    /// end, the estimate with the distance.
    pub(super) fn weight(&self) -> f64 {
        if self.is_last { (self.place.min(1.0 - self.place) / FAR).min(1.0) } else { 1.0 }
    }
}

impl<H: System<U>, const N: usize, const U: usize, S: Varying> Run<H, N, U, S> {
    /// The first kink that a step of a size in s meets.
    #[inline(always)]
    pub(super) fn kink(&self, h: f64, end_time: f64, end: &[S; N]) -> Option<Kink> {
        if self.is_smooth(h, end_time, end) { None } else { Some(self.first_kink(h, end_time, &values(end))) }
    }

    /// Whether a step of a size in s meets no kink.
    #[inline(always)]
    pub(super) fn is_smooth(&self, h: f64, end_time: f64, end: &[S; N]) -> bool {
        let [u, u_end] = [self.time, end_time].map(|time| values(&self.inputs.at(time)));
        self.system.is_smooth([&values(&self.x), &values(end)], [&u, &u_end], &self.memory, h)
    }

    /// The first non-smooth point of the cubic between the ends of a step.
    #[cold]
    #[inline(never)]
    fn first_kink(&self, h: f64, end_time: f64, end: &[f64; N]) -> Kink {
        let inputs = |time: f64| values(&self.inputs.at(time));
        let (u, u_end, x) = (inputs(self.time), inputs(end_time), &values(&self.x));
        let [start_slope, end_slope] = self.slopes(end_time, end);
        let path = Hermite { start: x, start_slope: &start_slope, end, end_slope: &end_slope, h };
        let narrowed = |[smooth, place]: [f64; 2], at: f64| {
            let u_at = inputs(self.time + at * h);
            let is_smooth = self.system.is_smooth([x, &path.at(at)], [&u, &u_at], &self.memory, at * h);
            if is_smooth { [at, place] } else { [smooth, at] }
        };
        let mut bracket = [0.0, 1.0];
        // As a rule it is where the motion turns: two looks show whether it is.
        if let Some(turn) = self.system.turning(N).and_then(|state| path.zero(state, 0.1 * RESOLUTION)) {
            for near in [turn - 0.45 * RESOLUTION, turn + 0.45 * RESOLUTION] {
                if bracket[0] < near && near < bracket[1] {
                    bracket = narrowed(bracket, near);
                }
            }
        }
        while bracket[1] - bracket[0] > RESOLUTION {
            bracket = narrowed(bracket, 0.5 * (bracket[0] + bracket[1]));
        }
        let place = bracket[1];
        let u_place = inputs(self.time + place * h);
        let rest = (1.0 - place) * h;
        let is_last = self.system.is_smooth([&path.at(place), end], [&u_place, &u_end], &self.memory, rest);
        Kink { place, is_last }
    }

    /// The fraction of a step of a run in numbers with slopes at which it meets the first kink behind a fraction; where slopes
    /// change, it matters more than in a plain run where that is.
    pub(super) fn first_kink_behind(&self, path: &Hermite<N>, from: f64) -> Option<f64> {
        /// As a fraction of the step.
        const SHARP: f64 = 1e-9;
        let inputs = |at: f64| values(&self.inputs.at(self.time + at * path.h));
        let (x, u) = (self.between(path, from), inputs(from));
        let is_smooth = |at: f64| {
            self.system.is_smooth([&x, &self.between(path, at)], [&u, &inputs(at)], &self.memory, (at - from) * path.h)
        };
        if is_smooth(1.0) {
            return None;
        }
        let mut bracket = [from, 1.0];
        while bracket[1] - bracket[0] > SHARP {
            let middle = 0.5 * (bracket[0] + bracket[1]);
            bracket[usize::from(!is_smooth(middle))] = middle;
        }
        Some(bracket[1])
    }

    /// The fraction of a step of a size in s that ends on a kink; behind it, steps may be as long again.
    pub(super) fn go_for(&mut self, kink: Kink, h: f64) -> f64 {
        // Steps of the midpoint rule are as long as the rest: the size to return to is the classical method's.
        self.beyond = self.beyond.max(if self.is_midpoint { self.step } else { h });
        kink.place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kink_counts_in_full_unless_it_is_the_only_one_and_near_an_end() {
        let weight = |place: f64, is_last: bool| Kink { place, is_last }.weight();
        for place in [0.125, 0.5, 0.875] {
            assert_eq!([weight(place, true), weight(place, false)], [1.0; 2], "{place}");
        }
        for place in [1.0 / 16.0, 15.0 / 16.0] {
            assert_eq!([weight(place, true), weight(place, false)], [0.5, 1.0], "{place}");
        }
        assert_eq!([weight(0.0, true), weight(1.0, true)], [0.0; 2]);
    }

    #[test]
    fn only_a_kink_away_from_the_ends_is_worth_a_step_of_its_own() {
        let is_well_within = |place: f64| Kink { place, is_last: true }.is_well_within();
        assert!([0.001, 0.5, 0.979].into_iter().all(is_well_within));
        assert!(![0.0, 0.000_9, 0.98, 1.0].into_iter().any(is_well_within));
    }
}
