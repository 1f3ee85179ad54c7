//! A model: its name, its variables and how a run of it starts.

mod experiment;
#[cfg(feature = "sensitivities")]
mod observer;
mod plant;

mod setup;
mod transition;
mod trim;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

pub use self::experiment::{Course, Experiment, Panel, Signal};
#[cfg(feature = "sensitivities")]
pub(crate) use self::observer::SavedObserver;
#[cfg(feature = "sensitivities")]
pub use self::observer::{Method, Observed, Observer, ObserverError};
pub use self::plant::{Plant, Saved};
pub use self::setup::Setup;
pub use self::transition::Steps;
pub use self::trim::{Given, TrimError};
use crate::co_simulation::start_sized;
use crate::co_simulation::{Simulation, snapshot_size};
use crate::sensitivity::Varied;
pub use crate::session::{Seeds, Start};
use crate::system::{Indicator, System, assert_sound, indicators, references, shared_table, table};
use crate::variables::{ParameterError, StateSet, Table, Variable, units};
pub use crate::variables::{SettingError, Value};

/// A model that can be instantiated: its name, its variables and how a run of it starts.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Name of the model, which is also its FMI model identifier.
    pub name: &'static str,
    /// Description in one line.
    pub description: &'static str,
    /// The default experiment.
    pub experiment: Experiment,
    /// Functions of the model.
    #[doc(hidden)]
    pub functions: Functions,
}

/// A model as functions.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Functions {
    /// The variable table; made once per process.
    pub table: fn() -> &'static Table,
    /// The same for those that hold it only while they run, so that a library leaves nothing behind when it is unloaded.
    pub shared_table: fn() -> Arc<Table>,
    /// The most bytes that a serialized [`Snapshot`](crate::co_simulation::Snapshot) of a run takes.
    pub snapshot_size: usize,
    /// The event indicators of all friction laws and modes, in order.
    pub indicators: fn() -> Vec<Indicator>,
    /// Builds a run.
    pub start: fn(&Start) -> Result<Box<dyn Simulation>, ParameterError>,
    /// Builds one in numbers with slopes.
    pub vary: fn(&Start) -> Result<Box<dyn Varied>, ParameterError>,
}

impl Functions {
    /// The functions of a model with `U` inputs, whose runs have at most `most` states.
    pub const fn of<E: System<U>, const U: usize>(
        most: usize,
        start: fn(&Start) -> Result<Box<dyn Simulation>, ParameterError>,
        vary: fn(&Start) -> Result<Box<dyn Varied>, ParameterError>,
    ) -> Self {
        Self {
            table: table::<E, U>,
            shared_table: shared_table::<E, U>,
            snapshot_size: snapshot_size::<E, U>(most),
            indicators: indicators::<E, U>,
            start,
            vary,
        }
    }
}

impl Model {
    /// The model of equations with `U` inputs, run with `N` states: as many as they have. Too few, and events that say too little
    /// of themselves, are refused when it is compiled; places to spare cost time, and change no bit.
    pub const fn of<E: System<U>, const U: usize, const N: usize>(
        name: &'static str,
        description: &'static str,
        experiment: Experiment,
    ) -> Self {
        const {
            assert!(N >= E::State::OTHERS, "the model has more states than the library is to be compiled for");
            assert_sound::<E, U>();
        }
        let functions =
            Functions::of::<E, U>(N, |start| start_sized!(start, E, U, [N]), |start| start_sized!(start, E, U, [N]));
        Self { name, description, experiment, functions }
    }

    /// The variables; the table is made once per process.
    pub fn table(&self) -> &'static Table {
        (self.functions.table)()
    }

    /// The same table for whoever holds it only while it runs, so that a library leaves nothing behind when it is unloaded.
    #[doc(hidden)]
    pub fn shared_table(&self) -> Arc<Table> {
        (self.functions.shared_table)()
    }

    /// The most bytes that a serialized [`Snapshot`](crate::co_simulation::Snapshot) of a run takes.
    #[doc(hidden)]
    pub const fn snapshot_size(&self) -> usize {
        self.functions.snapshot_size
    }

    /// The event indicators of all friction laws and modes, in order.
    pub fn indicators(&self) -> Vec<Indicator> {
        (self.functions.indicators)()
    }

    /// Builds a run; where a default does not fit the given values, the refusal says that it is a default.
    ///
    /// # Errors
    /// [`ParameterError`] when parameters do not fit together.
    pub fn begin(&self, start: &Start) -> Result<Box<dyn Simulation>, ParameterError> {
        (self.functions.start)(start).map_err(|error| self.with_default_named(error))
    }

    /// Start values of the continuous states under the defaults, by the value references of their variables.
    ///
    /// # Errors
    /// [`ParameterError`] when the defaults do not fit together.
    pub fn default_starts(&self) -> Result<BTreeMap<u32, f64>, ParameterError> {
        let table = self.shared_table();
        let default = |variable: &Variable| variable.start.unwrap_or_default();
        let (parameters, inputs): (Vec<f64>, Vec<f64>) =
            (table.parameters().map(default).collect(), table.inputs().map(default).collect());
        self.starts_with(&parameters, &inputs)
    }

    /// The same under other parameters and inputs, given in the order of the table.
    ///
    /// # Errors
    /// [`ParameterError`] when they do not fit together.
    pub fn starts_with(&self, parameters: &[f64], inputs: &[f64]) -> Result<BTreeMap<u32, f64>, ParameterError> {
        let table = self.shared_table();
        let run = self.begin(&Start { time: 0.0, parameters, inputs, tolerance: None, seeds: Seeds::NONE })?;
        let mut values = vec![0.0; table.computed().count()];
        run.values(&mut values);
        let all = table.computed().map(|variable| variable.reference).zip(values);
        let states: BTreeSet<u32> = table.states().collect();
        Ok(all.filter(|(reference, _)| states.contains(reference)).collect())
    }

    /// The variables, continuous states with their start values under the defaults.
    ///
    /// # Errors
    /// As [`default_starts`](Self::default_starts).
    pub fn started_variables(&self) -> Result<Vec<Variable>, ParameterError> {
        let starts = self.default_starts()?;
        let started = |variable: &Variable| {
            let start = variable.start.or_else(|| starts.get(&variable.reference).copied());
            Variable { start, ..variable.clone() }
        };
        Ok(self.shared_table().iter().map(started).collect())
    }

    #[cold]
    fn with_default_named(&self, mut error: ParameterError) -> ParameterError {
        let table = self.shared_table();
        let entry = table.find(&error.variable);
        if entry.is_some_and(|entry| entry.variable.start == Some(error.value)) {
            error.reason += &format!("; this is its default: give {}, too", error.variable);
        }
        if let Some(hint) = entry.and_then(|entry| entry.variable.meant_beyond(error.value)) {
            error.reason += &hint;
        }
        error
    }

    /// The event indicators as variables, scaled as in model exchange ([`seen`](crate::model_exchange::seen)).
    /// They are no part of the table, since nothing else needs them.
    pub fn indicator_variables(&self) -> Vec<Variable> {
        let indicators = self.indicators().into_iter().zip(references::INDICATORS..);
        let variable = |(Indicator { name, text, .. }, reference)| {
            let text = format!("Event indicator, 1 without use; below 0: {text}");
            Variable::output(reference, &name, units::ONE).local().text(&text)
        };
        indicators.map(variable).collect()
    }
}
