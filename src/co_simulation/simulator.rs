//! Runs any model's equations with the solver, behind the interface the FMI layer sees.

use super::Simulation;
use crate::model_exchange::{Exchange, Exchanger};
use crate::numbers::{Real, Scalar};
use crate::sensitivity::Varied;
#[cfg(feature = "sensitivities")]
use crate::sensitivity::{Along, Column};
use crate::session::{Direction, Session, Snapshot, SnapshotError, Start, check_outputs};
use crate::solver::{Counters, Progress, Run, Settings, StepError};
use crate::system::{Indicator, System};
#[cfg(feature = "sensitivities")]
use crate::system::{LabelledNumber, labelled};
use crate::variables::{Notices, ParameterError};

/// Starts a run of equations, with the smallest of some numbers of states that is enough: the library is compiled for each. One
/// may have a condition.
macro_rules! start_sized {
    ($start:expr, $equations:ty, $inputs:expr, [$($sizes:tt)+]) => {{
        let (equations, settings) = $crate::session::build::<$equations, { $inputs }>($start)?;
        $crate::co_simulation::run_sized!($start, equations, settings, $inputs, [$($sizes)+])
    }};
}

/// The same of equations that are built.
macro_rules! run_sized {
    ($start:expr, $equations:expr, $settings:expr, $inputs:expr, [$($states:expr $(=> $when:expr)?),+]) => {'run: {
        let (equations, settings) = ($equations, $settings);
        $crate::session::check::<_, { $inputs }>(&equations)?;
        let states = $crate::system::System::<{ $inputs }>::states(&equations);
        $(
            if true $(&& $when)? && states <= $states {
                break 'run $crate::co_simulation::AnyRun::make::<_, { $states }, { $inputs }>(equations, settings, $start);
            }
        )+
        Err($crate::variables::ParameterError::new("states", states as f64, "the model is compiled for fewer"))
    }};
}

/// The most bytes that a serialized [`Snapshot`] of equations with at most a number of states takes. A number takes at most a quarter
/// more of them than in memory, where it is written with 7 bits in a byte, and a choice takes one that memory may do without.
pub const fn snapshot_size<E: System<U>, const U: usize>(states: usize) -> usize {
    size_of::<f64>() * states + size_of::<(E::Memory<Real>, Progress, f64)>() / 4 * 5 + 128
}

pub(crate) use {run_sized, start_sized};

/// A run of equations: plain, or in numbers with derivatives. Each size of the vector of states is compiled for both.
pub trait AnyRun: Sized {
    /// A run of equations from their start; `N` is the number of their states, or more.
    ///
    /// # Errors
    /// [`ParameterError`] when the equations write other variables than the table lists, or there are no runs with slopes.
    fn make<E: System<U>, const N: usize, const U: usize>(
        equations: E,
        settings: Settings,
        start: &Start,
    ) -> Result<Self, ParameterError>;
}

impl AnyRun for Box<dyn Simulation> {
    fn make<E: System<U>, const N: usize, const U: usize>(
        equations: E,
        settings: Settings,
        start: &Start,
    ) -> Result<Self, ParameterError> {
        Ok(Box::new(Simulator::<E, N, U>::new(equations, settings, start)?))
    }
}

impl AnyRun for Box<dyn Varied> {
    #[cfg(feature = "sensitivities")]
    fn make<E: System<U>, const N: usize, const U: usize>(
        equations: E,
        settings: Settings,
        start: &Start,
    ) -> Result<Self, ParameterError> {
        Ok(Box::new(super::varied::VariedRun::<E, N, U>::new(equations, settings, start)))
    }

    #[cfg(not(feature = "sensitivities"))]
    fn make<E: System<U>, const N: usize, const U: usize>(
        _equations: E,
        _settings: Settings,
        _start: &Start,
    ) -> Result<Self, ParameterError> {
        Err(ParameterError::new("slopes", 0.0, "this library is compiled without the feature sensitivities"))
    }
}

/// A model's equations in motion.
pub struct Simulator<E: System<U>, const N: usize, const U: usize> {
    /// Boxed: a run has kilobytes, which would be copied over the stack of the importer.
    pub(super) run: Box<Run<E, N, U>>,
    pub(super) session: Session,
    /// The point to go back to.
    #[cfg(feature = "sensitivities")]
    kept: Option<Box<SavedState<E::Memory<Real>, N>>>,
}

/// States, memory and progress of a run, and the time on the clock of the host.
#[cfg(feature = "sensitivities")]
struct SavedState<M, const N: usize> {
    x: [Real; N],
    memory: M,
    progress: Progress,
    time: f64,
}

