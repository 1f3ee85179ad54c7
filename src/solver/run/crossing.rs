//! Events: found within a step, located, handled.

use super::{Run, smallest_step};
use crate::numbers::Varying;
use crate::solver::error::{Rejection, StepError};
use crate::solver::event::{Bracket, Hermite, root};
use crate::solver::{array, numbers, values};
use crate::system::System;

/// Switches at one instant before it counts as chattering.
const MAX_SWITCHES: usize = 100;
/// Distance from the end of a step, as a fraction of it, within which the cubic through its ends replaces it: it differs
/// from the motion by the square of this, times the estimated error.
const NEAR: f64 = 1.0 / 128.0;
/// Accuracy of the first guess of a crossing, as a fraction of the step.
const GUESS: f64 = 1e-3;
/// Trial steps to locate an event; one is enough as a rule.
const MAX_REFINEMENTS: usize = 60;

impl<H: System<U>, const N: usize, const U: usize, S: Varying> Run<H, N, U, S> {
    /// Whether an indicator is negative in the middle of a step at both ends of which it is not.
    pub(super) fn dips_between(&self, h: f64, end: &[S; N]) -> bool {
        let slope = &self.linearisation.derivatives;
        // The parabola through the start, its slope, and the end, at half the step.
        let middle = array(|i| self.x[i] * 0.75 + (end[i] + slope[i] * h) * 0.25);
        let between = self.indicators_at(self.time + 0.5 * h, &middle);
        let pairs = between.as_ref().iter().zip(self.indicators.as_ref());
        pairs.into_iter().any(|(between, before)| between.value() < 0.0 && before.value() > 0.0)
    }

    /// Ends the step where the first indicator turns negative, and switches.
    // Few steps end so: a function of its own keeps the common path short.
    #[inline(never)]
    pub(super) fn step_to_event(&mut self, h: f64, end: &[S; N], after: &H::Indicators<S>) -> Result<(), StepError> {
        let (event, bracket, guess) = match self.first_crossing(h, end, after) {
            Ok(crossing) => crossing,
            Err(event) => return self.leave_limit(event, h, end),
        };
        let (at, end) = self.refine(event, bracket, guess, *end);
        let end = if S::VARIES { self.at_event(at, end) } else { end };
        self.move_to(self.time + at, &end, false, Some(event));
        self.step = if self.settings.is_adaptive() { self.step.min(h) } else { self.settings.step };
        self.reach(event)
    }

    /// An indicator starts at zero and seems to fall at once: either a shorter step shows it rise first, or it shows no
    /// change at all, or the step is so short that the event is now.
    fn leave_limit(&mut self, event: usize, h: f64, end: &[S; N]) -> Result<(), StepError> {
        let factor = if self.settings.is_adaptive() { 0.5 } else { 0.1 };
        if h * factor > 2.0 * smallest_step(self.time) {
            self.leaving = Some(event);
            return self.reject(h, factor, |run| Rejection::AtOnce(run.system.event_name(event)));
        }
        self.move_to(self.time + h, end, false, Some(event));
        self.reach(event)
    }

    /// The indicator that crosses zero first, its bracket within the step, and where it seems to cross; or one that is
    /// at zero from the start and nowhere positive.
    fn first_crossing(&self, h: f64, end: &[S; N], after: &H::Indicators<S>) -> Result<(usize, Bracket, f64), usize> {
        const EARLY: [f64; 6] = [1e-3, 0.0625, 0.125, 0.25, 0.5, 0.75];
        let end_time = self.time + h;
        let end_slope = self.system.derivatives(S::of(end_time), end, &self.inputs.at(end_time), &self.memory);
        let ends = [&self.x, &self.linearisation.derivatives, end, &end_slope].map(values);
        let [start, start_slope, end, end_slope] = &ends;
        let path = Hermite { start, start_slope, end, end_slope, h };
        let value_at = |event: usize, fraction: f64| {
            self.indicators_at(self.time + fraction * h, &numbers(&path.at(fraction))).as_ref()[event].value()
        };
        let mut first: Option<(usize, Bracket, f64)> = None;
        let indicators = self.indicators.as_ref().iter().zip(after.as_ref());
        for (event, [start, end]) in indicators.map(|(start, end)| [start.value(), end.value()]).enumerate() {
            if end >= 0.0 {
                continue;
            }
            let low = if start > 0.0 {
                (0.0, start)
            } else {
                // The trivial root at the start (the velocity after break-away) does not count.
                EARLY
                    .into_iter()
                    .map(|fraction| (fraction, value_at(event, fraction)))
                    .find(|(_, value)| *value > 0.0)
                    .ok_or(event)?
            };
            // One that is still positive where another is zero is not the first.
            if first.is_some_and(|(.., earliest)| value_at(event, earliest / h) > 0.0) {
                continue;
            }
            let bracket = Bracket::new(low, (1.0, end));
            let crossing = h * root(bracket, GUESS, |fraction| value_at(event, fraction));
            if first.is_none_or(|(.., earliest)| crossing < earliest) {
                first = Some((event, Bracket::new((low.0 * h, low.1), (h, end)), crossing));
            }
        }
        first.ok_or(0)
    }

