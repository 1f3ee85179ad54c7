//! Runs any model's equations with the solver, behind the interface the FMI layer sees.

use super::differentiate::{differentiate, differentiate_varied};
use super::{Direction, Simulation, Snapshot, SnapshotError};
use crate::model::{Model, Start};
use crate::model_exchange::{Exchange, Exchanger};
use crate::sensitivity::{Equations, Erased};
use crate::solver::{Counters, Mark, Progress, Run, Settings, StepError, Tuning};
use crate::system::{MAX_KINKS, Shortcuts, System, table};
use crate::variables::{Notices, ParameterError, ParameterSet, StateSet, Table, Values};

/// Reads what equations are made of from all parameters of a model, which vary with slopes or (without any) not at all, and the
/// solver settings of a run.
///
/// # Errors
/// [`ParameterError`] when values that are legal one by one do not fit together, or the table of the model has a problem.
pub fn read<E: System<U>, const U: usize, P>(
    start: &Start,
    slopes: &[f64],
    read: impl FnOnce(&mut Values) -> Result<P, ParameterError>,
) -> Result<(P, Settings), ParameterError> {
    let table = table::<E, U>();
    if let Some(problem) = table.problem() {
        return Err(problem.clone());
    }
    let values = table.chosen(start.parameters, slopes);
    let (own, tuning) = values.split_at(values.len() - Tuning::LEN);
    let mut own = Values::new(own);
    let parts = read(&mut own)?;
    if own.left() > 0 {
        let reason = "so many values of the table are left by the equations";
        return Err(ParameterError::new("parameters", own.left() as f64, reason));
    }
    Ok((parts, Settings::new(&Tuning::read(tuning)?, start.tolerance)))
}

/// Builds equations and the solver settings of a run in the same way.
///
/// # Errors
/// As [`read`].
pub fn build<E: System<U>, const U: usize>(start: &Start, slopes: &[f64]) -> Result<(E, Settings), ParameterError> {
    let (equations, settings) = read::<E, U, E>(start, slopes, E::new)?;
    let keeps_balance = equations.keeps_balance();
    Ok((equations, settings.keeping_balance(keeps_balance)))
}

/// Checks that a run can begin with equations: every state has a magnitude and a rate, every indicator is told of.
///
/// # Errors
/// [`ParameterError`] with the name of a state that has none, or that counts indicators.
pub fn check<E: System<U>, const U: usize>(equations: &E) -> Result<(), ParameterError> {
    let (events, told) = (E::Indicators::default().as_ref().len(), E::indicator_list().len());
    if events != told {
        let reason = format!("the equations have so many, and tell of {told}");
        return Err(ParameterError::new("indicators", events as f64, &reason));
    }
    if E::kink_list().len() > MAX_KINKS {
        let reason = format!("there may be {MAX_KINKS}");
        return Err(ParameterError::new("kinks", E::kink_list().len() as f64, &reason));
    }
    for state in E::State::ALL {
        // Models that count references from elsewhere have a state several times, or leave it out: a trolley that is not there.
        let (n, reference) = (equations.states(), state.reference());
        let is_counted_here = equations.state_at(reference, n) == Some(state.at(n));
        if is_counted_here && !table::<E, U>().states().any(|other| other == reference) {
            let reason = "no variable is the derivative of this state";
            return Err(ParameterError::new("the value reference", reference.into(), reason));
        }
        let scale = state.scale(equations.parameters());
        if !(scale.is_finite() && scale > 0.0) {
            let table = table::<E, U>();
            let reference = table.states().find(|reference| E::State::of(*reference) == Some(*state));
            let name = reference.and_then(|reference| table.by_reference(reference)).map(|entry| &*entry.variable.name);
            let name = format!("the magnitude of {}", name.unwrap_or("a state without a variable"));
            return Err(ParameterError::new(&name, scale, "it must be a positive number"));
        }
    }
    Ok(())
}