impl<E: System<U>, const N: usize, const U: usize> Simulator<E, N, U> {
    /// A run of equations from their start; `N` is the number of their states, or more.
    ///
    /// # Errors
    /// [`ParameterError`] when the equations write other variables than the table lists.
    // A frame on the stack of its own, for each size: one for all of them would take hundreds of kilobytes.
    #[inline(never)]
    pub fn new(equations: E, settings: Settings, start: &Start) -> Result<Self, ParameterError> {
        let u = inputs(start.inputs);
        let begin = begin(&equations, &Real::all(&u));
        check_outputs(&equations, &begin.0.map(Real::value), &u, &begin.1)?;
        let mut run = Run::boxed(equations, settings, begin, Real::all(&u));
        run.set_clock(start.time);
        Ok(Self {
            run,
            session: Session::begin::<E, U>(start),
            #[cfg(feature = "sensitivities")]
            kept: None,
        })
    }

    /// The present inputs.
    pub(super) fn inputs(&self) -> [f64; U] {
        self.run.inputs().0.map(Real::value)
    }

    /// Writes the derivatives of the computed variables in a direction of time, states, inputs and parameters.
    fn differentiate(&self, seeds: (f64, [f64; N], [f64; U]), slopes: &[f64], computed: &mut [f64]) {
        let (time, states, inputs) = seeds;
        let u = self.inputs();
        self.run.consistent(|x, memory| {
            let at = (self.run.time(), &x.map(Real::value), &u, memory);
            self.session.differentiate(self.run.system(), at, (time, &states, &inputs), slopes, computed);
        });
    }
}

impl<E: System<U>, const N: usize, const U: usize> Simulation for Simulator<E, N, U> {
    fn time(&self) -> f64 {
        self.session.time
    }

