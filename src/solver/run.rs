//! The hybrid driver: takes steps, watches the indicators, lets the system switch.

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use super::balance::Balance;
use super::counters::Counters;
use super::error::StepError;
use super::event::{Bracket, Hermite, root};
use super::settings::{Scheme, Settings};
use super::{implicit_euler, rosenbrock, runge_kutta};
use crate::hybrid::{Held, HybridSystem, QUANTITIES};
use crate::numbers::Dual;

/// A step that may be accepted.
#[derive(Clone, Copy, Debug)]
pub struct Trial<const N: usize> {
    /// States at its end.
    pub end: [f64; N],
    /// Estimated error of each state (zero for fixed-step schemes).
    pub error: [f64; N],
}

/// The equations linearised at the start of a step.
#[derive(Clone, Debug)]
pub struct Linearisation<const N: usize> {
    /// Time derivatives of the states.
    pub derivatives: [f64; N],
    /// Their partial derivatives with respect to the states.
    pub jacobian: SMatrix<f64, N, N>,
    /// Their partial derivatives with respect to time, where they depend on it.
    pub time_slopes: Option<[f64; N]>,
}

/// How far a run has come, apart from states and memory of its system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Time in s.
    time: f64,
    /// Step size to try next, in s.
    step: f64,
    counters: Counters,
    balance: Balance,
}

impl Progress {
    /// Current time in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Whether a run can have come this far.
    pub fn is_sound(&self) -> bool {
        self.time.is_finite() && self.step.is_finite() && self.step > 0.0 && self.balance.is_finite()
    }
}

/// A running hybrid system.
#[derive(Clone)]
pub struct Run<H: HybridSystem<N, U>, const N: usize, const U: usize> {
    system: H,
    settings: Settings,
    /// Magnitudes of the states.
    scales: [f64; N],
    time: f64,
    x: [f64; N],
    memory: H::Memory,
    inputs: Held<U>,
    /// Step size to try next, carried across communication points.
    step: f64,
    counters: Counters,
    balance: Balance,
    linearisation: Linearisation<N>,
    /// Whether the linearisation is that of the present states, memory and inputs.
    is_linearised: bool,
    /// Indicators at the present states, memory and inputs.
    indicators: H::Indicators,
    /// Whether states and memory have followed the present inputs.
    is_settled: bool,
}

/// The largest step the adaptive scheme takes, in s.
const MAX_STEP: f64 = 0.1;
const FIRST_STEP: f64 = 1e-5;
const SAFETY: f64 = 0.9;
const MAX_GROWTH: f64 = 5.0;
const MAX_SHRINKAGE: f64 = 0.1;
/// Multiple of its scale that no state exceeds unless the scheme diverges.
const FAR_OUT: f64 = 1e9;
/// Switches at one instant before it counts as chattering.
const MAX_SWITCHES: usize = 100;
/// Trial steps to locate an event; regula falsi needs about three.
const MAX_REFINEMENTS: usize = 60;

impl<H: HybridSystem<N, U>, const N: usize, const U: usize> Run<H, N, U> {
    /// A run from given states and memory.
    pub fn new(system: H, settings: Settings, time: f64, x: [f64; N], memory: H::Memory, inputs: [f64; U]) -> Self {
        let (balance, scales) = (Balance::new(system.content(&x, &memory)), system.scales());
        let indicators = system.indicators(time, &x, &inputs, &memory);
        Self {
            system,
            settings,
            scales,
            balance,
            time,
            x,
            memory,
            inputs: Held::new(time, inputs, [0.0; U]),
            step: if settings.is_adaptive() { FIRST_STEP } else { settings.step },
            counters: Counters::default(),
            linearisation: Linearisation { derivatives: [0.0; N], jacobian: SMatrix::zeros(), time_slopes: None },
            is_linearised: false,
            indicators,
            is_settled: false,
        }
    }

    /// Current time in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The system.
    pub fn system(&self) -> &H {
        &self.system
    }

