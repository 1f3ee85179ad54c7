//! What the FMI layer sees of a running model: values in table order, time, and nothing of its physics.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::solver::Balance;
use crate::variables::{ParameterError, Variable};

/// A model that can be instantiated: its name, its variables and how a run of it starts.
pub struct Model {
    /// Name of the model, which is also its FMI model identifier.
    pub name: &'static str,
    /// One line that says what it is.
    pub description: &'static str,
    /// The variable table; made once per process.
    pub variables: fn() -> &'static [Variable],
    /// Builds a run.
    pub start: fn(&Start) -> Result<Box<dyn Simulation>, ParameterError>,
    /// The default experiment.
    pub experiment: Experiment,
}

/// The experiment a host should offer by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Stop time in s; the start time is 0.
    pub stop_time: f64,
    /// Communication step size in s.
    pub step_size: f64,
}

/// Everything a run starts from.
#[derive(Clone, Debug)]
pub struct Start<'a> {
    /// Start time in s.
    pub time: f64,
    /// All parameters, in the order in which the table lists them.
    pub parameters: &'a [f64],
    /// All inputs, in the order in which the table lists them.
    pub inputs: &'a [f64],
    /// The tolerance the host asks for; it replaces `solver.relativeTolerance` unless that was changed.
    pub tolerance: Option<f64>,
}

/// A running model.
///
/// Slices of inputs, parameters and computed values follow the order in which the variable table lists the
/// variables of that kind ([`Variable::is_parameter`], [`Variable::is_computed`], inputs).
pub trait Simulation: Send {
    /// Current time in s.
    fn time(&self) -> f64;

    /// Sets the inputs at the current time and their slopes in 1/s, which hold until they are set again.
    ///
    /// Only the last call before the next step counts, and setting what is already set changes nothing.
    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]);

    /// Replaces the tunable parameters; all parameters are given, and fixed ones must be unchanged.
    ///
    /// # Errors
    /// [`ParameterError`] when a value or a combination of values is not legal; nothing is changed then.
    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError>;

    /// Integrates to `end`. Does not allocate.
    ///
    /// # Errors
    /// [`StepError`] when the end cannot be reached; the state is then that of the last accepted solver step.
    fn advance(&mut self, end: f64) -> Result<(), StepError>;

    /// Writes all computed variables, consistent with the current inputs.
    fn values(&self, computed: &mut [f64]);

    /// Writes the derivative of all computed variables with respect to time along the solution.
    fn rates(&self, computed: &mut [f64]);

    /// Writes the derivative of all computed variables in one direction of inputs and continuous states.
    ///
    /// The states are numbered in the order in which the table lists their derivatives
    /// ([`Variable::derivative_of`]).
    fn directional_derivative(&self, inputs: &[f64], states: &[f64], computed: &mut [f64]);

    /// Everything that changes while running, apart from inputs and parameters.
    fn save(&self) -> Snapshot;

    /// Goes back to a snapshot of the same model with the same parameters.
    ///
    /// # Errors
    /// [`SnapshotError`] when the snapshot does not fit; nothing is changed then.
    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError>;
}

/// A saved state, free of pointers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Time in s.
    pub time: f64,
    /// Continuous states.
    pub states: Vec<f64>,
    /// Discrete memory of the model, serialised.
    pub memory: Vec<u8>,
    /// Step size the solver would take next, in s.
    pub step: f64,
    /// The solver's counters.
    pub counters: Counters,
    /// The account of conserved quantities.
    pub balance: Balance,
}

/// What the solver has done since initialization.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Accepted steps.
    pub steps: u64,
    /// Steps rejected because of the error estimate or because a trial state was not admissible.
    pub rejected: u64,
    /// Evaluations of the Jacobian.
    pub jacobians: u64,
    /// Events: break-away, stop of sliding, and all other switches.
    pub events: u64,
}

/// A snapshot that does not fit the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SnapshotError;

impl fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the saved state does not belong to this model with these parameters")
    }
}

impl std::error::Error for SnapshotError {}

/// Why a communication step could not be completed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepError {
    /// The step size fell below what the clock resolves.
    StepSizeTooSmall {
        /// Time in s of the last accepted step.
        time: f64,
    },
    /// The limit of solver steps within one communication step was reached.
    TooManySteps {
        /// Time in s of the last accepted step.
        time: f64,
        /// The limit.
        limit: u64,
    },
    /// The limit of samples within one communication step was reached.
    TooManySamples {
        /// Time in s of the last sample.
        time: f64,
        /// The limit.
        limit: u64,
    },
    /// A fixed-step scheme left the range in which the equations have a meaning.
    Diverged {
        /// Time in s of the last accepted step.
        time: f64,
        /// The step size in s.
        step: f64,
    },
    /// Events followed each other without end at one instant.
    Chattering {
        /// Time in s of the events.
        time: f64,
    },
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StepSizeTooSmall { time } => {
                write!(
                    f,
                    "at t = {time} s no step size meets the tolerance: the equations have no finite solution there"
                )
            }
            Self::TooManySteps { time, limit } => {
                write!(f, "at t = {time} s the limit of {limit} solver steps per communication step was reached")
            }
            Self::TooManySamples { time, limit } => {
                write!(f, "at t = {time} s the limit of {limit} samples per communication step was reached")
            }
            Self::Diverged { time, step } => {
                write!(f, "at t = {time} s the fixed-step scheme diverges: solver.step = {step} s is too large for it")
            }
            Self::Chattering { time } => write!(f, "at t = {time} s events follow each other without end"),
        }
    }
}

impl std::error::Error for StepError {}
