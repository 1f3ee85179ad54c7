//! One step: tried, judged, accepted or repeated with another size.

use super::kink::Kink;
use super::{MAX_STEP, Run, smallest_step};
use crate::numbers::{Dual, Scalar, Varying};
use crate::solver::error::{Rejection, StateAtStart, StepError};
use crate::solver::event::Hermite;
use crate::solver::relaxing::Relaxing;
use crate::solver::runge_kutta::{Explicit, Stages};
use crate::solver::trial::Trial;
use crate::solver::{array, implicit_euler, numbers, rosenbrock, runge_kutta, values};
use crate::system::{Scheme, System, state_name};

const SAFETY: f64 = 0.9;
/// Tolerance from which on the midpoint rule may take steps.
const LOOSE: f64 = 1e-4;
/// Fraction of the tolerance that an explicit step across a kink may use up.
const KINK_SHARE: f64 = 0.1;
/// Share of the difference from the midpoint rule that counts as error, where the estimate of the explicit method is too
/// small.
const DEFECT_SHARE: f64 = 0.3;
const MAX_GROWTH: f64 = 5.0;
const MAX_SHRINKAGE: f64 = 0.1;
/// Multiple of its scale that no state exceeds unless the scheme diverges.
const FAR_OUT: f64 = 1e9;

/// Why a step leads nowhere.
#[derive(Clone, Copy, Debug)]
pub(super) enum Nonsense {
    /// Its equations have no solution.
    Unsolvable,
    /// A state, by its index, is out of all bounds or no number.
    Unbounded(usize),
    /// The system gives a reason.
    Meaningless(&'static str),
}

impl<H: System<U>, const N: usize, const U: usize, S: Varying> Run<H, N, U, S> {
    /// Tries one step that ends no later than `limit`; accepts it, ends it at an event, or reduces the step size.
    // A function of its own: inlined, it would be optimised once more with each caller.
    #[inline(never)]
    pub(super) fn attempt(&mut self, limit: f64) -> Result<(), StepError> {
        let remaining = limit - self.time;
        self.choose(remaining);
        self.linearise();
        // A step slightly too short is stretched, and two equal steps are better than one long and one tiny; but one that is
        // to end on a kink has the right size.
        let h = if self.step >= remaining {
            remaining
        } else if self.beyond > 0.0 {
            self.step
        } else if self.is_midpoint || self.step * 1.1 >= remaining {
            remaining
        } else if self.step * 2.0 > remaining && self.settings.is_adaptive() {
            0.5 * remaining
        } else {
            self.step
        };
        let end_time = if h == remaining { limit } else { self.time + h };
        let end = match self.trial(h) {
            Ok(end) => end,
            Err(nonsense) => return self.reject_nonsense(h, nonsense),
        };
        let mut error = self.error_norm(&end, &self.error);
        if self.is_explicit && self.hints.is_fast {
            error = error.max(DEFECT_SHARE * self.error_norm(&end, &self.defect));
        }
        if error > 1.0 {
            let kink = self.kink(h, end_time, &end).filter(Kink::is_well_within);
            let factor = match kink {
                Some(kink) => self.go_for(kink, h),
                None if self.is_midpoint => return self.give_up_midpoint(h, error),
                None => (SAFETY / fourth_root(error)).max(MAX_SHRINKAGE),
            };
            return self.reject(h, factor, |run| Rejection::Inaccurate(run.least_accurate(&end, &run.error)));
        }
        if self.is_explicit
            && let Some(kink) = self.kink(h, end_time, &end)
        {
            let share = self.error_norm(&end, &self.defect) * kink.weight() / KINK_SHARE;
            if share > 1.0 {
                if self.is_midpoint && !kink.is_well_within() {
                    return self.give_up_midpoint(h, share);
                }
                let factor = self.go_for(kink, h);
                let reason = |run: &Self| Rejection::Inaccurate(run.least_accurate(&end, &run.defect));
                return self.reject(h, factor, reason);
            }
        }
        if self.system.has_events() {
            let after = self.indicators_at(end_time, &end);
            if after.as_ref().iter().any(|indicator| indicator.value() < 0.0) {
                return self.step_to_event(h, &end, &after);
            }
            // Within the resolution of the clock the dip would be one of rounding.
            if h > 4.0 * smallest_step(self.time) && self.dips_between(h, &end) {
                return self.reject(h, 0.5, |_| Rejection::Passed);
            }
            if let Some(event) = self.leaving.filter(|event| after.as_ref()[*event].value() == 0.0) {
                // The indicator has not left zero, and is negative a little later: but for rounding the event is now.
                self.accept(h, end_time, &end, error, Some(event));
                return self.reach(event);
            }
            self.indicators = after;
        }
        self.accept(h, end_time, &end, error, None);
        if end_time == limit {
            self.choice.arrive();
        }
        Ok(())
    }