    /// Exchanges the system for one with other parameters.
    pub fn replace_system(&mut self, system: H) {
        self.scales = system.scales();
        self.system = system;
        (self.is_linearised, self.is_settled) = (false, false);
    }

    /// What has been done so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// How far the run has come.
    pub fn progress(&self) -> Progress {
        let &Self { time, step, counters, balance, .. } = self;
        Progress { time, step, counters, balance }
    }

    /// What the system holds of each conserved quantity beyond what its account allows; 0 if none is kept.
    pub fn residuals(&self) -> [f64; QUANTITIES] {
        if !self.settings.keeps_balance {
            return [0.0; QUANTITIES];
        }
        self.balance.residual(self.system.content(&self.x, &self.memory))
    }

    /// States and memory as integrated.
    pub fn state(&self) -> (&[f64; N], &H::Memory) {
        (&self.x, &self.memory)
    }

    /// Goes back to states, memory and progress of a run of the same system.
    pub fn restore(&mut self, x: [f64; N], memory: H::Memory, progress: Progress) {
        (self.x, self.memory) = (x, memory);
        Progress { time: self.time, step: self.step, counters: self.counters, balance: self.balance } = progress;
        (self.is_linearised, self.is_settled) = (false, false);
    }

    /// Sets the inputs and their slopes from now on.
    pub fn set_inputs(&mut self, values: [f64; U], slopes: [f64; U]) {
        let inputs = Held::new(self.time, values, slopes);
        // Inputs that stay as they are leave everything valid.
        let is_same = values == self.inputs.at(self.time) && slopes == self.inputs.slopes();
        self.is_linearised &= is_same;
        self.is_settled &= is_same;
        self.inputs = inputs;
    }

    /// The inputs at the current time, and their slopes.
    pub fn inputs(&self) -> ([f64; U], [f64; U]) {
        (self.inputs.at(self.time), self.inputs.slopes())
    }

    /// Looks at the states and the memory consistent with the present inputs: what the next step starts from.
    ///
    /// If the inputs set off events without end, those before the limit have happened.
    pub fn consistent<R>(&self, look: impl FnOnce(&[f64; N], &H::Memory) -> R) -> R {
        if self.is_settled {
            return look(&self.x, &self.memory);
        }
        let (mut x, mut memory, mut counters) = (self.x, self.memory.clone(), self.counters);
        let u = self.inputs.at(self.time);
        self.system.follow(self.time, &x, &u, &mut memory);
        let _ = settle(&self.system, self.time, &mut x, &u, &mut memory, &mut counters);
        look(&x, &memory)
    }

    /// Integrates to `end`.
    ///
    /// # Errors
    /// [`StepError`] when `end` cannot be reached; the state is then that of the last accepted step.
    pub fn advance(&mut self, end: f64) -> Result<(), StepError> {
        self.follow();
        self.settle()?;
        let mut attempts = 0;
        while self.time < end {
            if attempts == self.settings.max_steps {
                return Err(StepError::TooManySteps { time: self.time, limit: self.settings.max_steps });
            }
            attempts += 1;
            let sample = self.system.next_sample(&self.memory);
            if sample <= self.time {
                self.system.sample(self.time, &mut self.x, &self.inputs.at(self.time), &mut self.memory);
                self.is_linearised = false;
                self.settle()?;
            } else {
                self.attempt(end.min(sample).min(self.time + self.system.max_step()))?;
            }
        }
        Ok(())
    }

