//! Runs in numbers with slopes: the effect on the slopes of event instants, and of non-smooth points within steps.
//!
//! The steps of such a run are the steps of a plain run, with the same bits; its slopes are derivatives of the scheme with all adaptive
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
use super::step::fourth_root;
use crate::numbers::{DIRECTIONS, STILL, Slopes, Varying, first};
use crate::solver::event::Hermite;
use crate::solver::relaxing::Relaxing;
use crate::solver::runge_kutta::{Explicit, Stages};
use crate::solver::trial::{Linearisation, Trial};
use crate::solver::{array, numbers, rosenbrock, values};
use crate::system::{Sample, System};

/// Rate in 1/s of an indicator, relative to its nominal value, below which the motion grazes its limit.
const GRAZING: f64 = 1e-7;
/// Distance from its limit, relative to its nominal value, at which an indicator is at it.
const AT_LIMIT: f64 = 1e-10;
/// Distances from a state, relative to its scale, at which slopes by it are compared, and by how much they grow from one to the next
/// where a motion may leave that state in many ways: with a rate that grows as the root of the distance it is 32, and with one that
/// grows as its power 0.6, where the way is the only one, 16.
const NEARER: [f64; 3] = [1e-7, 1e-10, 1e-13];
const STEEPER: f64 = 24.0;
/// The same where a motion passes that state: the way is the only one, but slopes behind a rate that grows as a power below 0.8 of the
/// distance would be inaccurate (by 20 % at 0.7).
const STEEPER_IN_PASSING: f64 = 3.5;
/// The smallest tolerance of slopes.
const SHARPEST: f64 = 1e-10;
/// The same of implicit steps, whose second derivatives come from differences.
const SHARPEST_IMPLICIT: f64 = 1e-7;
/// The tolerance of slopes that carry the covariance of a filter along, which is known no better.
const OF_A_FILTER: f64 = 1e-4;
/// Slopes below this multiple of the scale of a state, per unit of the direction, do not count.
const NEGLIGIBLE: f64 = 1e-3;
/// The smallest part of a step that slopes ask for, and that beside a kink, behind which a stage may look.
const SMALLEST_PIECE: f64 = 1e-4;
const SMALLEST_BESIDE_KINK: f64 = 1e-9;
/// The most parts of a step that slopes ask for at once, and a margin for their number.
const MOST_PARTS: f64 = 16.0;
const MARGIN: f64 = 1.1;
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
    /// Derivatives of its time, in s per unit of each direction.
    pub delays: Slopes,
}

/// Time in s, states and memory before a sample.
pub(super) struct Passed<M, const N: usize, S> {
    time: f64,
    x: [S; N],
    memory: M,
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

    /// Where the slopes in a direction have been lost, if they have.
    pub fn lost(&self, direction: usize) -> Option<&Lost> {
        self.lost[direction].as_ref()
    }

    /// Loses slopes without a word from here on, and is content with those of a filter: steps do not allocate.
    pub fn be_silent(&mut self) {
        self.is_silent = true;
        self.crossings = Vec::with_capacity(1);
    }

    /// Whether slopes are lost without a word.
    pub fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// Notes that slopes in some of the directions are lost, of those that have not been lost before.
    fn lose(&mut self, event: usize, reason: &str, is_lost: impl Fn(usize) -> bool) {
        let reason = if self.is_silent { "" } else { reason };
        for (direction, lost) in self.lost.iter_mut().enumerate() {
            if lost.is_none() && is_lost(direction) {
                *lost = Some(Lost { time: self.time, event, reason: reason.to_owned() });
            }
        }
    }

    /// The present time, with slopes at an event whose instant varies.
    #[inline(always)]
    pub(super) fn now(&self) -> S {
        S::with(self.time, self.late)
    }

    /// The inputs at that time.
    #[inline(always)]
    pub(super) fn inputs_now(&self) -> [S; U] {
        let mut u = self.inputs.at(self.time);
        if S::VARIES && self.late != STILL {
            for (input, slope) in u.iter_mut().zip(self.inputs.slopes()) {
                *input = S::with(input.value(), moved(input.slopes(), slope, &self.late));
            }
        }
        u
    }