    /// Chooses the method of the next step of the adaptive scheme.
    fn choose(&mut self, remaining: f64) {
        let before = self.is_explicit;
        self.hints = self.system.hints(&self.x, &self.memory);
        let explicit = self.hints.explicit.filter(|_| self.settings.is_adaptive());
        self.is_explicit = explicit.is_some();
        let was_midpoint = std::mem::replace(&mut self.is_midpoint, false);
        if let Some(longest) = explicit {
            if self.settings.tolerance >= LOOSE {
                // The way to a kink is left to the method that has met it.
                self.is_midpoint = if self.beyond > 0.0 {
                    was_midpoint && self.choice.tries_midpoint(self.step, longest.midpoint)
                } else {
                    self.choice.tries_midpoint(remaining, longest.midpoint)
                };
            }
            if !self.is_midpoint {
                self.step = self.choice.choose(self.step, remaining, longest.classical, self.hints.is_chain);
                self.is_explicit = !self.choice.is_implicit();
            }
        }
        self.is_linearised &= self.is_explicit == before;
    }

    fn linearise(&mut self) {
        if self.is_linearised {
            return;
        }
        let (u, is_explicit) = (self.inputs.at(self.time), self.is_explicit);
        let here = &mut self.linearisation;
        if self.settings.is_adaptive() && !is_explicit {
            let (x, u) = (values(&self.x), values(&u));
            let rates = self.system.jacobian(self.time, &x, &u, &self.memory, &mut here.jacobian.data.0);
            here.derivatives = if S::VARIES {
                self.system.derivatives(S::of(self.time), &self.x, &self.inputs.at(self.time), &self.memory)
            } else {
                numbers(&rates)
            };
            self.counters.jacobians += 1;
            self.linearisation.time_slopes =
                (self.inputs.vary() || self.system.depends_on_time()).then(|| self.time_slopes(self.time, &self.x, &u));
        } else {
            let (x, memory) = (&self.x, &self.memory);
            let before = self.arrived_with.take();
            if !before
                .is_some_and(|before| self.system.update_derivatives(x, [&before, &u], memory, &mut here.derivatives))
            {
                here.derivatives = self.system.derivatives(S::of(self.time), x, &u, memory);
            }
        }
        (self.is_linearised, self.arrived_with) = (true, None);
    }

    /// Partial derivatives of the states' rates with respect to time, under inputs that vary with it.
    pub(super) fn time_slopes(&self, time: f64, x: &[S; N], u: &[f64; U]) -> [f64; N] {
        let mut inputs = [Dual::<1, S>::of(0.0); U];
        let x: [Dual<1, S>; N] = array(|i| Dual::of(x[i].value()));
        for (number, (value, slope)) in inputs.iter_mut().zip(u.iter().zip(self.inputs.slopes())) {
            *number = Dual::new(*value, [slope]);
        }
        let rates = self.system.derivatives(Dual::variable(time, 0), &x, &inputs, &self.memory);
        array(|i| rates[i].slope[0])
    }