/// Checks that the equations write as many values as the table has computed variables.
fn check_outputs<E: System<U>, const N: usize, const U: usize>(
    equations: &E,
    x: &[f64; N],
    u: &[f64; U],
    memory: &E::Memory,
) -> Result<(), ParameterError> {
    // No arithmetic yields this number.
    const UNWRITTEN: f64 = f64::from_bits(0x7ff8_0000_dead_beef);
    let listed = table::<E, U>().computed().count() - Counters::COUNT - E::RESIDUALS;
    let mut computed = vec![UNWRITTEN; 2 * listed + 100];
    equations.outputs(0.0, x, u, memory, &mut computed);
    let is_written = |value: &f64| value.to_bits() != UNWRITTEN.to_bits();
    let written = computed.iter().filter(|value| is_written(value)).count();
    // What is not there may be filled with zeros, to the end of whatever room there is.
    let is_complete = written == listed || written == computed.len();
    if is_complete && computed[..listed].iter().all(is_written) {
        return Ok(());
    }
    let reason = format!("the table has so many, the equations write {written}");
    Err(ParameterError::new("computed variables", listed as f64, &reason))
}

/// Starts a run of equations, with the smallest of some numbers of states that is enough: the library is compiled for each. One
/// may have a condition.
#[doc(hidden)]
#[macro_export]
macro_rules! start_sized {
    ($start:expr, $equations:ty, $inputs:expr, [$($sizes:tt)+]) => {{
        let (equations, settings) = $crate::co_simulation::build::<$equations, { $inputs }>($start, &[])?;
        $crate::run_sized!($start, equations, settings, $inputs, [$($sizes)+])
    }};
}

/// The same of equations that are built.
#[doc(hidden)]
#[macro_export]
macro_rules! run_sized {
    ($start:expr, $equations:expr, $settings:expr, $inputs:expr, [$($states:expr $(=> $when:expr)?),+]) => {'run: {
        let (equations, settings) = ($equations, $settings);
        $crate::co_simulation::check::<_, { $inputs }>(&equations)?;
        let states = $crate::system::System::states(&equations);
        $(
            if true $(&& $when)? && states <= $states {
                let run = $crate::co_simulation::Simulator::<_, { $states }, { $inputs }>::new(equations, settings, $start)?;
                break 'run Ok(Box::new(run) as Box<dyn $crate::co_simulation::Simulation>);
            }
        )+
        Err($crate::variables::ParameterError::new("states", states as f64, "the model is compiled for fewer"))
    }};
}

/// A model's equations in motion.
pub struct Simulator<E: Shortcuts<U>, const N: usize, const U: usize> {
    run: Run<E, N, U>,
    table: &'static Table,
    /// All parameters, in the order of the table.
    parameters: Vec<f64>,
    /// Clock of the host in s at the start. The run counts its time from there, so that late clocks, which resolve
    /// microseconds or less, cost no accuracy.
    start: f64,
    /// Clock of the host in s now: exactly as it said.
    time: f64,
}

impl<E: Shortcuts<U>, const N: usize, const U: usize> Simulator<E, N, U> {
    /// A run of equations from their start; `N` is the number of their states, or more.
    ///
    /// # Errors
    /// [`ParameterError`] when the equations write other variables than the table lists.
    pub fn new(equations: E, settings: Settings, start: &Start) -> Result<Self, ParameterError> {
        let u = inputs(start.inputs);
        let (x, memory) = equations.start(&u);
        check_outputs(&equations, &x, &u, &memory)?;
        let run = Run::new(equations, settings, 0.0, x, memory, u);
        let (table, parameters) = (table::<E, U>(), start.parameters.to_vec());
        Ok(Self { run, table, parameters, start: start.time, time: start.time })
    }

    /// The equations for parameters that vary with slopes.
    fn build(&self, parameters: &[f64], slopes: &[f64]) -> Result<E, ParameterError> {
        let (inputs, _) = self.run.inputs();
        let start = Start { time: self.start, parameters, inputs: &inputs, tolerance: None };
        build(&start, slopes).map(|(equations, _)| equations)
    }