    /// Comes to an event, whose instant moves along with the directions.
    #[cold]
    pub(super) fn cross(&mut self, event: usize) {
        let indicator =
            |time: S, x: &[S; N], u: &[S; U]| self.system.indicators(time, x, u, &self.memory).as_ref()[event].slopes();
        let (time, u) = (self.time, self.inputs.at(self.time));
        let rates = self.system.derivatives(S::of(time), &self.x, &u, &self.memory);
        // Time takes the first direction.
        let flow = array(|i| S::with(self.x[i].value(), first(rates[i].value())));
        let still = array(|i| S::of(self.x[i].value()));
        let (mut flowing, standing) = (u.map(|it| S::of(it.value())), u.map(|it| S::of(it.value())));
        flowing
            .iter_mut()
            .zip(self.inputs.slopes())
            .for_each(|(input, slope)| *input = S::with(input.value(), first(slope)));
        // Parameters and the memory, which vary in both, leave the difference to the motion.
        let [flowing, standing] =
            [indicator(S::with(time, first(1.0)), &flow, &flowing), indicator(S::of(time), &still, &standing)];
        let fall = flowing[0] - standing[0];
        let changes = indicator(S::of(time), &self.x, &u);
        let nominal = |event: usize| self.nominals.get(event).copied().unwrap_or(1.0);
        let indicators = self.system.indicators(S::of(time), &self.x, &u, &self.memory);
        let is_at_limit = |other: &usize| {
            let is_near = indicators.as_ref()[*other].value() <= AT_LIMIT * nominal(*other);
            is_near && *other != event && !self.system.is_kink(*other)
        };
        let coincident = (0..indicators.as_ref().len()).find(is_at_limit);
        self.held = array(|i| rates[i].value() == 0.0);
        let grazes = fall.is_nan() || fall > -GRAZING * nominal(event);
        // At a kink states and rates are the same whenever it is passed.
        let has_no_time = grazes && self.system.is_kink(event);
        let is_unclear = (grazes && !has_no_time) || coincident.is_some();
        let is_lost = changes.map(|change| is_unclear && (change != 0.0 || fall.is_nan()));
        if is_lost.contains(&true) {
            let reason = match coincident {
                _ if self.is_silent => String::new(),
                Some(other) if !grazes => format!("{} happens at the same instant", self.system.event_name(other)),
                _ => format!("the motion only grazes its limit, at {fall:e} of its unit per second"),
            };
            self.lose(event, &reason, |direction| is_lost[direction]);
        }
        let delay =
            |direction: usize| if has_no_time || is_lost[direction] { f64::NAN } else { -changes[direction] / fall };
        let delays: Slopes = std::array::from_fn(delay);
        let rate = if has_no_time || is_lost.contains(&true) { f64::NAN } else { fall };
        if self.is_silent {
            // The last one alone is asked for.
            self.crossings.clear();
        }
        self.crossings.push(Crossing { time, event, rate, delays });
        self.postpone(delays.map(|delay| if delay.is_nan() { 0.0 } else { delay }));
    }

    /// Finds an event that inputs which have jumped bring exactly to its limit: more of the direction lets it happen, or less.
    pub(super) fn look_for_limits(&mut self) {
        let indicators = self.indicators();
        for (event, it) in indicators.as_ref().iter().enumerate() {
            let slopes = it.slopes();
            if it.value() == 0.0 && slopes != STILL && !self.system.is_kink(event) {
                self.lose(event, "an input brings it exactly to its limit", |direction| slopes[direction] != 0.0);
            }
        }
    }

