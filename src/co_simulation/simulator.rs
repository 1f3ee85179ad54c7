//! Runs any model's equations with the solver, behind the interface the FMI layer sees.

use crate::co_simulation::{Direction, Simulation, Snapshot, SnapshotError};
use crate::model::{Model, Start};
use crate::model_exchange::{Exchange, Exchanger};
use crate::models::equations::{Equations, differentiate, differentiate_varied};
use crate::solver::{Counters, StepError};
use crate::solver::{Progress, Run, Settings};
use crate::variables::{Notices, ParameterError, Variable};

/// The solver's counters as variables; every model's table ends with them. Value references from `base`.
pub fn counters_table(base: u32) -> Vec<Variable> {
    let texts = [
        ("steps", "Accepted solver steps since initialization"),
        ("rejectedSteps", "Rejected solver steps since initialization"),
        ("jacobians", "Evaluations of the Jacobian since initialization"),
        ("events", "Events since initialization: break-away, stop of sliding and all other switches"),
    ];
    let counters = texts.iter().zip(0..);
    counters.map(|((name, text), index)| Variable::counter(index, name).text(text).within("solver", base)).collect()
}

/// How many they are.
pub(crate) const COUNTERS: usize = 4;

/// Writes them.
pub(crate) fn write_counters(counters: Counters, slots: &mut [f64]) {
    let Counters { steps, rejected, jacobians, events } = counters;
    for (slot, count) in slots.iter_mut().zip([steps, rejected, jacobians, events]) {
        // FMI integers have 32 bits; a run that exceeds them shows the largest.
        *slot = f64::from(i32::try_from(count).unwrap_or(i32::MAX));
    }
}

/// Builds equations from all parameters of a model, which vary with slopes or (without any) not at all, and the solver
/// settings of a run.
pub type Build<E> = fn(&Start, slopes: &[f64]) -> Result<(E, Settings), ParameterError>;

/// A model's equations in motion.
pub struct Simulator<E: Equations<N, U>, const N: usize, const U: usize> {
    run: Run<E, N, U>,
    build: Build<E>,
    /// All parameters, in the order of the table.
    parameters: Vec<f64>,
    /// Clock of the host in s at the start. The run counts its time from there, so that late clocks, which resolve
    /// microseconds or less, cost no accuracy.
    start: f64,
    /// Clock of the host in s now: exactly as it said.
    time: f64,
}

impl<E: Equations<N, U>, const N: usize, const U: usize> Simulator<E, N, U> {
    /// A simulator that starts from given states and memory.
    pub fn new(build: Build<E>, start: &Start, x: [f64; N], memory: E::Memory) -> Result<Self, ParameterError> {
        let (equations, settings) = build(start, &[])?;
        let run = Run::new(equations, settings, 0.0, x, memory, inputs(start.inputs));
        Ok(Self { run, build, parameters: start.parameters.to_vec(), start: start.time, time: start.time })
    }

    /// The equations for parameters that vary with slopes.
    fn build(&self, parameters: &[f64], slopes: &[f64]) -> Result<E, ParameterError> {
        let (inputs, _) = self.run.inputs();
        let start = Start { time: self.start, parameters, inputs: &inputs, tolerance: None };
        (self.build)(&start, slopes).map(|(equations, _)| equations)
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

impl<E: Equations<N, U> + Clone + Send + 'static, const N: usize, const U: usize> Simulation for Simulator<E, N, U> {
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
        indicators.copy_from_slice(self.run.indicators().as_ref());
    }

    fn values(&self, computed: &mut [f64]) {
        let (u, _) = self.run.inputs();
        let (own, rest) = computed.split_at_mut(computed.len() - COUNTERS - E::RESIDUALS);
        let (residuals, counters) = rest.split_at_mut(E::RESIDUALS);
        self.run.consistent(|x, memory| self.run.system().outputs(self.run.time(), x, &u, memory, own));
        residuals.copy_from_slice(&self.run.residuals()[..E::RESIDUALS]);
        write_counters(self.run.counters(), counters);
    }

    fn at_hand(&self, place: usize) -> Option<f64> {
        let (x, memory) = self.run.state();
        self.run.is_settled().then(|| self.run.system().at_hand(place, x, memory))?
    }

    fn rates(&self, computed: &mut [f64]) {
        let (u, slopes) = self.run.inputs();
        let derivatives =
            self.run.consistent(|x, memory| self.run.system().derivatives(self.run.time(), x, &u, memory));
        self.differentiate(None, (1.0, derivatives, slopes), computed);
    }

    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]) {
        let mut states = [0.0; N];
        for (reference, seed) in E::table().states().zip(direction.states) {
            if let Some(index) = self.run.system().state_at(reference) {
                states[index] = *seed;
            }
        }
        let seeds = (direction.time, states, inputs(direction.inputs));
        let varied = varied(direction.parameters)
            .map(|slopes| self.build(&self.parameters, slopes).expect("parameters that have been accepted"));
        self.differentiate(varied.as_ref(), seeds, computed);
    }

    fn notices(&self) -> Notices {
        let (u, _) = self.run.inputs();
        self.run.system().notices(&u)
    }

    fn state_index(&self, state: usize) -> Option<usize> {
        let reference = E::table().states().nth(state)?;
        self.run.system().state_at(reference)
    }

    fn exchange(&self, model: &Model) -> Option<Box<dyn Exchange>> {
        let (run, (u, _)) = (&self.run, self.run.inputs());
        let (x, memory) = run.state();
        let (equations, indicators) = (run.system().clone(), (model.indicators)());
        let at = (run.time(), *x, memory.clone(), u);
        let parameters = self.parameters.clone();
        Some(Box::new(Exchanger::new((equations, self.build, parameters), at, (model.variables)(), indicators)))
    }

    fn save(&self) -> Snapshot {
        let (x, memory) = self.run.state();
        let memory =
            postcard::to_allocvec(&(memory, self.run.progress(), self.start)).expect("a memory holds plain data");
        Snapshot { time: self.time, states: x.to_vec(), memory }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let states: [f64; N] = snapshot.states.as_slice().try_into().map_err(|_| SnapshotError)?;
        let (memory, progress, start): (E::Memory, Progress, f64) =
            postcard::from_bytes(&snapshot.memory).map_err(|_| SnapshotError)?;
        let is_plain = states.iter().all(|value| value.is_finite()) && start.is_finite();
        // The clock of the host and that of the run agree but for rounding: that of their difference when the run came here,
        // `EPSILON/2*(|start| + |time|)` at most, and that of the sum below, `EPSILON/2*|time|`.
        let rounding = f64::EPSILON * (start.abs() + snapshot.time.abs());
        let is_timely = (start + progress.time() - snapshot.time).abs() <= rounding;
        if !is_plain
            || !progress.is_sound(self.run.indicators().as_ref().len())
            || !is_timely
            || !self.run.system().fits(&memory)
        {
            return Err(SnapshotError);
        }
        self.run.restore(states, memory, progress);
        (self.start, self.time) = (start, snapshot.time);
        Ok(())
    }
}

/// The slopes of parameters, if any varies.
pub(crate) fn varied(slopes: &[f64]) -> Option<&[f64]> {
    slopes.iter().any(|slope| *slope != 0.0).then_some(slopes)
}

fn inputs<const U: usize>(values: &[f64]) -> [f64; U] {
    std::array::from_fn(|i| values[i])
}
