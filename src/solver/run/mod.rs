//! The hybrid driver: takes steps, watches the indicators, lets the system switch.

mod choice;
mod crossing;
mod kink;
#[cfg(feature = "sensitivities")]
mod smooth;
mod step;
mod strides;
mod varied;

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use self::choice::Choice;
#[cfg(feature = "sensitivities")]
pub use self::smooth::{Trail, Variation};
use self::strides::Strides;
use self::varied::Passed;
pub use self::varied::{Crossing, Lost};
use super::balance::Balance;
use super::error::StepError;
use super::settings::Settings;
use super::trial::Linearisation;
use super::{numbers, values};
use crate::numbers::{DIRECTIONS, Real, STILL, Slopes, Varying};
use crate::system::{Counters, Held, Hints, QUANTITIES, Sample, System};
use crate::variables::StateSet;

/// Progress of a run, apart from states and memory of its system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Time in s.
    time: f64,
    /// Step size to try next, in s.
    step: f64,
    choice: Choice,
    counters: Counters,
    balance: Balance,
    /// The event before which the run has paused.
    pending: Option<u32>,
}

impl Progress {
    /// Current time in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Whether a run of a system with a number of event indicators can have come this far.
    pub fn is_sound(&self, indicators: usize) -> bool {
        let is_event = |event: u32| (event as usize) < indicators;
        self.time.is_finite()
            && self.step.is_finite()
            && self.step > 0.0
            && self.choice.is_sound()
            && self.balance.is_finite()
            && self.pending.is_none_or(is_event)
    }
}

/// A running hybrid system, in numbers `S`.
pub struct Run<H: System<U>, const N: usize, const U: usize, S: Varying = Real> {
    system: H,
    settings: Settings,
    /// Magnitudes of the states.
    scales: [f64; N],
    time: f64,
    /// Time in s on the clock of the host at the start.
    start: f64,
    x: [S; N],
    memory: H::Memory<S>,
    inputs: Held<U, S>,
    /// Step size to try next, carried across communication points.
    step: f64,
    choice: Choice,
    /// Whether the step tried last is one of the explicit method of the adaptive scheme.
    is_explicit: bool,
    /// Whether it is one of the midpoint rule.
    is_midpoint: bool,
    counters: Counters,
    balance: Balance,
    linearisation: Linearisation<N, S>,
    /// Whether the linearisation belongs to the present states, memory and inputs.
    is_linearised: bool,
    /// Strides of explicit steps.
    strides: Strides<S>,
    /// Error of the step tried last.
    error: [S; N],
    /// Derivatives at the end of the explicit step tried last.
    end_slope: [S; N],
    /// Error of the explicit step tried last if it crosses a kink.
    defect: [S; N],
    /// Hints of the system for the present mode.
    hints: Hints,
    /// Size in s of the step that met the kink on which the next one is to end; 0 if none is to.
    beyond: f64,
    /// The inputs at the end of an explicit step that has just been accepted, if the derivatives of the linearisation
    /// belong to that point: the next step may start from them.
    arrived_with: Option<[S; U]>,
    /// Indicators at the present states, memory and inputs.
    indicators: H::Indicators<S>,
    /// Whether states and memory have followed the present inputs.
    is_settled: bool,
    /// Whether the indicators belong to the present inputs, once the memory has followed these.
    indicators_hold: bool,
    /// The event that is at its limit here, and happens within the step tried last.
    leaving: Option<usize>,
    /// Whether the run pauses before an event, instead of switching.
    pauses: bool,
    /// The event before which it has paused: the modes are still those that the event ends.
    pending: Option<usize>,
    /// The last event that has ended a step.
    last_event: Option<usize>,
    /// Times in s and numbers of the events since they are logged.
    log: Option<Vec<(f64, usize)>>,
    /// Steps tried since the start of the communication step.
    attempts: u64,
    /// The states that were held before the event of numbers with slopes.
    held: [bool; N],
    /// Whether the inputs of numbers with slopes have jumped since the memory followed them.
    jumped: bool,
    /// By how much the present instant, an event, comes later along the directions of numbers with slopes.
    late: Slopes,
    /// The largest slopes of the states so far.
    peaks: [Slopes; N],
    /// The events so far of numbers with slopes.
    crossings: Vec<Crossing>,
    /// Where these have lost their slopes.
    lost: [Option<Lost>; DIRECTIONS],
    /// Time in s, states and memory before the last sample, if its instant varies.
    passed: Option<Box<Passed<H::Memory<S>, N, S>>>,
    /// Whether slopes are lost without a word.
    is_silent: bool,
    /// Magnitudes of the indicators, of numbers with slopes.
    nominals: Vec<f64>,
    /// The trail of the present communication step, if it leaves one.
    #[cfg(feature = "sensitivities")]
    trail: Option<Box<Trail<H::Memory<S>, N>>>,
}