    /// The step of size `h` from here, if it leads to states that have a meaning.
    pub(super) fn trial(&mut self, h: f64) -> Result<[S; N], Nonsense> {
        let (system, time, x, inputs, memory) = (&self.system, self.time, &self.x, &self.inputs, &self.memory);
        let here = &self.linearisation;
        let Trial { end, error } = match self.settings.scheme {
            Scheme::Adaptive if self.is_explicit => {
                let u = inputs.at(time);
                let place = self.relaxing();
                let rate = || system.relaxation_rate(S::of(time), x, &here.derivatives, &u, memory);
                let relaxing = place.and_then(|_| Relaxing::new(rate(), h));
                let relaxing = place.zip(relaxing.as_ref());
                let (first, is_midpoint) = (&here.derivatives, self.is_midpoint);
                let stages = Stages { system, time, x, inputs, memory, first, h, closed_form: None, relaxing };
                let Explicit { trial, slope, defect } = if H::CLOSED_FORM > 0 && !inputs.vary() {
                    let stride = self.strides.of(h, |size| system.stride(size));
                    let closed_form = system.closed_form(x, &u, memory, &stride);
                    Stages { closed_form: Some(&closed_form), ..stages }.taken(is_midpoint)
                } else {
                    stages.taken(is_midpoint)
                };
                (self.end_slope, self.defect) = (slope, self.of_motion(defect));
                trial
            }
            Scheme::Adaptive => {
                rosenbrock::step(system, time, x, inputs, memory, here, h).ok_or(Nonsense::Unsolvable)?
            }
            Scheme::ImplicitEuler => {
                let jacobians = &mut self.counters.jacobians;
                implicit_euler::step(system, time, x, inputs, memory, h, jacobians).ok_or(Nonsense::Unsolvable)?
            }
            Scheme::ExplicitEuler => {
                runge_kutta::EXPLICIT_EULER.step(system, time, x, inputs, memory, &here.derivatives, h)
            }
            Scheme::RK3 => runge_kutta::RK3.step(system, time, x, inputs, memory, &here.derivatives, h),
            Scheme::RK4 => runge_kutta::RK4.step(system, time, x, inputs, memory, &here.derivatives, h),
        };
        let there = values(&end);
        let is_bounded: [bool; N] = std::array::from_fn(|i| there[i].abs() <= FAR_OUT * self.scales[i]);
        // All at once, since as a rule nothing is out of bounds.
        if !is_bounded.iter().fold(true, |all, state| all & state) {
            return Err(Nonsense::Unbounded(is_bounded.iter().position(|state| !state).unwrap_or_default()));
        }
        self.system.admit(&there).map_err(Nonsense::Meaningless)?;
        self.error = self.of_motion(error);
        Ok(end)
    }

    /// Errors of the states that act on others: one that counts alone must not change the steps.
    #[inline(always)]
    fn of_motion(&self, mut errors: [S; N]) -> [S; N] {
        if let Some(counting) = self.system.counting(N) {
            errors[counting] = S::zero();
        }
        errors
    }

    /// The largest error of a state at the end of a step relative to the tolerance.
    fn error_norm(&self, end: &[S; N], errors: &[S; N]) -> f64 {
        // One instruction, where `f64::max` needs several to tell a missing number.
        let larger = |a: f64, b: f64| if a < b { b } else { a };
        // All states side by side, then the largest.
        let relative: [f64; N] = array(|i| {
            errors[i].value().abs() / larger(larger(self.scales[i], self.x[i].value().abs()), end[i].value().abs())
        });
        relative.into_iter().fold(0.0, larger) / self.settings.tolerance
    }

    /// The state whose error is largest.
    fn least_accurate(&self, end: &[S; N], errors: &[S; N]) -> StateAtStart {
        let magnitude = |i: usize| self.scales[i].max(self.x[i].value().abs()).max(end[i].value().abs());
        let relative = |i: usize| errors[i].value().abs() / magnitude(i);
        self.state_at_start((0..N).max_by(|a, b| relative(*a).total_cmp(&relative(*b))).unwrap_or_default())
    }

    /// A state at the start of the step.
    fn state_at_start(&self, state: usize) -> StateAtStart {
        let [value, rate] = [self.x[state], self.linearisation.derivatives[state]].map(S::value);
        StateAtStart { name: state_name(&self.system, state, N), value, rate }
    }

    /// Leaves a step of a size in s, whose error is too large by a factor, to the classical method.
    #[cold]
    fn give_up_midpoint(&mut self, h: f64, error: f64) -> Result<(), StepError> {
        self.counters.rejected += 1;
        self.choice.limit_midpoint(h * SAFETY / error.sqrt());
        Ok(())
    }