    /// Writes the derivatives of the computed variables in a direction of time, states and inputs, and of the parameters
    /// that vary in other equations of the model, if there are any.
    fn differentiate(
        &self,
        varied: Option<&E>,
        (time, states, slopes): (f64, [f64; N], [f64; U]),
        computed: &mut [f64],
    ) {
        let (u, _) = self.run.inputs();
        self.run.consistent(|x, memory| {
            let (at, seeds) = ((self.run.time(), x, &u, memory), (time, &states, &slopes));
            match varied {
                None => differentiate(self.run.system(), at, seeds, computed),
                Some(equations) => differentiate_varied(equations, at, seeds, computed),
            }
        });
    }
}

impl<E: Shortcuts<U>, const N: usize, const U: usize> Simulation for Simulator<E, N, U> {
    fn time(&self) -> f64 {
        self.time
    }

    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        self.run.set_inputs(inputs(values), inputs(slopes));
    }

    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError> {
        self.run.replace_system(self.build(parameters, &[])?);
        self.parameters.copy_from_slice(parameters);
        Ok(())
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        let outcome = self.run.advance(end - self.start);
        self.time = if outcome.is_ok() { end } else { self.start + self.run.time() };
        outcome.map_err(|error| error.later(self.start))
    }

    fn is_finite(&self) -> bool {
        self.run.state().0.iter().all(|value| value.is_finite())
    }

    fn advance_to_event(&mut self, end: f64) -> Result<bool, StepError> {
        let duration = end - self.start;
        let outcome = self.run.advance_to_event(duration);
        self.time = if self.run.time() < duration { self.start + self.run.time() } else { end };
        outcome.map_err(|error| error.later(self.start))
    }

    fn update(&mut self) -> Result<(), StepError> {
        let ((x, memory), progress) = (self.run.state(), self.run.progress());
        let (x, memory) = (*x, memory.clone());
        self.run.update().map_err(|error| {
            self.run.restore(x, memory, progress);
            error.later(self.start)
        })
    }

    fn indicators(&self, indicators: &mut [f64]) {
        let events = self.run.indicators();
        let (own, kinks) = indicators.split_at_mut(events.as_ref().len());
        own.copy_from_slice(events.as_ref());
        self.run.system().kinks(self.run.state().0, kinks);
        // Each is on the side on which it is.
        kinks.iter_mut().for_each(|kink| *kink = kink.abs());
    }

    fn values(&self, computed: &mut [f64]) {
        let (u, _) = self.run.inputs();
        let (own, rest) = computed.split_at_mut(computed.len() - Counters::COUNT - E::RESIDUALS);
        let (residuals, counters) = rest.split_at_mut(E::RESIDUALS);
        self.run.consistent(|x, memory| self.run.system().outputs(self.run.time(), x, &u, memory, own));
        residuals.copy_from_slice(&self.run.residuals()[..E::RESIDUALS]);
        self.run.counters().write(counters);
    }

    fn at_hand(&self, place: usize) -> Option<f64> {
        let (x, memory) = self.run.state();
        self.run.is_settled().then(|| self.run.system().at_hand(place, x, memory))?
    }

    fn rates(&self, computed: &mut [f64]) {
        let (u, slopes) = self.run.inputs();
        let derivatives =
            self.run.consistent(|x, memory| System::derivatives(self.run.system(), self.run.time(), x, &u, memory));
        self.differentiate(None, (1.0, derivatives, slopes), computed);
    }

    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]) {
        let mut states = [0.0; N];
        for (reference, seed) in self.table.states().zip(direction.states) {
            if let Some(index) = self.run.system().state_at(reference, N) {
                states[index] = *seed;
            }
        }
        let seeds = (direction.time, states, inputs(direction.inputs));
        let varied = varied(direction.parameters)
            .map(|slopes| self.build(&self.parameters, slopes).expect("parameters that have been accepted"));
        self.differentiate(varied.as_ref(), seeds, computed);
    }

    fn equations(&self) -> Option<Box<dyn Equations>> {
        let (_, memory) = self.run.state();
        let (equations, computed) = (self.run.system().clone(), table::<E, U>().computed().count());
        Some(Box::new(Erased::<E, N, U> { equations, memory: memory.clone(), computed }))
    }

    fn leave_trail(&mut self, leaves: bool) {
        self.run.leave_trail(leaves);
    }

    fn place(&self) -> Option<(f64, Vec<f64>, f64)> {
        Some((self.run.time(), self.run.state().0.to_vec(), self.run.settings().tolerance))
    }

    fn take_trail(&mut self) -> Vec<Mark> {
        self.run.take_trail()
    }

    fn notices(&self) -> Notices {
        let (u, _) = self.run.inputs();
        self.run.system().notices(&u)
    }

    fn state_index(&self, state: usize) -> Option<usize> {
        let reference = self.table.states().nth(state)?;
        self.run.system().state_at(reference, N)
    }

    fn exchange(&self, model: &Model) -> Option<Box<dyn Exchange>> {
        let (run, (u, _)) = (&self.run, self.run.inputs());
        let (x, memory) = run.state();
        let (equations, indicators) = (run.system().clone(), (model.indicators)());
        let at = (run.time(), *x, memory.clone(), u);
        let (equations, clock) = ((equations, self.parameters.clone()), (self.start, self.time));
        Some(Box::new(Exchanger::new(equations, clock, at, (model.variables)(), indicators)))
    }

    fn save(&self) -> Snapshot {
        let (x, memory) = self.run.state();
        let memory =
            postcard::to_allocvec(&(memory, self.run.progress(), self.start)).expect("a memory holds plain data");
        Snapshot { time: self.time, states: saved_states(self.run.system(), x), memory }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let states = restored_states(self.run.system(), &snapshot.states, self.run.state().0)?;
        let (memory, progress, start): (E::Memory, Progress, f64) =
            postcard::from_bytes(&snapshot.memory).map_err(|_| SnapshotError)?;
        let is_plain = states.iter().all(|value| value.is_finite()) && start.is_finite();
        // The clock of the host and that of the run agree but for rounding: of their difference, of the last step, which may
        // end at an event one rounding behind the end, and of the sum.
        let rounding = f64::EPSILON * (2.0 * progress.time().abs() + snapshot.time.abs());
        let is_timely = (start + progress.time() - snapshot.time).abs() <= rounding;
        if !is_plain
            || !progress.is_sound(self.run.indicators().as_ref().len())
            || !is_timely
            || !System::fits(self.run.system(), &memory)
        {
            return Err(SnapshotError);
        }
        self.run.restore(states, memory, progress);
        (self.start, self.time) = (start, snapshot.time);
        Ok(())
    }
}