/// The largest step the adaptive scheme takes, in s.
const MAX_STEP: f64 = 0.1;
const FIRST_STEP: f64 = 1e-5;

impl<H: System<U>, const N: usize, const U: usize, S: Varying> Run<H, N, U, S> {
    /// Index of the state that [relaxes](System::RELAXING), in runs with room for states of a friction law.
    const RELAXING: Option<usize> = match H::RELAXING {
        Some(place) if N > H::State::OTHERS => Some(place.among(N)),
        _ => None,
    };

    /// Index of the state that relaxes, if the model has more states than its own. Places to spare make no difference.
    #[inline(always)]
    fn relaxing(&self) -> Option<usize> {
        Self::RELAXING.filter(|_| self.system.states() > H::State::OTHERS)
    }

    /// The same from states and memory of a run that begins. They take kilobytes, and so does the run: a frame on the stack of its
    /// own.
    #[inline(never)]
    #[allow(clippy::boxed_local, reason = "the states and the memory would be copied over the stack")]
    pub(crate) fn boxed(
        system: H,
        settings: Settings,
        begin: Box<([S; N], H::Memory<S>)>,
        inputs: [S; U],
    ) -> Box<Self> {
        let (x, memory) = *begin;
        Box::new(Self::new(system, settings, 0.0, x, memory, inputs))
    }

    /// A run from given states and memory.
    pub fn new(system: H, settings: Settings, time: f64, x: [S; N], memory: H::Memory<S>, inputs: [S; U]) -> Self {
        let (balance, scales) = (Balance::new(system.content(&x, &memory)), system.scales());
        let indicators = system.indicators(S::of(time), &x, &inputs, &memory);
        Self {
            system,
            settings,
            scales,
            balance,
            time,
            start: 0.0,
            x,
            memory,
            inputs: Held::new(time, inputs, [0.0; U]),
            step: if settings.is_adaptive() { FIRST_STEP } else { settings.step },
            choice: Choice::default(),
            is_explicit: false,
            is_midpoint: false,
            counters: Counters::default(),
            linearisation: Linearisation { derivatives: [S::zero(); N], jacobian: SMatrix::zeros(), time_slopes: None },
            is_linearised: false,
            strides: Strides::unknown(),
            error: [S::zero(); N],
            end_slope: [S::zero(); N],
            defect: [S::zero(); N],
            hints: Hints::default(),
            beyond: 0.0,
            arrived_with: None,
            indicators,
            is_settled: false,
            indicators_hold: false,
            leaving: None,
            pauses: false,
            pending: None,
            last_event: None,
            log: None,
            attempts: 0,
            held: [false; N],
            jumped: false,
            late: STILL,
            peaks: [STILL; N],
            crossings: Vec::new(),
            lost: [const { None }; DIRECTIONS],
            passed: None,
            is_silent: false,
            nominals: if S::VARIES {
                H::indicator_list().iter().map(|indicator| indicator.nominal).collect()
            } else {
                Vec::new()
            },
            #[cfg(feature = "sensitivities")]
            trail: None,
        }
    }

    /// Current time in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Tells at which time in s on the clock of the host the run has started: its communication points are rounded there.
    pub fn set_clock(&mut self, start: f64) {
        self.start = start;
    }

    /// The system.
    pub fn system(&self) -> &H {
        &self.system
    }

    /// Settings of the integration.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Exchanges the system for one with other parameters.
    pub fn replace_system(&mut self, system: H) {
        self.scales = system.scales();
        (self.system, self.strides) = (system, Strides::unknown());
        (self.is_linearised, self.arrived_with) = (false, None);
        (self.is_settled, self.indicators_hold) = (false, false);
    }

    /// Work done so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Logs the events from here on, which takes memory for each.
    pub fn log_events(&mut self) {
        self.log = Some(Vec::new());
    }

    /// Times in s and numbers of the events that are logged.
    pub fn logged_events(&self) -> &[(f64, usize)] {
        self.log.as_deref().unwrap_or_default()
    }

    /// Progress of the run.
    pub fn progress(&self) -> Progress {
        let &Self { time, step, choice, counters, balance, pending, .. } = self;
        let pending = pending.map(|event| event as u32);
        Progress { time, step, choice, counters, balance, pending }
    }

    /// The event indicators with the present modes, memory and inputs: exactly 0 at an event.
    pub fn indicators(&self) -> H::Indicators<S> {
        self.consistent(|x, memory| self.system.indicators(S::of(self.time), x, &self.inputs.at(self.time), memory))
    }