    /// Finds a state that was held before an event, or that passes 0 there, and by which the rates have an infinite slope behind it:
    /// these grow and grow, the nearer one comes. The equations do not tell how the motion leaves a state that was held.
    #[cold]
    pub(super) fn look_for_infinite_slopes(&mut self, event: usize) {
        let u = self.inputs.at(self.time).map(|it| S::of(it.value()));
        let slopes_by = |state: usize, share: f64| -> [S; N] {
            let mut x: [S; N] = array(|i| S::of(self.x[i].value()));
            let place = if self.held[state] { x[state].value() } else { 0.0 };
            x[state] = S::with(place + share * self.scales[state], first(1.0));
            self.system.derivatives(S::of(self.time), &x, &u, &self.memory)
        };
        let still = |rates: [S; N], base: &[S; N]| -> [f64; N] {
            array(|i| (rates[i].slopes()[0] - base[i].slopes()[0]).abs())
        };
        let is_steep = |state: usize, steeper: f64| {
            // Parameters and the memory vary, too.
            let x: [S; N] = array(|i| S::of(self.x[i].value()));
            let base = self.system.derivatives(S::of(self.time), &x, &u, &self.memory);
            let columns = NEARER.map(|share| still(slopes_by(state, share), &base));
            (0..N).any(|row| columns.windows(2).all(|two| two[1][row] > steeper * two[0][row]))
        };
        let passes = |state: usize| self.x[state].value().abs() <= NEARER[0] * self.scales[state];
        let any_is = |is_asked: &dyn Fn(usize) -> bool, steeper: f64| {
            (0..N).any(|state| is_asked(state) && is_steep(state, steeper))
        };
        if self.lost.contains(&None) {
            if any_is(&|state| self.held[state], STEEPER) {
                self.lose(event, "behind it rates have an infinite slope by a state that was held", |_| true);
            } else if any_is(&|state| !self.held[state] && passes(state), STEEPER_IN_PASSING) {
                let reason = "rates are so steep by a state that passes 0 there that slopes behind it are inaccurate";
                self.lose(event, reason, |_| true);
            }
        }
        self.held = [false; N];
    }

    /// Remembers what is before a sample whose instant varies with delays.
    #[inline(always)]
    pub(super) fn pass(&mut self, delays: Slopes) {
        if delays != STILL && !self.is_silent {
            self.passed = Some(Box::new(Passed { time: self.time, x: self.x, memory: self.memory.clone() }));
        }
    }

    /// States and memory on the other side of a sample that is taken at the present communication point, at an instant that varies: one
    /// that has just been taken, or is due. What bends there has another slope on that side.
    pub fn beside_sample(&self) -> Option<([S; N], H::Memory<S>)> {
        let is_now = |time: f64| {
            let sample = Sample::near(S::of(time), f64::INFINITY).rounded(self.time, self.start);
            sample.is_due_at(self.time) && !sample.is_before(self.time)
        };
        if let Some(passed) = self.passed.as_ref().filter(|passed| is_now(passed.time)) {
            return Some((passed.x, passed.memory.clone()));
        }
        let (time, u) = (S::of(self.time), self.inputs.at(self.time));
        self.consistent(|x, memory| {
            let due: S = self.system.next_sample::<S>(memory).time;
            if due.slopes() == STILL || !is_now(due.value()) {
                return None;
            }
            let later = |x: &[S; N], memory: &H::Memory<S>, delays: Slopes| -> [S; N] {
                let rates = self.system.derivatives(time, x, &u, memory);
                array(|i| S::with(x[i].value(), moved(x[i].slopes(), rates[i].value(), &delays)))
            };
            let (mut there, mut memory) = (later(x, memory, due.slopes()), memory.clone());
            let now = S::with(due.value().max(self.time), due.slopes());
            self.system.sample(now, &mut there, &u, &mut memory);
            Some((later(&there, &memory, due.slopes().map(|delay| -delay)), memory))
        })
    }

    /// Goes on to an instant that is later by delays of the value 0.
    pub(super) fn postpone(&mut self, delays: Slopes) {
        if S::VARIES && delays != STILL {
            self.late = delays;
            self.shift(delays);
        }
    }

    /// Goes back from the instant of an event to the present time, behind the event.
    pub(super) fn catch_up(&mut self) {
        if S::VARIES && self.late != STILL {
            let delays = std::mem::replace(&mut self.late, STILL);
            self.shift(delays.map(|delay| -delay));
        }
    }

    /// Follows the motion by delays of the value 0.
    #[cold]
    fn shift(&mut self, delays: Slopes) {
        let rates = self.system.derivatives(S::of(self.time), &self.x, &self.inputs.at(self.time), &self.memory);
        for (state, rate) in self.x.iter_mut().zip(rates) {
            *state = S::with(state.value(), moved(state.slopes(), rate.value(), &delays));
        }
    }

    /// The states at the end of a step with accurate slopes; nothing where the slopes of the step are accurate already. The step
    /// control has seen values alone, and within a smooth region slopes have the order of the method.
    #[inline(always)]
    pub(super) fn refined(&mut self, h: f64, end_time: f64, end: &[S; N]) -> Option<[S; N]> {
        if !S::VARIES || !self.settings.is_adaptive() {
            return None;
        }
        if !self.is_smooth(h, end_time, end) {
            return self.in_pieces(h, end_time, end, false);
        }
        let excess = self.inaccuracy(&self.x, end, &self.error);
        if excess > 1.0 { self.divided_step(h, end_time, end, excess) } else { None }
    }

