//! An instance and its life: initialization, termination, reset. Values, steps, derivatives and saved states have
//! files of their own.

use super::calls::{Call, State};
use super::failure::Failure;
use super::layout::Layout;
use super::logging::Log;
use super::record::{Experiment, LastStep, Record};
use super::run::Run;
use super::saved_states::SavedStates;

/// An instance of a model.
pub struct Instance {
    pub(super) layout: &'static Layout,
    pub(super) log: Log,
    pub(super) record: Record,
    pub(super) run: Run,
    pub(super) saved: SavedStates,
    pub(super) scratch: Scratch,
}

/// Room for intermediate values, so that calls between steps need no memory of their own.
pub(super) struct Scratch {
    pub(super) parameters: Vec<f64>,
    pub(super) inputs: Vec<f64>,
    pub(super) states: Vec<f64>,
    pub(super) computed: Vec<f64>,
}

impl Instance {
    /// A new instance.
    pub fn new(layout: &'static Layout, log: Log) -> Self {
        Self {
            layout,
            log,
            record: Record::new(layout),
            run: Run::new(layout),
            saved: SavedStates::default(),
            scratch: Scratch {
                parameters: vec![0.0; layout.parameters.len()],
                inputs: vec![0.0; layout.inputs.len()],
                states: vec![0.0; layout.states],
                computed: vec![0.0; layout.computed.len()],
            },
        }
    }

    /// The state of the state machine.
    pub fn state(&self) -> State {
        self.record.state
    }

    /// The log.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// `fmi2SetDebugLogging`.
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Result<(), Failure> {
        self.log.choose(on, categories)
    }

    /// `fmi2SetupExperiment`.
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<(), Failure> {
        self.record.experiment = Some(Experiment::new(start, stop, tolerance)?);
        Ok(())
    }

    /// `fmi2EnterInitializationMode`.
    pub fn enter_initialization_mode(&mut self) -> Result<(), Failure> {
        if self.record.experiment.is_none() {
            self.log.warning(
                Call::EnterInitializationMode,
                "fmi2SetupExperiment was not called: the start time is 0 s, without stop time and tolerance",
            );
        }
        self.record.state = State::Initialization;
        Ok(())
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit_initialization_mode(&mut self) -> Result<(), Failure> {
        self.check_computed()?;
        let time = self.time();
        self.record.last_step = LastStep { failed: false, successful_until: time };
        self.record.state = State::StepComplete;
        self.log.event(Call::ExitInitializationMode, "initialized");
        Ok(())
    }

    /// `fmi2Terminate`.
    pub fn terminate(&mut self) -> Result<(), Failure> {
        self.record.state = State::Terminated;
        self.log.event(Call::Terminate, "terminated");
        Ok(())
    }

    /// `fmi2Reset`: everything is as after `fmi2Instantiate`, except that logging stays as it is and saved states
    /// remain usable.
    pub fn reset(&mut self) -> Result<(), Failure> {
        self.record = Record::new(self.layout);
        self.run.discard();
        self.log.event(Call::Reset, "start values restored");
        Ok(())
    }

    /// Gives the instance up after an internal error.
    pub fn abandon(&mut self, function: &str, cause: &str) -> Failure {
        self.record.state = State::Fatal;
        let failure = Failure::fatal(format!("internal error: {cause}"));
        self.log.failure(function, &failure);
        failure
    }

    /// Current time in s.
    pub(super) fn time(&self) -> f64 {
        self.run.time().unwrap_or(self.record.start().time)
    }

    /// Refuses computed values that are no numbers.
    pub(super) fn check_computed(&mut self) -> Result<(), Failure> {
        let computed = self.run.computed(self.layout, &self.record)?;
        if are_finite(computed) {
            return Ok(());
        }
        let place = computed.iter().position(|value| !value.is_finite()).unwrap_or_default();
        let (name, value) = (&self.layout.computed[place].name, computed[place]);
        let cause = "the parameters and inputs leave the range of the equations";
        Err(Failure::error(format!("{name} is not a finite number but {value}: {cause}")))
    }
}

/// Whether all values are finite numbers, as it is asked after every step: 0 times a number is 0, and 0 times anything
/// else is no number. Four sums are quicker than one, or than a look at each value.
fn are_finite(values: &[f64]) -> bool {
    let (fours, rest) = values.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for four in fours {
        for (sum, value) in sums.iter_mut().zip(four) {
            *sum += 0.0 * value;
        }
    }
    sums.iter().chain(rest).all(|value| value.is_finite())
}