    /// Content of the system of each conserved quantity beyond the account; 0 without one.
    pub fn residuals(&self) -> [f64; QUANTITIES] {
        if !self.settings.keeps_balance {
            return [0.0; QUANTITIES];
        }
        self.balance.residual(self.system.content(&self.x, &self.memory))
    }

    /// States and memory as integrated.
    pub fn state(&self) -> (&[S; N], &H::Memory<S>) {
        (&self.x, &self.memory)
    }

    /// Whether these are consistent with the present inputs.
    pub fn is_settled(&self) -> bool {
        self.is_settled
    }

    /// Goes back to states, memory and progress of a run of the same system.
    pub fn restore(&mut self, x: [S; N], memory: &mut H::Memory<S>, progress: Progress) {
        self.x = x;
        // Kilobytes, which would be copied over the stack otherwise.
        std::mem::swap(&mut self.memory, memory);
        let Progress { time, step, choice, counters, balance, pending } = progress;
        (self.time, self.step, self.choice, self.counters, self.balance) = (time, step, choice, counters, balance);
        (self.is_linearised, self.arrived_with, self.leaving) = (false, None, None);
        (self.is_settled, self.indicators_hold) = (false, false);
        self.pending = pending.map(|event| event as usize);
        if S::VARIES {
            (self.late, self.peaks, self.jumped) = (STILL, [STILL; N], false);
            self.lost = [const { None }; DIRECTIONS];
            self.passed = None;
            self.crossings.clear();
        }
    }

    /// Sets the inputs and their slopes from now on.
    pub fn set_inputs(&mut self, values: [S; U], slopes: [f64; U]) {
        let inputs = Held::new(self.time, values, slopes);
        // Inputs that stay as they are leave everything valid.
        let is_same = values == self.inputs.at(self.time) && slopes == self.inputs.slopes();
        if !is_same {
            let (before, held) = (self.inputs.at(self.time), self.is_settled || self.indicators_hold);
            self.indicators_hold = held && self.system.indicators_hold([&before, &values]);
            self.jumped |= S::VARIES && (0..U).any(|i| values[i].value() != before[i].value());
        }
        self.is_linearised &= is_same;
        self.is_settled &= is_same;
        self.inputs = inputs;
    }

    /// The inputs at the current time, and their slopes.
    pub fn inputs(&self) -> ([S; U], [f64; U]) {
        (self.inputs.at(self.time), self.inputs.slopes())
    }

    /// The states and the memory consistent with the present inputs, from which the next step starts.
    ///
    /// If the inputs set off events without end, those before the limit have happened. Where the run has paused before an
    /// event, nothing has happened yet.
    pub fn consistent<R>(&self, look: impl FnOnce(&[S; N], &H::Memory<S>) -> R) -> R {
        let settled;
        let (x, memory) = if self.is_settled || self.pending.is_some() {
            (&self.x, &self.memory)
        } else {
            settled = self.settled();
            (&settled.0, &settled.1)
        };
        look(x, memory)
    }

    /// States and memory after they have followed the present inputs, and the events that these set off.
    // A function of its own, which is compiled once for all that look.
    #[inline(never)]
    fn settled(&self) -> ([S; N], H::Memory<S>) {
        let (mut x, mut memory) = (self.x, self.memory.clone());
        let u = self.inputs.at(self.time);
        self.system.follow(S::of(self.time), &x, &u, &mut memory);
        let _ = crossing::settle(&self.system, S::of(self.time), &mut x, &u, &mut memory, |_| ());
        (x, memory)
    }