    /// The states at the end of a smooth step with slopes whose error exceeds what is allowed by a factor.
    // A function of its own, which leaves the step short.
    #[inline(never)]
    fn divided_step(&mut self, h: f64, end_time: f64, end: &[S; N], excess: f64) -> Option<[S; N]> {
        let first = Some(&self.linearisation.derivatives).filter(|_| self.is_explicit);
        let beside = [self.is_behind_event(), false];
        let Substep { end: reached, rates, .. } = self.divided(h, [0.0, 1.0], beside, &self.x, first, excess)?;
        let x = array(|i| S::with(end[i].value(), reached[i].slopes()));
        self.end_slope = match rates {
            Some(rates) => array(|i| S::with(self.end_slope[i].value(), rates[i].slopes())),
            None => self.system.derivatives(S::of(end_time), &x, &self.inputs.at(end_time), &self.memory),
        };
        Some(x)
    }

    fn is_behind_event(&self) -> bool {
        self.crossings.last().is_some_and(|crossing| crossing.time == self.time)
    }

    /// The states at an event at the end of a step of a size in s, with the slopes there. The trial steps that located the event have
    /// slopes at other instants, or from stages behind the event.
    #[cold]
    pub(super) fn at_event(&mut self, h: f64, end: [S; N]) -> [S; N] {
        let end_time = self.time + h;
        let slopes =
            if self.settings.is_adaptive() { self.in_pieces(h, end_time, &end, true) } else { self.trial(h).ok() };
        slopes.map_or(end, |slopes| array(|i| S::with(end[i].value(), slopes[i].slopes())))
    }

    /// The largest error of a slope in a step relative to what is allowed.
    fn inaccuracy(&self, start: &[S; N], end: &[S; N], errors: &[S; N]) -> f64 {
        let mut worst: f64 = 0.0;
        for i in 0..N {
            let (start, end, errors) = (start[i].slopes(), end[i].slopes(), errors[i].slopes());
            for direction in 0..DIRECTIONS {
                let largest = self.peaks[i][direction].max(start[direction].abs()).max(end[direction].abs());
                worst = worst.max(errors[direction].abs() / largest.max(NEGLIGIBLE * self.scales[i]));
            }
        }
        let sharpest = if self.is_explicit { SHARPEST } else { SHARPEST_IMPLICIT };
        worst / self.settings.tolerance.max(if self.is_silent { OF_A_FILTER } else { sharpest })
    }

    /// The states at the end of a step in smooth regions; at the end may be an event, with a kink beside it.
    #[cold]
    fn in_pieces(&mut self, h: f64, end_time: f64, end: &[S; N], ends_on_event: bool) -> Option<[S; N]> {
        let ended = values(end);
        let [start_slope, end_slope] = self.slopes(end_time, &ended);
        let start = values(&self.x);
        let path = Hermite { start: &start, start_slope: &start_slope, end: &ended, end_slope: &end_slope, h };
        let (mut x, mut from) = (self.x, 0.0);
        for part in 0..=MOST_KINKS {
            let to = if part < MOST_KINKS { self.first_kink_behind(&path, from).unwrap_or(1.0) } else { 1.0 };
            let beside = [from > 0.0 || self.is_behind_event(), to < 1.0 || ends_on_event];
            let reached = self.smooth_piece(h, [from, to], beside, &x, None)?.end;
            // Behind a kink the equations of its other side hold.
            let there = if to < 1.0 { self.between(&path, to) } else { ended };
            x = array(|i| S::with(there[i], reached[i].slopes()));
            from = to;
            if to >= 1.0 {
                break;
            }
        }
        self.end_slope = self.system.derivatives(S::of(end_time), &x, &self.inputs.at(end_time), &self.memory);
        Some(x)
    }

