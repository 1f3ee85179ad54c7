//! A model: its name, its variables and how a run of it starts.

mod experiment;
mod setting;
mod setup;

pub use self::experiment::{Course, Experiment, Signal};
pub(crate) use self::setting::find;
pub use self::setting::{SettingError, Value};
pub use self::setup::Setup;
use crate::co_simulation::Simulation;
use crate::hybrid::Indicator;
use crate::variables::{ParameterError, Table};

/// A model that can be instantiated: its name, its variables and how a run of it starts.
#[derive(Debug)]
pub struct Model {
    /// Name of the model, which is also its FMI model identifier.
    pub name: &'static str,
    /// One line that says what it is.
    pub description: &'static str,
    /// The variable table; made once per process.
    pub variables: fn() -> &'static Table,
    /// The event indicators, in the order of their places: those of all friction laws and modes.
    pub indicators: fn() -> Vec<Indicator>,
    /// Builds a run.
    pub start: fn(&Start) -> Result<Box<dyn Simulation>, ParameterError>,
    /// The default experiment.
    pub experiment: Experiment,
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