    /// Integrates to `end`.
    ///
    /// # Errors
    /// [`StepError`] when `end` cannot be reached; the run then stays at the last accepted step.
    pub fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.last_event = None;
        if end > self.time {
            let duration = end - self.time;
            let (span, u, slopes) = ([self.time, duration], self.inputs.at(self.time), self.inputs.slopes());
            if self.system.begin(span, &self.x, &u, &slopes, &mut self.memory) {
                self.is_linearised = false;
            }
        }
        self.update()?;
        let limit = self.settings.limit(end - self.time, MAX_STEP.min(self.system.max_step()));
        let (start, events) = (self.time, self.counters.events);
        let limit = limit.map_err(|limit| self.too_many_steps(limit, events))?;
        (self.attempts, self.beyond) = (0, 0.0);
        while self.time < end && self.pending.is_none() {
            if self.attempts >= limit {
                return Err(self.too_many_steps(limit, events));
            }
            self.attempts += 1;
            let sample = self.system.next_sample::<S>(&self.memory).rounded(self.time, self.start);
            let time = sample.time.value();
            if time <= self.time || (self.time == start && sample.is_due_at(start)) {
                self.sample(time.max(self.time))?;
            } else {
                let limit = if sample.is_before(end) { time } else { end };
                self.attempt(limit.min(self.time + self.system.max_step()))?;
            }
        }
        if self.pending.is_none() {
            self.system.arrive(S::of(self.time), &self.x, &self.inputs.at(self.time), &mut self.memory);
        }
        Ok(())
    }

    /// The error of a communication step that has used up its solver steps, and had a number of events before.
    #[cold]
    fn too_many_steps(&self, limit: u64, events_before: u64) -> StepError {
        StepError::TooManySteps {
            time: self.time,
            limit,
            events: self.counters.events - events_before,
            event: self.last_event.map_or("", |event| self.system.event_name(event)),
            variant: self.system.variant(),
        }
    }

    /// Integrates to `end`, or to the first event on the way and no further; tells whether there is one, which happens when
    /// the run goes on.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub fn advance_to_event(&mut self, end: f64) -> Result<bool, StepError> {
        self.pauses = true;
        let outcome = self.advance(end);
        self.pauses = false;
        outcome.map(|()| self.pending.is_some())
    }

    /// Lets the event happen before which the run has paused, and states and memory follow the present inputs.
    ///
    /// # Errors
    /// [`StepError::Chattering`] if events follow each other without end.
    pub fn update(&mut self) -> Result<(), StepError> {
        if let Some(event) = self.pending.take() {
            self.switch(event)?;
        }
        self.follow();
        if self.indicators_hold {
            (self.is_settled, self.indicators_hold) = (true, false);
            self.jumped = false;
            return Ok(());
        }
        let events = self.counters.events;
        self.settle()?;
        if S::VARIES && std::mem::take(&mut self.jumped) && self.counters.events == events {
            self.look_for_limits();
        }
        Ok(())
    }

    /// Takes the sample of a time in s, which is now but for the tolerance of samples.
    fn sample(&mut self, time: f64) -> Result<(), StepError> {
        if S::VARIES {
            let due: Sample<S> = self.system.next_sample::<S>(&self.memory);
            self.pass(due.time.slopes());
            self.postpone(due.time.slopes());
        }
        let now = S::with(time, self.late);
        let u = self.inputs_now();
        self.system.sample(now, &mut self.x, &u, &mut self.memory);
        (self.is_linearised, self.arrived_with) = (false, None);
        let outcome = self.settle();
        self.catch_up();
        outcome
    }

    /// Lets the memory follow the present states and inputs; derivatives that it changes are worked out anew.
    fn follow(&mut self) {
        let u = self.inputs_now();
        if self.system.follow(self.now(), &self.x, &u, &mut self.memory) {
            (self.is_linearised, self.arrived_with) = (false, None);
        }
    }

    /// Derivatives here and at the end of a step, of all states: in the linearisation and in the stages, states with a closed form
    /// may be missing.
    fn slopes(&self, end_time: f64, end: &[f64; N]) -> [[f64; N]; 2] {
        let slope = |time: f64, x: &[S; N]| {
            values(&self.system.derivatives(S::of(time), x, &self.inputs.at(time), &self.memory))
        };
        [slope(self.time, &self.x), slope(end_time, &numbers(end))]
    }

    fn indicators_at(&self, time: f64, x: &[S; N]) -> H::Indicators<S> {
        self.system.indicators(S::of(time), x, &self.inputs.at(time), &self.memory)
    }
}

/// A step that the clock resolves well.
fn smallest_step(time: f64) -> f64 {
    (16.0 * f64::EPSILON * time.abs()).max(1e-15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_that_no_run_makes_is_not_sound() {
        let counters = Counters::default();
        let (choice, balance) = (Choice::default(), Balance::default());
        let sound = Progress { time: 1.0, step: 1e-3, choice, counters, balance, pending: None };
        assert!(sound.is_sound(0));
        assert!(Progress { pending: Some(2), ..sound }.is_sound(3), "the last of three events");
        let (nan, infinite) = (f64::NAN, f64::INFINITY);
        let times = [nan, infinite, -infinite].map(|time| Progress { time, ..sound });
        let steps = [nan, infinite, 0.0, -1e-3].map(|step| Progress { step, ..sound });
        let others = [
            Progress { pending: Some(3), ..sound },
            Progress { pending: Some(4), ..sound },
            Progress { balance: Balance::new([1.0, nan]), ..sound },
        ];
        for progress in [&times[..], &steps, &others].concat() {
            assert!(!progress.is_sound(3), "{progress:?}");
        }
    }
}