    /// A step that leads nowhere: a shorter one may not, unless the scheme has a fixed step and is explicit.
    #[cold]
    fn reject_nonsense(&mut self, h: f64, nonsense: Nonsense) -> Result<(), StepError> {
        let reason = |run: &Self| match nonsense {
            Nonsense::Unsolvable => Rejection::Unsolvable,
            Nonsense::Unbounded(state) => {
                Rejection::Unbounded { state: run.state_at_start(state), limit: FAR_OUT * run.scales[state] }
            }
            Nonsense::Meaningless(reason) => Rejection::Meaningless(reason),
        };
        if matches!(self.settings.scheme, Scheme::ExplicitEuler | Scheme::RK3 | Scheme::RK4) {
            self.counters.rejected += 1;
            return Err(StepError::Diverged { time: self.time, step: self.settings.step, reason: reason(self) });
        }
        self.reject(h, 0.25, reason)
    }

    /// Goes on with a step that is smaller by a factor, if the clock resolves it.
    #[cold]
    pub(super) fn reject(
        &mut self,
        h: f64,
        factor: f64,
        reason: impl FnOnce(&Self) -> Rejection,
    ) -> Result<(), StepError> {
        self.counters.rejected += 1;
        let step = h * factor;
        // Where the clock is coarser than the longest step, `h` is 0: the step size to save must stay positive.
        if step < smallest_step(self.time) {
            let (reason, variant) = (reason(self), self.system.variant());
            return Err(StepError::StepSizeTooSmall { time: self.time, reason, variant });
        }
        if self.is_midpoint && self.beyond == 0.0 {
            self.choice.limit_midpoint(step);
        }
        self.step = step;
        Ok(())
    }

    fn accept(&mut self, h: f64, end_time: f64, end: &[S; N], error: f64, event: Option<usize>) {
        let beyond = self.beyond;
        let varied = self.refined(h, end_time, end);
        self.move_to(end_time, varied.as_ref().unwrap_or(end), self.is_explicit && !self.inputs.vary(), event);
        self.step = if self.is_midpoint {
            // The classical method has another step size.
            self.step.max(beyond)
        } else if self.settings.is_adaptive() {
            let growth = SAFETY / fourth_root(error.max(1e-8));
            let most = (h * MAX_GROWTH).max(beyond.min(h * growth));
            if growth >= MAX_GROWTH { self.step.max(most) } else { h * growth }.min(MAX_STEP)
        } else {
            self.settings.step
        };
    }

    /// Goes to the end of a step, whose slope there may be known, and which may be at an event.
    pub(super) fn move_to(&mut self, time: f64, end: &[S; N], knows_slope: bool, event: Option<usize>) {
        if self.settings.keeps_balance {
            self.keep_balance(time, end);
        }
        self.time = time;
        self.x = *end;
        self.counters.steps += 1;
        #[cfg(feature = "sensitivities")]
        if let Some(trail) = &mut self.trail {
            trail.pass(time, values(end));
        }
        if knows_slope {
            self.linearisation.derivatives = self.end_slope;
        }
        (self.is_linearised, self.arrived_with) = (false, knows_slope.then(|| self.inputs.at(time)));
        (self.leaving, self.beyond) = (None, 0.0);
        if S::VARIES {
            for (peaks, state) in self.peaks.iter_mut().zip(end) {
                peaks.iter_mut().zip(state.slopes()).for_each(|(peak, slope)| *peak = peak.max(slope.abs()));
            }
        }
        if S::VARIES
            && let Some(event) = event
        {
            self.cross(event);
        }
        self.follow();
    }

    // Few runs keep one.
    #[inline(never)]
    fn keep_balance(&mut self, end_time: f64, end: &[S; N]) {
        let end_slope = self.system.derivatives(S::of(end_time), end, &self.inputs.at(end_time), &self.memory);
        let start_slope = &values(&self.linearisation.derivatives);
        let [start, end, end_slope] = [&self.x, end, &end_slope].map(values);
        let h = end_time - self.time;
        let path = Hermite { start: &start, start_slope, end: &end, end_slope: &end_slope, h };
        self.balance.add(&self.system, &self.inputs, &self.memory, self.time, &path);
    }
}

/// The fourth root, by correctly rounded square roots so that it has the same bits everywhere.
pub(super) fn fourth_root(value: f64) -> f64 {
    value.sqrt().sqrt()
}