/// The states that are used.
pub(crate) fn saved_states<E: System<U>, const N: usize, const U: usize>(equations: &E, x: &[f64; N]) -> Vec<f64> {
    let unused = equations.unused(N);
    [&x[..unused.start], &x[unused.end..]].concat()
}

/// The same in their places, among others that stay as they are. States of a run of this size that were saved with those are
/// taken, too.
pub(crate) fn restored_states<E: System<U>, const N: usize, const U: usize>(
    equations: &E,
    saved: &[f64],
    x: &[f64; N],
) -> Result<[f64; N], SnapshotError> {
    if let Ok(all) = saved.try_into() {
        return Ok(all);
    }
    let unused = equations.unused(N);
    if saved.len() + unused.len() != N {
        return Err(SnapshotError);
    }
    let (before, behind) = saved.split_at(unused.start);
    let mut states = *x;
    states[..unused.start].copy_from_slice(before);
    states[unused.end..].copy_from_slice(behind);
    Ok(states)
}

/// The slopes of parameters, if any varies.
pub(crate) fn varied(slopes: &[f64]) -> Option<&[f64]> {
    slopes.iter().any(|slope| *slope != 0.0).then_some(slopes)
}

fn inputs<const U: usize>(values: &[f64]) -> [f64; U] {
    std::array::from_fn(|i| values[i])
}
