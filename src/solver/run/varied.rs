//! Runs in numbers with slopes: how later instants of events and kinks within steps act on them.
//!
//! The steps of such a run are those of a plain one, with the same bits, and its slopes are those of the scheme with all adaptive
//! choices held (internal numerical differentiation; Bock, 1981). At an event with the indicator `g`, at rates `f-` before and `f+`
//! behind it, with the change `switch` (the saltation rule):
//!
//! ```text
//! tau = -g'/gdot,   x+ = switch(x- + f-*tau, t + tau) - f+*tau
//! ```
//!
//! The step control sees values alone. Where a direction sets off what the run does not, a spool that jumps for example, slopes are
//! taken in parts of the step.

use nalgebra::SMatrix;

use super::Run;
use crate::numbers::Varying;
use crate::solver::event::Hermite;
use crate::solver::relaxing::Relaxing;
use crate::solver::runge_kutta::Stages;
use crate::solver::trial::{Linearisation, Trial};
use crate::solver::{array, numbers, rosenbrock, values};
use crate::system::{Indicator, System};

/// Rate in 1/s of an indicator, relative to its nominal value, below which the motion grazes its limit.
const GRAZING: f64 = 1e-7;
/// Distance from its limit, relative to its nominal value, at which an indicator is at it.
const AT_LIMIT: f64 = 1e-10;
/// Distances from a state, relative to its scale, at which slopes by it are compared, and by how much they grow from one to the next
/// where a motion may leave that state in many ways: with a rate that grows as the root of the distance it is 32, and with one that
/// grows as its power 0.6, where the way is the only one, 16.
const NEARER: [f64; 3] = [1e-7, 1e-10, 1e-13];
const STEEPER: f64 = 24.0;
/// The smallest tolerance of slopes.
const SHARPEST: f64 = 1e-10;
/// The same of implicit steps, whose second derivatives come from differences.
const SHARPEST_IMPLICIT: f64 = 1e-7;
/// Slopes below this multiple of the scale of a state, per unit of the direction, do not count.
const NEGLIGIBLE: f64 = 1e-3;
/// The smallest part of a step that slopes ask for, and that beside a kink, behind which a stage may look.
const SMALLEST_PIECE: f64 = 1e-4;
const SMALLEST_BESIDE_KINK: f64 = 1e-9;
/// Largest number of separate kinks within a step.
const MOST_KINKS: usize = 4;

/// An event that a run in numbers with slopes has come through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Time in s since the start of the run.
    pub time: f64,
    /// The place of its indicator.
    pub event: usize,
    /// The rate of its indicator, in its own unit per s: negative.
    pub rate: f64,
    /// How much later it happens, in s per unit of the direction.
    pub delay: f64,
}

/// A point from which on a run has no derivative.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// Time in s since the start of the run.
    pub time: f64,
    /// The place of the indicator of the event.
    pub event: usize,
    /// Why.
    pub reason: String,
}

