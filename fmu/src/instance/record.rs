//! The record of an instance: all that it keeps besides the states of its model.

use serde::{Deserialize, Serialize};

use super::layout::Layout;
use crate::calls::Mode;
use crate::failure::Failure;
use pneumatic_servo::model::{Seeds, Start};

/// The experiment as the host asks for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start time in s.
    pub start: f64,
    /// Stop time in s, if there is one.
    pub stop: Option<f64>,
    /// Tolerance, if the host has one.
    pub tolerance: Option<f64>,
}

impl Experiment {
    /// Checks the experiment that the importer asks for.
    pub fn new(start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Result<Self, Failure> {
        if let Some(tolerance) = tolerance.filter(|tolerance| !(tolerance.is_finite() && *tolerance > 0.0)) {
            return Err(Failure::error(format!("the tolerance must be positive and finite, not {tolerance}")));
        }
        if !start.is_finite() {
            return Err(Failure::error(format!("the start time must be finite, not {start} s")));
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            let reason = format!("must be finite and not before the start time {start} s");
            return Err(Failure::error(format!("the stop time {stop} s {reason}")));
        }
        Ok(Self { start, stop, tolerance })
    }
}

/// End of the last communication step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LastStep {
    /// Whether it could not be completed.
    pub failed: bool,
    /// The time in s up to which all is well.
    pub successful_until: f64,
}

/// Where the solver is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// Inside: co-simulation, with all events handled inside too.
    CoSimulation,
    /// Inside: co-simulation with event mode, in which inputs may jump.
    HybridCoSimulation {
        /// Whether steps end at events, so that the host can react.
        returns_early: bool,
    },
    /// Outside: model exchange.
    ModelExchange,
}

/// Everything that a reset and a restored state set, apart from the model's own states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Where the solver is, for the whole life of an instance.
    pub kind: Kind,
    /// The mode.
    pub mode: Mode,
    /// The experiment, once it is set up.
    pub experiment: Option<Experiment>,
    /// The parameters, in the order of the table.
    pub parameters: Vec<f64>,
    /// The inputs, in the order of the table.
    pub inputs: Vec<f64>,
    /// The slopes of the inputs in the next step.
    pub slopes: Vec<f64>,
    /// The end of the last step, or of the initialization.
    pub last_step: LastStep,
}

impl Record {
    /// The record of a new instance.
    pub fn new(layout: &Layout, kind: Kind) -> Self {
        Self {
            kind,
            mode: Mode::Instantiated,
            experiment: None,
            parameters: layout.parameters.clone(),
            inputs: layout.inputs.clone(),
            slopes: vec![0.0; layout.inputs.len()],
            last_step: LastStep::default(),
        }
    }

    /// Whether a simulation has been started for good, so that parameters are in use.
    pub fn is_running(&self) -> bool {
        !matches!(self.mode, Mode::Instantiated | Mode::Initialization | Mode::Fatal)
    }

    /// Start values of a simulation.
    pub fn start(&self) -> Start<'_> {
        let experiment = self.experiment.unwrap_or_default();
        Start {
            time: experiment.start,
            parameters: &self.parameters,
            inputs: &self.inputs,
            tolerance: experiment.tolerance,
            seeds: Seeds::NONE,
        }
    }
}
