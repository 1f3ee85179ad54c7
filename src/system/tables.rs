//! The variables of a model, and the table that is made of them.

use std::any::TypeId;
use std::sync::Arc;

use super::{Counters, IndicatorSet, MAX_KINKS, System, Tuning};
use crate::numbers::Real;
use crate::variables::{Meaning, ParameterError, Role, Table, Variable, table_cache};

/// Value references that the models have in common; those below 400 and from 1001 on are each model's own. From 20 000 on are
/// the numbers that stand for enumerations, from 60 000 on the states that laws name.
pub mod references {
    /// The independent variable, time.
    pub const TIME: u32 = 0;
    /// The states of the first contact; further contacts follow. References from 400 on once had other meanings.
    pub const CONTACT: u32 = 460;
    /// The parameters of the solver.
    pub const SOLVER: u32 = 5_000;
    /// The counters of the solver.
    pub const COUNTERS: u32 = 5_100;
    /// The event indicators, where they are variables.
    pub const INDICATORS: u32 = 6_000;
    /// The friction law and its parameters.
    pub const FRICTION: u32 = 10_000;
}

/// The variables of a model, by their roles. Time, the solver's counters and its parameters come with every model.
#[derive(Clone, Debug)]
pub struct Tables {
    /// The inputs.
    pub inputs: Vec<Variable>,
    /// Outputs, states and their rates, in the order in which [`System::outputs`] writes them; residuals last.
    pub computed: Vec<Variable>,
    /// The parameters, in the order in which [`System::new`] takes their values.
    pub parameters: Vec<Variable>,
}

impl Tables {
    /// Variable in the wrong list, or missing, for equations with a number of inputs.
    fn problem(&self, inputs: usize) -> Option<ParameterError> {
        let stray = |list: &[Variable], belongs: fn(&Variable) -> bool, what: &str| {
            let stray = list.iter().find(|variable| !belongs(variable))?;
            Some(ParameterError::new(
                &stray.name,
                stray.reference.into(),
                &format!("it is among the {what}, but none of them"),
            ))
        };
        let counted = |inputs| {
            let reason = format!("the equations have {inputs}, not this number of the table");
            ParameterError::new("inputs", self.inputs.len() as f64, &reason)
        };
        stray(&self.inputs, |it| it.role == Role::Input, "inputs")
            .or_else(|| stray(&self.computed, Variable::is_computed, "computed variables"))
            .or_else(|| stray(&self.parameters, Variable::is_parameter, "parameters"))
            .or_else(|| (self.inputs.len() != inputs).then(|| counted(inputs)))
    }
}

/// The table of a model, made once per process.
pub fn table<E: System<U>, const U: usize>() -> &'static Table {
    table_cache::lent(TypeId::of::<E>(), make::<E, U>)
}

/// The table of a model for those that hold it only while they run.
pub fn shared_table<E: System<U>, const U: usize>() -> Arc<Table> {
    table_cache::shared(TypeId::of::<E>(), make::<E, U>)
}

fn make<E: System<U>, const U: usize>() -> Table {
    let tables = E::tables();
    let problem = tables.problem(E::INPUTS).or_else(indicators_without_description::<E, U>);
    let Tables { inputs, computed, parameters } = tables;
    let solving = Tuning::grouped(references::SOLVER).into_iter().map(|it| it.meaning(Meaning::Solving));
    let mut all = vec![Variable::time()];
    all.extend(inputs);
    all.extend(computed);
    all.extend(Counters::table(references::COUNTERS));
    all.extend(parameters);
    all.extend(solving);
    Table::new(all).with_problem(problem)
}

/// Indicators and kinks without description.
fn indicators_without_description<E: System<U>, const U: usize>() -> Option<ParameterError> {
    let (events, told, kinks) =
        (E::Indicators::<Real>::unused().as_ref().len(), E::indicator_list().len(), E::kink_list().len());
    if events != told {
        let reason = format!("the list of events has {told}, the equations this number");
        return Some(ParameterError::new("indicators", events as f64, &reason));
    }
    let reason = format!("there may be {MAX_KINKS}");
    (kinks > MAX_KINKS).then(|| ParameterError::new("kinks", kinks as f64, &reason))
}

/// Name of the variable of a model that is a state, by its index among `n` states.
#[cfg(feature = "names")]
pub fn state_name<E: System<U>, const U: usize>(equations: &E, state: usize, n: usize) -> &'static str {
    let table = shared_table::<E, U>();
    let reference = table.states().find(|reference| equations.state_at(*reference, n) == Some(state));
    let entry = reference.and_then(|reference| table.by_reference(reference));
    entry.map_or("an internal state", |entry| table_cache::lent_name(&entry.variable.name))
}

/// The same without the table, which would be compiled for the name alone.
#[cfg(not(feature = "names"))]
pub fn state_name<E: System<U>, const U: usize>(_: &E, _: usize, _: usize) -> &'static str {
    "a state"
}