impl<H: System<U>, const N: usize, const U: usize, S: Varying> Run<H, N, U, S> {
    /// The events so far.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings
    }

    /// Where the slopes have been lost, if they have.
    pub fn lost(&self) -> Option<&Lost> {
        self.lost.as_ref()
    }

    /// The present time, which may be that of an event.
    #[inline(always)]
    pub(super) fn now(&self) -> S {
        S::with(self.time, self.late)
    }

    /// The inputs at that time.
    #[inline(always)]
    pub(super) fn inputs_now(&self) -> [S; U] {
        let mut u = self.inputs.at(self.time);
        if S::VARIES && self.late != 0.0 {
            for (input, slope) in u.iter_mut().zip(self.inputs.slopes()) {
                *input = S::with(input.value(), input.slope() + slope * self.late);
            }
        }
        u
    }

    /// Comes to an event, whose instant moves along with the direction.
    #[cold]
    pub(super) fn cross(&mut self, event: usize) {
        let indicator =
            |time: S, x: &[S; N], u: &[S; U]| self.system.indicators(time, x, u, &self.memory).as_ref()[event].slope();
        let (time, u) = (self.time, self.inputs.at(self.time));
        let rates = self.system.derivatives(S::of(time), &self.x, &u, &self.memory);
        let flow = array(|i| S::with(self.x[i].value(), rates[i].value()));
        let still = array(|i| S::of(self.x[i].value()));
        let (mut flowing, standing) = (u.map(|it| S::of(it.value())), u.map(|it| S::of(it.value())));
        flowing.iter_mut().zip(self.inputs.slopes()).for_each(|(input, slope)| *input = S::with(input.value(), slope));
        // Parameters and the memory, which vary in both, leave the difference to the motion.
        let fall = indicator(S::with(time, 1.0), &flow, &flowing) - indicator(S::of(time), &still, &standing);
        let change = indicator(S::of(time), &self.x, &u);
        let nominal = nominal::<H, U>;
        let indicators = self.system.indicators(S::of(time), &self.x, &u, &self.memory);
        let is_at_limit =
            |other: &usize| *other != event && indicators.as_ref()[*other].value() <= AT_LIMIT * nominal(*other);
        let coincident = (0..indicators.as_ref().len()).find(is_at_limit);
        self.held = array(|i| rates[i].value() == 0.0);
        let grazes = fall.is_nan() || fall > -GRAZING * nominal(event);
        if (grazes || coincident.is_some()) && (change != 0.0 || fall.is_nan()) {
            if self.lost.is_none() {
                let reason = match coincident {
                    Some(other) if !grazes => format!("{} happens at the same instant", self.system.event_name(other)),
                    _ => format!("the motion only grazes its limit, at {fall:e} of its unit per second"),
                };
                self.lost = Some(Lost { time, event, reason });
            }
            self.crossings.push(Crossing { time, event, rate: f64::NAN, delay: f64::NAN });
            return;
        }
        let delay = -change / fall;
        self.crossings.push(Crossing { time, event, rate: fall, delay });
        self.postpone(delay);
    }

    /// Finds an event that inputs which have jumped bring exactly to its limit: more of the direction lets it happen, or less.
    pub(super) fn look_for_limits(&mut self) {
        let indicators = self.indicators();
        let is_tied = |it: &S| it.value() == 0.0 && it.slope() != 0.0;
        if self.lost.is_none()
            && let Some(event) = indicators.as_ref().iter().position(is_tied)
        {
            let reason = "an input brings it exactly to its limit".to_owned();
            self.lost = Some(Lost { time: self.time, event, reason });
        }
    }

    /// Finds a state that was held before an event and by which the rates have an infinite slope behind it: these grow and grow,
    /// the nearer one comes, and the equations do not tell how the motion leaves it.
    #[cold]
    pub(super) fn look_for_infinite_slopes(&mut self, event: usize) {
        let u = self.inputs.at(self.time).map(|it| S::of(it.value()));
        let slopes_by = |state: usize, share: f64| -> [S; N] {
            let mut x: [S; N] = array(|i| S::of(self.x[i].value()));
            x[state] = S::with(x[state].value() + share * self.scales[state], 1.0);
            self.system.derivatives(S::of(self.time), &x, &u, &self.memory)
        };
        let still =
            |rates: [S; N], base: &[S; N]| -> [f64; N] { array(|i| (rates[i].slope() - base[i].slope()).abs()) };
        let is_steep = |state: usize| {
            // Parameters and the memory vary, too.
            let x: [S; N] = array(|i| S::of(self.x[i].value()));
            let base = self.system.derivatives(S::of(self.time), &x, &u, &self.memory);
            let columns = NEARER.map(|share| still(slopes_by(state, share), &base));
            (0..N).any(|row| columns.windows(2).all(|two| two[1][row] > STEEPER * two[0][row]))
        };
        if self.lost.is_none() && (0..N).any(|state| self.held[state] && is_steep(state)) {
            let reason = "behind it rates have an infinite slope by a state that was held".to_owned();
            self.lost = Some(Lost { time: self.time, event, reason });
        }
        self.held = [false; N];
    }

    /// Goes on to an instant that is later by a delay of the value 0.
    pub(super) fn postpone(&mut self, delay: f64) {
        if S::VARIES && delay != 0.0 {
            self.late = delay;
            self.shift(delay);
        }
    }

    /// Goes back from the instant of an event to the present time, behind the event.
    pub(super) fn catch_up(&mut self) {
        if S::VARIES && self.late != 0.0 {
            let delay = std::mem::replace(&mut self.late, 0.0);
            self.shift(-delay);
        }
    }

    /// Follows the motion by a delay of the value 0.
    #[cold]
    fn shift(&mut self, delay: f64) {
        let rates = self.system.derivatives(S::of(self.time), &self.x, &self.inputs.at(self.time), &self.memory);
        for (state, rate) in self.x.iter_mut().zip(rates) {
            *state = S::with(state.value(), state.slope() + rate.value() * delay);
        }
    }

    /// The states at the end of a step with slopes that are accurate, where those of the step are not: the step control has
    /// seen values alone, and within a smooth piece slopes have the order of the method. Nothing where they are.
    #[inline(always)]
    pub(super) fn refined(&mut self, h: f64, end_time: f64, end: &[S; N]) -> Option<[S; N]> {
        if !S::VARIES || !self.settings.is_adaptive() {
            return None;
        }
        let is_accurate = self.inaccuracy(&self.x, end, &self.error) <= 1.0;
        if is_accurate && self.kink(h, end_time, end).is_none() {
            return None;
        }
        self.in_pieces(h, end_time, end, false)
    }

    /// The states at an event at the end of a step of a size in s, with the slopes there: those of the trial steps that have located
    /// the event are of other instants, or of stages that look behind it.
    #[cold]
    pub(super) fn at_event(&mut self, h: f64, end: [S; N]) -> [S; N] {
        let end_time = self.time + h;
        let slopes =
            if self.settings.is_adaptive() { self.in_pieces(h, end_time, &end, true) } else { self.trial(h).ok() };
        slopes.map_or(end, |slopes| array(|i| S::with(end[i].value(), slopes[i].slope())))
    }

    /// The largest error of a slope in a step relative to what is allowed.
    fn inaccuracy(&self, start: &[S; N], end: &[S; N], errors: &[S; N]) -> f64 {
        let relative = |i: usize| {
            let largest = self.peaks[i].max(start[i].slope().abs()).max(end[i].slope().abs());
            errors[i].slope().abs() / largest.max(NEGLIGIBLE * self.scales[i])
        };
        (0..N).map(relative).fold(0.0, f64::max)
            / self.settings.tolerance.max(if self.is_explicit { SHARPEST } else { SHARPEST_IMPLICIT })
    }

    /// The states at the end of a step in smooth pieces; at the end may be an event, with a kink beside it.
    #[cold]
    fn in_pieces(&mut self, h: f64, end_time: f64, end: &[S; N], ends_on_event: bool) -> Option<[S; N]> {
        let ended = values(end);
        let [start_slope, end_slope] = self.slopes(end_time, &ended);
        let start = values(&self.x);
        let path = Hermite { start: &start, start_slope: &start_slope, end: &ended, end_slope: &end_slope, h };
        let is_behind_event = self.crossings.last().is_some_and(|crossing| crossing.time == self.time);
        let (mut x, mut from) = (self.x, 0.0);
        for piece in 0..=MOST_KINKS {
            let to = if piece < MOST_KINKS { self.first_kink_behind(&path, from).unwrap_or(1.0) } else { 1.0 };
            let beside = [from > 0.0 || is_behind_event, to < 1.0 || ends_on_event];
            // The step as a whole has been tried.
            let is_tried = to - from == 1.0 && !ends_on_event;
            let reached = self.smooth_piece(&path, [from, to], beside, &x, is_tried)?;
            // Behind a kink the equations are those of its other side.
            let there = if to < 1.0 { self.between(&path, to) } else { ended };
            x = array(|i| S::with(there[i], reached[i].slope()));
            from = to;
            if to >= 1.0 {
                break;
            }
        }
        self.end_slope = self.system.derivatives(S::of(end_time), &x, &self.inputs.at(end_time), &self.memory);
        Some(x)
    }

    /// The states at the end of a smooth piece of a step, which may begin or end on a kink, in halves of halves where slopes ask
    /// for it, or where the piece has been tried as a whole.
    fn smooth_piece(
        &self,
        path: &Hermite<N>,
        [from, to]: [f64; 2],
        [after_kink, before_kink]: [bool; 2],
        x: &[S; N],
        is_tried: bool,
    ) -> Option<[S; N]> {
        if !is_tried {
            let Trial { end, error } = self.piece(self.time + from * path.h, x, (to - from) * path.h)?;
            let smallest = if after_kink || before_kink { SMALLEST_BESIDE_KINK } else { SMALLEST_PIECE };
            let is_halved = to - from > smallest && self.inaccuracy(x, &end, &error) > 1.0;
            if !is_halved {
                return Some(end);
            }
        }
        let middle = 0.5 * (from + to);
        let half = self.smooth_piece(path, [from, middle], [after_kink, false], x, false)?;
        self.smooth_piece(path, [middle, to], [false, before_kink], &half, false)
    }

    /// The states within a step: on the cubic between its ends, but for those with a closed form.
    pub(super) fn between(&self, path: &Hermite<N>, fraction: f64) -> [f64; N] {
        let mut x = path.at(fraction);
        if H::LED > 0 && !self.inputs.vary() {
            let (start, u) = (numbers(path.start), self.inputs.at(self.time));
            let led = self.system.led(&start, &u, &self.memory, &self.system.stride(fraction * path.h));
            x.iter_mut().zip(led.end).take(H::LED).for_each(|(state, led)| *state = led.value());
        }
        x
    }

    /// The states after a piece of a step of a size in s; nothing if it leads nowhere.
    fn piece(&self, time: f64, x: &[S; N], size: f64) -> Option<Trial<N, S>> {
        let (system, memory, inputs) = (&self.system, &self.memory, &self.inputs);
        let u = inputs.at(time);
        let first = system.derivatives(S::of(time), x, &u, memory);
        if !self.is_explicit {
            let mut here = Linearisation { derivatives: first, jacobian: SMatrix::zeros(), time_slopes: None };
            let plain = values(&u);
            system.jacobian(time, &values(x), &plain, memory, &mut here.jacobian.data.0);
            if inputs.vary() || system.depends_on_time() {
                here.time_slopes = Some(self.time_slopes(time, x, &plain));
            }
            return rosenbrock::step(system, time, x, inputs, memory, &here, size);
        }
        let rate = || system.relaxation(S::of(time), x, &first, &u, memory);
        let relaxing = Self::RELAXING.and_then(|_| Relaxing::new(rate(), size));
        let led = (H::LED > 0 && !inputs.vary()).then(|| system.led(x, &u, memory, &system.stride(size)));
        let (led, relaxing) = (led.as_ref(), Self::RELAXING.zip(relaxing.as_ref()));
        Some(Stages { system, time, x, inputs, memory, first: &first, h: size, led, relaxing }.classical().trial)
    }
}

/// The magnitude of an indicator.
fn nominal<H: System<U>, const U: usize>(event: usize) -> f64 {
    H::indicator_list().get(event).map_or(1.0, |indicator: &Indicator| indicator.nominal)
}