    /// Tries one step that ends no later than `limit`; accepts it, ends it at an event, or reduces the step size.
    fn attempt(&mut self, limit: f64) -> Result<(), StepError> {
        self.linearise();
        let remaining = limit - self.time;
        // A step slightly too short is stretched, and two equal steps are better than one long and one tiny.
        let h = if self.step * 1.1 >= remaining {
            remaining
        } else if self.step * 2.0 > remaining && self.settings.is_adaptive() {
            0.5 * remaining
        } else {
            self.step
        };
        let end_time = if h == remaining { limit } else { self.time + h };
        let Some(trial) = self.trial(h) else {
            return self.reject(h, 0.25);
        };
        let error = self.error_norm(&trial);
        if error > 1.0 {
            return self.reject(h, (SAFETY / fourth_root(error)).max(MAX_SHRINKAGE));
        }
        if self.system.has_events() {
            let after = self.indicators_at(end_time, &trial.end);
            if after.as_ref().iter().any(|value| *value < 0.0) {
                return self.step_to_event(h, &trial, &after);
            }
            // Within the resolution of the clock the dip would be one of rounding.
            if h > 4.0 * smallest_step(self.time) && self.dips_between(h, &trial) {
                return self.reject(h, 0.5);
            }
            self.indicators = after;
        }
        self.accept(h, end_time, &trial, error);
        Ok(())
    }

    fn linearise(&mut self) {
        if self.is_linearised {
            return;
        }
        let u = self.inputs.at(self.time);
        let here = &mut self.linearisation;
        if self.settings.scheme == Scheme::Adaptive {
            here.derivatives = self.system.jacobian(self.time, &self.x, &u, &self.memory, &mut here.jacobian);
            self.counters.jacobians += 1;
            here.time_slopes = (self.inputs.vary() || self.system.depends_on_time()).then(|| {
                let time = Dual::<1>::variable(self.time, 0);
                let u = std::array::from_fn(|i| Dual { value: u[i], slope: [self.inputs.slopes()[i]] });
                let rates = self.system.derivatives(time, &self.x.map(scalar_constant), &u, &self.memory);
                rates.map(|rate| rate.slope[0])
            });
        } else {
            here.derivatives = self.system.derivatives(self.time, &self.x, &u, &self.memory);
        }
        self.is_linearised = true;
    }

    /// The step of size `h` from here, if it leads to states that have a meaning.
    fn trial(&mut self, h: f64) -> Option<Trial<N>> {
        let (system, time, x, inputs, memory) = (&self.system, self.time, &self.x, &self.inputs, &self.memory);
        let here = &self.linearisation;
        let trial = match self.settings.scheme {
            Scheme::Adaptive => rosenbrock::step(system, time, x, inputs, memory, here, h)?,
            Scheme::ImplicitEuler => {
                implicit_euler::step(system, time, x, inputs, memory, h, &mut self.counters.jacobians)?
            }
            Scheme::ExplicitEuler => {
                runge_kutta::EXPLICIT_EULER.step(system, time, x, inputs, memory, &here.derivatives, h)
            }
            Scheme::Rk3 => runge_kutta::RK3.step(system, time, x, inputs, memory, &here.derivatives, h),
            Scheme::Rk4 => runge_kutta::RK4.step(system, time, x, inputs, memory, &here.derivatives, h),
        };
        let mut magnitudes = trial.end.iter().zip(self.scales);
        let has_meaning = magnitudes.all(|(value, scale)| value.abs() <= FAR_OUT * scale);
        (has_meaning && self.system.is_admissible(&trial.end)).then_some(trial)
    }

    /// The largest error of a state relative to what is allowed.
    fn error_norm(&self, trial: &Trial<N>) -> f64 {
        // One instruction, where `f64::max` needs several to tell a missing number.
        let larger = |a: f64, b: f64| if a < b { b } else { a };
        let magnitudes = self.scales.into_iter().zip(self.x).zip(trial.end);
        let mut norm = 0.0;
        for (((scale, start), end), error) in magnitudes.zip(trial.error) {
            norm = larger(norm, error.abs() / larger(larger(scale, start.abs()), end.abs()));
        }
        norm / self.settings.tolerance
    }

    fn reject(&mut self, h: f64, factor: f64) -> Result<(), StepError> {
        self.counters.rejected += 1;
        let step = h * factor;
        let diverges = matches!(self.settings.scheme, Scheme::ExplicitEuler | Scheme::Rk3 | Scheme::Rk4);
        if diverges && factor < 0.5 {
            return Err(StepError::Diverged { time: self.time, step: self.settings.step });
        }
        // Where the clock is coarser than the longest step, `h` is 0: the step size to save must stay positive.
        if step < smallest_step(self.time) {
            return Err(StepError::StepSizeTooSmall { time: self.time });
        }
        self.step = step;
        Ok(())
    }

