//! An instance and its life, for all versions of the standard.
//!
//! | file | what it does |
//! |---|---|
//! | `guard` | lets a call into an instance: one at a time, obeying the table, without panics leaving it |
//! | `values`, `arrays`, `steps`, `exchange`, `derivatives`, `dependencies`, `saved_states` | what is done with an instance |
//! | `running_model` | the simulation behind an instance, started and computed when needed |
//! | `record` | what an instance remembers besides the states of its model |
//! | `layout`, `registry` | where the value of each variable is kept; the models of a library by GUID |
//! | `clock` | where a communication step leads, and what is rounding |
//! | `codec` | saved states as bytes |
//! | `log`, `notices` | messages to the host |
//! | `guid` | the GUID |
//! | `variant` | values of a configured FMU, from its resources |

mod arrays;
mod clock;
mod codec;
mod dependencies;
mod derivatives;
mod exchange;
mod guard;
mod guid;
mod layout;
mod log;
mod notices;
mod record;
mod registry;
mod running_model;
mod saved_states;
mod steps;
#[cfg(test)]
mod testing;
mod values;
mod variant;

use std::sync::Arc;

pub use self::exchange::Vector;
pub use self::guard::{Handle, Wanted, instantiate};
pub use self::guid::{guid, guid_of_source};
pub use self::layout::Base;
use self::layout::Layout;
use self::log::Log;
pub use self::log::{LOG_CATEGORIES, LogCategory, Sink};
pub use self::record::Kind;
use self::record::{Experiment, LastStep, Record};
pub use self::registry::Library;
#[cfg(all(feature = "module", target_family = "wasm"))]
pub use self::registry::only;
use self::running_model::RunningModel;
use self::saved_states::SavedStates;
pub use self::variant::Resources;
use crate::calls::Mode;
use crate::failure::Failure;
use pneumatic_servo::variables::Notices;

/// An instance of a model.
pub struct Instance {
    layout: Arc<Layout>,
    log: Log,
    record: Record,
    run: RunningModel,
    saved: SavedStates,
    /// Unusual conditions that have been reported.
    notices: Notices,
    scratch: Scratch,
}

/// Room for intermediate values, so that calls between steps need no memory of their own.
struct Scratch {
    parameters: Vec<f64>,
    /// A direction of differentiation, by time, inputs, states and parameters; the states also for those that the host
    /// sets.
    time: f64,
    inputs: Vec<f64>,
    states: Vec<f64>,
    slopes: Vec<f64>,
    indicators: Vec<f64>,
    computed: Vec<f64>,
    /// Values that a call returns, in the order of the request.
    answers: Vec<f64>,
}

impl Instance {
    /// A new instance.
    fn new(layout: Arc<Layout>, kind: Kind, log: Log) -> Self {
        Self {
            log,
            record: Record::new(&layout, kind),
            run: RunningModel::new(&layout),
            saved: SavedStates::default(),
            notices: Notices::default(),
            scratch: Scratch {
                parameters: vec![0.0; layout.parameters.len()],
                time: 0.0,
                slopes: vec![0.0; layout.parameters.len()],
                inputs: vec![0.0; layout.inputs.len()],
                states: vec![0.0; layout.states],
                indicators: vec![0.0; layout.indicators.len()],
                computed: vec![0.0; layout.computed],
                answers: Vec::with_capacity(layout.table.len()),
            },
            layout,
        }
    }

    /// The mode.
    fn mode(&self) -> Mode {
        self.record.mode
    }

    /// Switches logging on for some categories (for all, if none is named) or off.
    pub fn choose_log(&mut self, on: bool, categories: &[&str]) -> Result<(), Failure> {
        self.log.choose(on, categories)
    }

    /// Sets start time, stop time and tolerance.
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<(), Failure> {
        self.record.experiment = Some(Experiment::new(start, stop, tolerance)?);
        Ok(())
    }

    /// From now on computed values follow parameters and inputs.
    pub fn enter_initialization_mode(&mut self) -> Result<(), Failure> {
        if self.record.experiment.is_none() {
            self.log.warning("no experiment was set up: the start time is 0 s, without stop time and tolerance");
        }
        self.record.mode = Mode::Initialization;
        Ok(())
    }

    /// Starts the run, if the parameters fit together.
    pub fn exit_initialization_mode(&mut self) -> Result<(), Failure> {
        self.check_computed()?;
        let time = self.time();
        self.record.last_step = LastStep { failed: false, successful_until: time };
        self.record.mode = match self.record.kind {
            Kind::CoSimulation => Mode::StepComplete,
            Kind::HybridCoSimulation { .. } => Mode::StepEvent,
            Kind::ModelExchange => {
                self.run.go_outside(&self.layout, &self.record)?;
                Mode::Event
            }
        };
        self.log.event("initialized");
        self.tell_start_values();
        self.tell_notices()
    }

    /// Ends the run.
    pub fn terminate(&mut self) -> Result<(), Failure> {
        self.record.mode = Mode::Terminated;
        self.log.event("terminated");
        Ok(())
    }

    /// Everything is as after instantiation, except that logging stays as it is and saved states remain usable.
    pub fn reset(&mut self) -> Result<(), Failure> {
        self.record = Record::new(&self.layout, self.record.kind);
        self.run.discard();
        self.notices = Notices::default();
        self.log.event("start values restored");
        Ok(())
    }

    /// Gives the instance up after an internal error.
    fn abandon(&mut self, cause: &str) -> Failure {
        self.record.mode = Mode::Fatal;
        let failure = Failure::fatal(format!("internal error: {cause}"));
        self.log.failure(&failure);
        failure
    }

    /// Current time in s.
    fn time(&self) -> f64 {
        self.run.time().unwrap_or_else(|| self.record.start().time)
    }

    /// Refuses computed values that are no numbers.
    fn check_computed(&mut self) -> Result<(), Failure> {
        let computed = self.run.computed(&self.layout, &self.record)?;
        let Some(place) = computed.iter().position(|value| !value.is_finite()) else { return Ok(()) };
        let (name, value) = (self.layout.computed_name(place), computed[place]);
        let cause = "the parameters and inputs leave the range of the equations";
        Err(Failure::error(format!("{name} is not a finite number but {value}: {cause}")))
    }
}
