//! Co-simulation of a model: a host sees values in table order and the time, nothing of the physics.

mod embedded;
mod simulator;
#[cfg(feature = "sensitivities")]
mod smooth;
#[cfg(feature = "sensitivities")]
mod varied;

#[doc(hidden)]
pub use self::embedded::Embedded;
#[doc(hidden)]
pub use self::simulator::{AnyRun, Simulator, snapshot_size};
pub(crate) use self::simulator::{run_sized, start_sized};
use crate::model_exchange::Exchange;
use crate::sensitivity::{Along, Column, Varied};
pub use crate::session::{Direction, Snapshot, SnapshotError};
use crate::solver::StepError;
use crate::system::{Indicator, LabelledNumber};
use crate::variables::{Notices, ParameterError};

/// A running model.
///
/// Slices of inputs, parameters and computed values follow the order in which the variable table lists the
/// variables of that kind ([`Table`](crate::variables::Table)).
pub trait Simulation: Send {
    /// Current time in s.
    fn time(&self) -> f64;

    /// Time in s that steps of a size are added to: since the start of the run, where it counts from there.
    fn elapsed(&self) -> f64 {
        self.time()
    }

    /// Sets the inputs at the current time and their slopes in 1/s, which hold until they are set again.
    ///
    /// Only the last call before the next step counts; equal values change nothing.
    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]);

    /// Replaces the tunable parameters; all parameters are given, and fixed ones must be unchanged.
    ///
    /// # Errors
    /// [`ParameterError`] when a value or a combination of values is not legal; nothing is changed then.
    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError>;

    /// Integrates to `end`. Does not allocate.
    ///
    /// # Errors
    /// [`StepError`] when the end cannot be reached; the state is then the last accepted one.
    fn advance(&mut self, end: f64) -> Result<(), StepError>;

    /// Integrates over a step of a size in s, which the clock of the host need not resolve. Does not allocate.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn step(&mut self, size: f64) -> Result<(), StepError> {
        self.advance(self.time() + size)
    }

    /// Whether everything that is carried on from step to step is a finite number.
    fn is_finite(&self) -> bool;

    /// Integrates to `end`, or to the first event on the way and no further; tells whether there is one. It has not
    /// happened yet then: it happens with the next [`update`](Self::update), or else when the run goes on. Events by a
    /// jump of an input, and samples, do not stop it. A model without events never stops.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn advance_to_event(&mut self, end: f64) -> Result<bool, StepError> {
        self.advance(end).map(|()| false)
    }

    /// Lets the event happen that has stopped the run, and those that the present inputs set off.
    ///
    /// # Errors
    /// [`StepError`] when events follow each other without end; nothing is changed then.
    fn update(&mut self) -> Result<(), StepError> {
        Ok(())
    }

    /// Writes the event indicators as the model lists them, each in its own unit and exactly 0 at its event. Indicators of
    /// [kinks](crate::system::System::kinks), which change no mode, are never negative.
    ///
    /// A model without events has nothing to write.
    fn indicators(&self, _indicators: &mut [f64]) {}

    /// Writes all computed variables, consistent with the current inputs.
    fn values(&self, computed: &mut [f64]);

    /// Writes the computed variables in some places, if all of them are known without an evaluation of the equations, and tells
    /// whether they are.
    fn at_hand(&self, _places: &[usize], _values: &mut [f64]) -> bool {
        false
    }

    /// Writes the derivative of all computed variables with respect to time along the solution.
    fn rates(&self, computed: &mut [f64]);

    /// Writes the derivative of all computed variables in a direction of time, inputs, continuous states and tunable
    /// parameters, exact to rounding.
    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]);

    /// The index of a continuous state, numbered as in a [`Direction`], in the vector that is integrated, if it is in there.
    ///
    /// A model without continuous states has nothing to say.
    fn state_index(&self, _state: usize) -> Option<usize> {
        None
    }

    /// Moves a continuous state, numbered as in a [`Direction`], to a finite value, at the present time and with the present
    /// modes; tells whether it is integrated. Nothing is changed if it is not.
    fn move_state(&mut self, _state: usize, _value: f64) -> bool {
        false
    }

    /// Moves all continuous states that are integrated, as [`move_state`](Self::move_state) does one. Does not allocate.
    #[cfg(feature = "sensitivities")]
    fn move_states(&mut self, _states: &[f64]) {}

    /// Writes the continuous states that are integrated, numbered as in a [`Direction`].
    #[cfg(feature = "sensitivities")]
    fn states(&self, _states: &mut [f64]) {}

    /// The numbers of the memory that are told as states of a transition.
    fn memory_numbers(&self) -> Vec<LabelledNumber> {
        Vec::new()
    }

    /// Leaves a trail from here on, for the columns of the next step.
    fn begin_trail(&mut self) {}

    /// Ends the trail, and gives the columns by states, inputs and numbers of the memory at its start, and behind them by parameters of
    /// runs beside this one in as many directions each, with some of the outputs, given by their places; nothing where the step has
    /// not been smooth, or for a run that has other states.
    fn end_trail(
        &mut self,
        _along: &[Along],
        _beside: &[(&dyn Varied, usize)],
        _outputs: &[usize],
    ) -> Option<Vec<Option<Column>>> {
        None
    }

    /// Remembers the present point, inputs apart, in place of the one before. Does not allocate but at first.
    #[cfg(feature = "sensitivities")]
    fn keep(&mut self) {}

    /// Goes back to the point that is remembered, if there is one. Does not allocate.
    #[cfg(feature = "sensitivities")]
    fn go_back(&mut self) {}

    /// Logs the events from here on. Steps then allocate.
    fn log_events(&mut self) {}

    /// Times in s and names of the events that are logged: of located ones, and of those that a jump of an input sets off.
    ///
    /// A model without events has none.
    fn logged_events(&self) -> Vec<(f64, &'static str)> {
        Vec::new()
    }

    /// Warnings about the parameters and the present inputs; usually none.
    fn notices(&self) -> Notices {
        Notices::default()
    }

    /// The model, whose indicators are given again, at the present states, for model exchange; nothing if it has no continuous
    /// states, so that no solver is needed.
    fn exchange(&self, _indicators: Vec<Indicator>) -> Option<Box<dyn Exchange>> {
        None
    }

    /// Everything that changes while running, apart from inputs and parameters.
    fn save(&self) -> Snapshot;

    /// Goes back to a snapshot of the same model with the same parameters.
    ///
    /// # Errors
    /// [`SnapshotError`] when the snapshot does not fit; nothing is changed then.
    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError>;
}