    /// The end of a smooth region of a step, which may begin or end on a kink, from rates at its start that may be known.
    fn smooth_piece(
        &self,
        h: f64,
        [from, to]: [f64; 2],
        beside_kink: [bool; 2],
        x: &[S; N],
        first: Option<&[S; N]>,
    ) -> Option<Substep<N, S>> {
        let part = self.substep(self.time + from * h, x, first, (to - from) * h)?;
        let excess = self.inaccuracy(x, &part.end, &part.error);
        let smallest = if beside_kink.contains(&true) { SMALLEST_BESIDE_KINK } else { SMALLEST_PIECE };
        if excess <= 1.0 || to - from <= smallest {
            return Some(part);
        }
        self.divided(h, [from, to], beside_kink, x, first, excess)
    }

    /// The same where the error of a slope has been found to exceed what is allowed by a factor: in as many parts as the order of
    /// the method asks for, or in halves beside a kink, where the error has another order.
    fn divided(
        &self,
        h: f64,
        [from, to]: [f64; 2],
        [after_kink, before_kink]: [bool; 2],
        x: &[S; N],
        first: Option<&[S; N]>,
        excess: f64,
    ) -> Option<Substep<N, S>> {
        let wanted = if after_kink || before_kink { 2.0 } else { (MARGIN * fourth_root(excess)).ceil() };
        let last = wanted.clamp(2.0, MOST_PARTS) as usize - 1;
        let size = (to - from) / (last + 1) as f64;
        let mut done = self.smooth_piece(h, [from, from + size], [after_kink, false], x, first)?;
        for part in 1..=last {
            let end = if part == last { to } else { from + size * (part + 1) as f64 };
            let ends = [from + size * part as f64, end];
            done = self.smooth_piece(h, ends, [false, before_kink && part == last], &done.end, done.rates.as_ref())?;
        }
        Some(done)
    }

    /// The states within a step: on the cubic between its ends, but for those with a closed form.
    pub(super) fn between(&self, path: &Hermite<N>, fraction: f64) -> [f64; N] {
        let mut x = path.at(fraction);
        if H::CLOSED_FORM > 0 && !self.inputs.vary() {
            let (start, u) = (numbers(path.start), self.inputs.at(self.time));
            let closed_form = self.system.closed_form(&start, &u, &self.memory, &self.system.stride(fraction * path.h));
            x.iter_mut().zip(closed_form.end).take(H::CLOSED_FORM).for_each(|(state, end)| *state = end.value());
        }
        x
    }

    /// The states after a part of a step of a size in s, from rates at its start that may be known, and the rates at its end
    /// where the method yields them; nothing if it leads nowhere.
    fn substep(&self, time: f64, x: &[S; N], first: Option<&[S; N]>, size: f64) -> Option<Substep<N, S>> {
        let (system, memory, inputs) = (&self.system, &self.memory, &self.inputs);
        let u = inputs.at(time);
        let first = first.copied().unwrap_or_else(|| system.derivatives(S::of(time), x, &u, memory));
        if !self.is_explicit {
            let mut here = Linearisation { derivatives: first, jacobian: SMatrix::zeros(), time_slopes: None };
            let plain = values(&u);
            system.jacobian(time, &values(x), &plain, memory, &mut here.jacobian.data.0);
            if inputs.vary() || system.depends_on_time() {
                here.time_slopes = Some(self.time_slopes(time, x, &plain));
            }
            let Trial { end, error } = rosenbrock::step(system, time, x, inputs, memory, &here, size)?;
            return Some(Substep { end, error, rates: None });
        }
        let rate = || system.relaxation_rate(S::of(time), x, &first, &u, memory);
        let relaxing = self.relaxing().and_then(|_| Relaxing::new(rate(), size));
        let closed_form =
            (H::CLOSED_FORM > 0 && !inputs.vary()).then(|| system.closed_form(x, &u, memory, &system.stride(size)));
        let (closed_form, relaxing) = (closed_form.as_ref(), self.relaxing().zip(relaxing.as_ref()));
        let stages = Stages { system, time, x, inputs, memory, first: &first, h: size, closed_form, relaxing };
        let Explicit { trial: Trial { end, error }, slope, .. } = stages.classical();
        Some(Substep { end, error, rates: Some(slope) })
    }
}

/// States after a part of a step, their error, and rates there if they are known.
struct Substep<const N: usize, S> {
    end: [S; N],
    error: [S; N],
    rates: Option<[S; N]>,
}

/// Slopes of a number that moves at a rate until instants that come later by delays.
fn moved(slopes: Slopes, rate: f64, delays: &Slopes) -> Slopes {
    std::array::from_fn(|direction| slopes[direction] + rate * delays[direction])
}