    /// Narrows the bracket by steps of the scheme itself, until one ends near the event or just behind it.
    fn refine(&mut self, event: usize, mut bracket: Bracket, guess: f64, end: [S; N]) -> (f64, [S; N]) {
        let resolution = (bracket.end() * 1e-3 * self.settings.tolerance).max(smallest_step(self.time));
        let mut best = (bracket.end(), end);
        let mut at = guess;
        for _ in 0..MAX_REFINEMENTS {
            let Ok(end) = self.trial(at) else { break };
            self.attempts += 1;
            let value = self.indicators_at(self.time + at, &end).as_ref()[event].value();
            if let Some(found) = self.crossing_near_the_end(event, (at, value), &end, resolution) {
                return found;
            }
            bracket.narrow(at, value);
            if value <= 0.0 {
                best = (at, end);
            }
            if bracket.is_within(resolution) {
                break;
            }
            at = bracket.guess_behind(resolution);
        }
        best
    }

    /// Where an indicator crosses zero near the end of a step of a size in s, at which it has a value, and what a step to
    /// there leads to; `None` if it does not.
    fn crossing_near_the_end(
        &self,
        event: usize,
        (h, value): (f64, f64),
        end: &[S; N],
        resolution: f64,
    ) -> Option<(f64, [S; N])> {
        let (end_time, states) = (self.time + h, end);
        let [start, end] = [&self.x, end].map(values);
        let [start_slope, end_slope] = self.slopes(end_time, &end);
        let path = Hermite { start: &start, start_slope: &start_slope, end: &end, end_slope: &end_slope, h };
        let value_at = |at: f64| self.indicators_at(self.time + at, &numbers(&path.at(at / h))).as_ref()[event].value();
        let other = if value > 0.0 { h * (1.0 + NEAR) } else { h * (1.0 - NEAR) };
        let points = [(h, value), (other, value_at(other))];
        let [low, high] = if value > 0.0 { points } else { [points[1], points[0]] };
        if low.1 <= 0.0 || high.1 > 0.0 {
            return None;
        }
        let mut bracket = Bracket::new(low, high);
        while !bracket.is_within(resolution) {
            let at = bracket.guess_behind(resolution);
            bracket.narrow(at, value_at(at));
        }
        let at = bracket.end();
        let there = path.at(at / h);
        Some((at, array(|i| S::with(there[i], states[i].slopes()))))
    }

    /// Switches at an event, or pauses before it.
    pub(super) fn reach(&mut self, event: usize) -> Result<(), StepError> {
        if self.pauses {
            self.pending = Some(event);
            return Ok(());
        }
        self.switch(event)
    }

    pub(super) fn switch(&mut self, event: usize) -> Result<(), StepError> {
        self.last_event = Some(event);
        let u = self.inputs_now();
        self.system.switch(event, self.now(), &mut self.x, &u, &mut self.memory);
        self.counters.events += 1;
        if let Some(log) = &mut self.log {
            log.push((self.time, event));
        }
        (self.is_linearised, self.arrived_with) = (false, None);
        let outcome = self.settle();
        if S::VARIES {
            self.look_for_infinite_slopes(event);
            self.catch_up();
        }
        outcome
    }

    /// Lets the system switch until all indicators are valid.
    pub(super) fn settle(&mut self) -> Result<(), StepError> {
        let (now, u) = (self.now(), self.inputs_now());
        let before = self.counters.events;
        let (counters, log) = (&mut self.counters, &mut self.log);
        let indicators = settle(&self.system, now, &mut self.x, &u, &mut self.memory, |event| {
            counters.events += 1;
            if let Some(log) = log {
                log.push((self.time, event));
            }
        });
        if self.counters.events != before {
            (self.is_linearised, self.arrived_with) = (false, None);
        }
        self.indicators = indicators?;
        self.is_settled = true;
        Ok(())
    }
}

/// Switches until all indicators are valid, and returns them; tells the events that happen.
pub(super) fn settle<H: System<U>, S: Varying, const N: usize, const U: usize>(
    system: &H,
    now: S,
    x: &mut [S; N],
    u: &[S; U],
    memory: &mut H::Memory<S>,
    mut happened: impl FnMut(usize),
) -> Result<H::Indicators<S>, StepError> {
    let mut last = None;
    for _ in 0..MAX_SWITCHES {
        let indicators = system.indicators(now, x, u, memory);
        let Some(event) = indicators.as_ref().iter().position(|indicator| indicator.value() < 0.0) else {
            return Ok(indicators);
        };
        system.switch(event, now, x, u, memory);
        happened(event);
        last = Some(event);
    }
    let event = last.map_or("", |event| system.event_name(event));
    Err(StepError::Chattering { time: now.value(), event, variant: system.variant() })
}