    fn elapsed(&self) -> f64 {
        self.run.time()
    }

    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        self.run.set_inputs(Real::all(&inputs(values)), inputs(slopes));
    }

    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        self.run.replace_system(self.session.retune(parameters)?);
        Ok(())
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        let outcome = self.run.advance(end - self.session.start);
        self.session.time = if outcome.is_ok() { end } else { self.session.start + self.run.time() };
        outcome.map_err(|error| error.later(self.session.start))
    }

    fn step(&mut self, size: f64) -> Result<(), StepError> {
        let outcome = self.run.advance(self.run.time() + size);
        self.session.time = self.session.start + self.run.time();
        outcome.map_err(|error| error.later(self.session.start))
    }

    fn is_finite(&self) -> bool {
        self.run.state().0.iter().all(|state| state.value.is_finite())
    }

    fn advance_to_event(&mut self, end: f64) -> Result<bool, StepError> {
        let duration = end - self.session.start;
        let outcome = self.run.advance_to_event(duration);
        self.session.time = if self.run.time() < duration { self.session.start + self.run.time() } else { end };
        outcome.map_err(|error| error.later(self.session.start))
    }

    fn update(&mut self) -> Result<(), StepError> {
        let ((x, memory), progress) = (self.run.state(), self.run.progress());
        let (x, mut memory) = (*x, memory.clone());
        self.run.update().map_err(|error| {
            self.run.restore(x, &mut memory, progress);
            error.later(self.session.start)
        })
    }

    fn indicators(&self, indicators: &mut [f64]) {
        let events = self.run.indicators();
        let (own, kinks) = indicators.split_at_mut(events.as_ref().len());
        own.iter_mut().zip(events.as_ref()).for_each(|(slot, event)| *slot = event.value);
        self.run.system().kinks(&self.run.state().0.map(Real::value), kinks);
        // Each is on the side on which it is.
        kinks.iter_mut().for_each(|kink| *kink = kink.abs());
    }

    fn values(&self, computed: &mut [f64]) {
        let u = self.inputs();
        let (own, rest) = computed.split_at_mut(computed.len() - Counters::COUNT - E::RESIDUALS);
        let (residuals, counters) = rest.split_at_mut(E::RESIDUALS);
        let system = self.run.system();
        self.run.consistent(|x, memory| {
            self.session.outputs(system, (self.run.time(), &x.map(Real::value), &u, memory), own);
        });
        residuals.copy_from_slice(&self.run.residuals()[..E::RESIDUALS]);
        self.run.counters().write(counters);
    }

    fn at_hand(&self, places: &[usize], values: &mut [f64]) -> bool {
        let (system, (x, memory)) = (self.run.system(), self.run.state());
        let written =
            |(place, slot): (&usize, &mut f64)| system.at_hand(*place, x, memory).map(|number| *slot = number.value);
        self.run.is_settled() && places.iter().zip(values).all(|it| written(it).is_some())
    }

    fn rates(&self, computed: &mut [f64]) {
        let (u, slopes) = self.run.inputs();
        let (system, time) = (self.run.system(), Real::of(self.run.time()));
        let derivatives = self.run.consistent(|x, memory| system.derivatives(time, x, &u, memory));
        self.differentiate((1.0, derivatives.map(Real::value), slopes), &[], computed);
    }

    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]) {
        let mut states = [0.0; N];
        for (reference, seed) in self.session.table.states().zip(direction.states) {
            if let Some(index) = self.run.system().state_at(reference, N) {
                states[index] = *seed;
            }
        }
        let seeds = (direction.time, states, inputs(direction.inputs));
        self.differentiate(seeds, direction.parameters, computed);
    }

    fn move_state(&mut self, state: usize, value: f64) -> bool {
        let Some(index) = self.state_index(state) else { return false };
        let ((x, memory), progress) = (self.run.state(), self.run.progress());
        let (mut x, mut memory) = (*x, memory.clone());
        x[index] = Real::of(value);
        self.run.restore(x, &mut memory, progress);
        true
    }

    fn state_index(&self, state: usize) -> Option<usize> {
        let reference = self.session.table.states().nth(state)?;
        self.run.system().state_at(reference, N)
    }

    #[cfg(feature = "sensitivities")]
    fn move_states(&mut self, states: &[f64]) {
        let ((x, memory), progress) = (self.run.state(), self.run.progress());
        let (mut x, mut memory) = (*x, memory.clone());
        for (reference, value) in self.session.table.states().zip(states) {
            if let Some(index) = self.run.system().state_at(reference, N) {
                x[index] = Real::of(*value);
            }
        }
        self.run.restore(x, &mut memory, progress);
    }

    #[cfg(feature = "sensitivities")]
    fn states(&self, states: &mut [f64]) {
        for (reference, slot) in self.session.table.states().zip(states) {
            if let Some(index) = self.run.system().state_at(reference, N) {
                *slot = self.run.state().0[index].value;
            }
        }
    }

    #[cfg(feature = "sensitivities")]
    fn memory_numbers(&self) -> Vec<LabelledNumber> {
        labelled(self.run.state().1, |fields| self.run.system().state_label(fields))
    }

    #[cfg(feature = "sensitivities")]
    fn begin_trail(&mut self) {
        self.run.begin_trail();
    }

    #[cfg(feature = "sensitivities")]
    fn end_trail(
        &mut self,
        along: &[Along],
        beside: &[(&dyn Varied, usize)],
        outputs: &[usize],
    ) -> Option<Vec<Option<Column>>> {
        self.columns_of_trail(along, beside, outputs)
    }

    #[cfg(feature = "sensitivities")]
    fn keep(&mut self) {
        let ((x, memory), progress, time) = (self.run.state(), self.run.progress(), self.session.time);
        match &mut self.kept {
            Some(kept) => {
                (kept.x, kept.progress, kept.time) = (*x, progress, time);
                kept.memory.clone_from(memory);
            }
            None => self.kept = Some(Box::new(SavedState { x: *x, memory: memory.clone(), progress, time })),
        }
    }

    #[cfg(feature = "sensitivities")]
    fn go_back(&mut self) {
        if let Some(SavedState { x, memory, progress, time }) = self.kept.as_deref() {
            self.run.restore(*x, &mut memory.clone(), *progress);
            self.session.time = *time;
        }
    }

    fn log_events(&mut self) {
        self.run.log_events();
    }

    fn logged_events(&self) -> Vec<(f64, &'static str)> {
        let (run, start) = (&self.run, self.session.start);
        run.logged_events().iter().map(|(time, event)| (start + time, run.system().event_name(*event))).collect()
    }

    fn notices(&self) -> Notices {
        self.run.system().notices(&self.inputs())
    }

    fn exchange(&self, indicators: Vec<Indicator>) -> Option<Box<dyn Exchange>> {
        let (run, (x, memory)) = (&self.run, self.run.state());
        let at = (run.time(), x.map(Real::value), memory, self.inputs());
        Some(Exchanger::new((run.system().clone(), self.session.clone()), at, indicators))
    }

    fn save(&self) -> Snapshot {
        let (x, memory) = self.run.state();
        self.session.save(self.run.system(), &x.map(Real::value), (memory, self.run.progress(), self.session.start))
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let (states, (mut memory, progress, start)) = snapshot.read::<_, (Box<E::Memory<Real>>, Progress, f64), N, U>(
            self.run.system(),
            &self.run.state().0.map(Real::value),
        )?;
        // The clocks of host and run agree but for rounding: of their difference, of the last step, which may
        // end at an event one rounding behind the end, and of the sum.
        let rounding = f64::EPSILON * (2.0 * progress.time().abs() + snapshot.time.abs());
        let is_timely = (start + progress.time() - snapshot.time).abs() <= rounding;
        if !is_timely {
            return Err(SnapshotError::Clock { time: snapshot.time });
        }
        if !progress.is_sound(self.run.indicators().as_ref().len()) || !System::fits::<Real>(self.run.system(), &memory)
        {
            return Err(SnapshotError::Foreign);
        }
        self.run.restore(Real::all(&states), &mut memory, progress);
        self.run.set_clock(start);
        (self.session.start, self.session.time) = (start, snapshot.time);
        Ok(())
    }
}

/// Start of a run of equations.
#[inline(never)]
fn begin<E: System<U>, const N: usize, const U: usize>(
    equations: &E,
    u: &[Real; U],
) -> Box<([Real; N], E::Memory<Real>)> {
    Box::new(equations.start(u))
}

fn inputs<const U: usize>(values: &[f64]) -> [f64; U] {
    std::array::from_fn(|i| values[i])
}