    fn accept(&mut self, h: f64, end_time: f64, trial: &Trial<N>, error: f64) {
        self.move_to(end_time, trial);
        self.step = if self.settings.is_adaptive() {
            let growth = SAFETY / fourth_root(error.max(1e-8));
            if growth >= MAX_GROWTH { self.step.max(h * MAX_GROWTH) } else { h * growth }.min(MAX_STEP)
        } else {
            self.settings.step
        };
    }

    fn move_to(&mut self, time: f64, trial: &Trial<N>) {
        if self.settings.keeps_balance {
            self.keep_balance(time, trial);
        }
        self.time = time;
        self.x = trial.end;
        self.counters.steps += 1;
        self.is_linearised = false;
        self.follow();
    }

    fn keep_balance(&mut self, end_time: f64, trial: &Trial<N>) {
        let end_slope = self.system.derivatives(end_time, &trial.end, &self.inputs.at(end_time), &self.memory);
        let start_slope = &self.linearisation.derivatives;
        let h = end_time - self.time;
        let path = Hermite { start: &self.x, start_slope, end: &trial.end, end_slope: &end_slope, h };
        self.balance.add(&self.system, &self.inputs, &self.memory, self.time, &path);
    }

    fn follow(&mut self) {
        self.system.follow(self.time, &self.x, &self.inputs.at(self.time), &mut self.memory);
    }

    fn indicators_at(&self, time: f64, x: &[f64; N]) -> H::Indicators {
        self.system.indicators(time, x, &self.inputs.at(time), &self.memory)
    }

    /// Whether an indicator is negative in the middle of a step at both ends of which it is not.
    fn dips_between(&self, h: f64, trial: &Trial<N>) -> bool {
        let slope = &self.linearisation.derivatives;
        // The parabola through the start, its slope, and the end, at half the step.
        let middle = std::array::from_fn(|i| 0.75 * self.x[i] + 0.25 * (trial.end[i] + h * slope[i]));
        let between = self.indicators_at(self.time + 0.5 * h, &middle);
        let pairs = between.as_ref().iter().zip(self.indicators.as_ref());
        pairs.into_iter().any(|(between, before)| *between < 0.0 && *before > 0.0)
    }

    /// Ends the step where the first indicator turns negative, and switches.
    fn step_to_event(&mut self, h: f64, trial: &Trial<N>, after: &H::Indicators) -> Result<(), StepError> {
        let Some((event, bracket, guess)) = self.first_crossing(h, trial, after) else {
            // The indicator starts at zero and seems to fall at once. Either a shorter step shows it rise first, or
            // the step is so short that the event is now.
            if h > 4.0 * smallest_step(self.time) {
                return self.reject(h, MAX_SHRINKAGE.max(0.5 * f64::from(self.settings.is_adaptive())));
            }
            let event = after.as_ref().iter().position(|value| *value < 0.0).unwrap_or(0);
            self.move_to(self.time + h, trial);
            return self.switch(event);
        };
        let (end, trial) = self.refine(event, bracket, guess, *trial);
        self.move_to(self.time + end, &trial);
        self.step = if self.settings.is_adaptive() { self.step.min(h) } else { self.settings.step };
        self.switch(event)
    }

    /// The indicator that crosses zero first, its bracket within the step, and where it seems to cross.
    fn first_crossing(&self, h: f64, trial: &Trial<N>, after: &H::Indicators) -> Option<(usize, Bracket, f64)> {
        const EARLY: [f64; 6] = [1e-3, 0.0625, 0.125, 0.25, 0.5, 0.75];
        let end_time = self.time + h;
        let end_slope = self.system.derivatives(end_time, &trial.end, &self.inputs.at(end_time), &self.memory);
        let start_slope = &self.linearisation.derivatives;
        let path = Hermite { start: &self.x, start_slope, end: &trial.end, end_slope: &end_slope, h };
        let value_at = |event: usize, fraction: f64| {
            self.indicators_at(self.time + fraction * h, &path.at(fraction)).as_ref()[event]
        };
        let mut first: Option<(usize, Bracket, f64)> = None;
        for (event, (start, end)) in self.indicators.as_ref().iter().zip(after.as_ref()).enumerate() {
            if *end >= 0.0 {
                continue;
            }
            let low = if *start > 0.0 {
                (0.0, *start)
            } else {
                // The trivial root at the start (the velocity after break-away) does not count.
                EARLY
                    .into_iter()
                    .map(|fraction| (fraction, value_at(event, fraction)))
                    .find(|(_, value)| *value > 0.0)?
            };
            let bracket = Bracket::new(low, (1.0, *end));
            let crossing = h * root(bracket, 1e-6, |fraction| value_at(event, fraction));
            if first.is_none_or(|(.., earliest)| crossing < earliest) {
                first = Some((event, Bracket::new((low.0 * h, low.1), (h, *end)), crossing));
            }
        }
        first
    }

    /// Narrows the bracket by steps of the scheme itself, until its end is just behind the event.
    fn refine(&mut self, event: usize, mut bracket: Bracket, guess: f64, trial: Trial<N>) -> (f64, Trial<N>) {
        let resolution = (bracket.end() * 1e-3 * self.settings.tolerance).max(smallest_step(self.time));
        let mut best = (bracket.end(), trial);
        let mut at = guess;
        for _ in 0..MAX_REFINEMENTS {
            let Some(trial) = self.trial(at) else { break };
            let value = self.indicators_at(self.time + at, &trial.end).as_ref()[event];
            bracket.narrow(at, value);
            if value <= 0.0 {
                best = (at, trial);
            }
            if bracket.width() <= 2.0 * resolution || (value <= 0.0 && bracket.overshoot() <= resolution) {
                break;
            }
            // Slightly behind the expected root, so that the bracket closes from both sides.
            at = (bracket.guess() + 0.5 * resolution).min(bracket.end() - 0.5 * resolution);
        }
        best
    }

    fn switch(&mut self, event: usize) -> Result<(), StepError> {
        let u = self.inputs.at(self.time);
        self.system.switch(event, self.time, &mut self.x, &u, &mut self.memory);
        self.counters.events += 1;
        self.is_linearised = false;
        self.settle()
    }

    /// Lets the system switch until all indicators are valid.
    fn settle(&mut self) -> Result<(), StepError> {
        let u = self.inputs.at(self.time);
        let before = self.counters.events;
        self.indicators = settle(&self.system, self.time, &mut self.x, &u, &mut self.memory, &mut self.counters)?;
        self.is_linearised &= self.counters.events == before;
        self.is_settled = true;
        Ok(())
    }
}

/// Switches until all indicators are valid, and returns them.
fn settle<H: HybridSystem<N, U>, const N: usize, const U: usize>(
    system: &H,
    time: f64,
    x: &mut [f64; N],
    u: &[f64; U],
    memory: &mut H::Memory,
    counters: &mut Counters,
) -> Result<H::Indicators, StepError> {
    for _ in 0..MAX_SWITCHES {
        let indicators = system.indicators(time, x, u, memory);
        let Some(event) = indicators.as_ref().iter().position(|value| *value < 0.0) else {
            return Ok(indicators);
        };
        system.switch(event, time, x, u, memory);
        counters.events += 1;
    }
    Err(StepError::Chattering { time })
}

fn scalar_constant(value: f64) -> Dual<1> {
    Dual { value, slope: [0.0] }
}

/// The fourth root, by correctly rounded square roots so that it has the same bits everywhere.
fn fourth_root(value: f64) -> f64 {
    value.sqrt().sqrt()
}

/// A step that the clock resolves well.
fn smallest_step(time: f64) -> f64 {
    (16.0 * f64::EPSILON * time.abs()).max(1e-15)
}
