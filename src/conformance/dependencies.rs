//! The dependencies that a table declares, compared with derivatives and with differences.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::{described, duration, moved, started};
use crate::co_simulation::{Direction, Simulation};
use crate::model::Setup;
use crate::solver::StepError;
use crate::variables::{Kind, ParameterError, Table, Variable};

/// Pairs of value references: a computed variable, and a known on which it depends.
type Pairs = BTreeSet<(u32, u32)>;

/// Demands that the variables of a model have their declared dependences and no others, under settings of one model that together
/// show all.
///
/// # Panics
/// When a variable has an undeclared dependency, or a declared one without effect under all settings.
pub fn dependencies(settings: &[Setup]) {
    let Some(first) = settings.first() else { return };
    let table = first.table();
    let mut all = Pairs::new();
    settings.iter().for_each(|setup| all.extend(found_dependencies(setup)));
    // Booleans have no derivative: their dependencies beyond the inputs cannot be tried by a host.
    let is_real =
        |reference: u32| matches!(table.by_reference(reference).expect("a variable").variable.kind, Kind::Real(_));
    let is_input = |known: u32| table.inputs().any(|input| input.reference == known);
    let shown = |(unknown, known): &&(u32, u32)| is_real(*unknown) || is_input(*known);
    let never = names(table, declared(table).difference(&all).filter(shown).copied());
    assert!(never.is_empty(), "{}: declared by `depends_on`, without effect: {never:#?}", first.model().name);
}

/// All pairs found, a variable and its dependency, by seven evaluations in a run with moving inputs.
///
/// # Panics
/// When one of them is not declared.
pub fn found_dependencies(setup: &Setup) -> Pairs {
    let mut found = Pairs::new();
    find(setup, started(setup).as_mut(), &mut found).unwrap_or_else(|error| panic!("{}: {error}", described(setup)));
    let missing = undeclared(setup.table(), &found);
    assert!(missing.is_empty(), "{}: not declared by `depends_on`: {missing:#?}", described(setup));
    found
}

/// Undeclared dependencies found, as `der(velocity) on pressure`. A run that fails counts up to its failure.
///
/// # Errors
/// [`ParameterError`] when the parameters do not fit together.
pub fn undeclared_dependencies(setup: &Setup) -> Result<Vec<String>, ParameterError> {
    let (mut found, mut run) = (Pairs::new(), setup.simulation(0.0)?);
    find(setup, run.as_mut(), &mut found).ok();
    Ok(undeclared(setup.table(), &found))
}

/// Adds the dependencies found by seven evaluations in a run.
fn find(setup: &Setup, run: &mut dyn Simulation, found: &mut Pairs) -> Result<(), StepError> {
    let (table, duration) = (setup.table(), duration(setup));
    for look in 0..7 {
        let inputs = moved(setup, (TAU * f64::from(look) / 6.0).sin());
        by_differences(table, run, &inputs, found);
        by_derivatives(table, run, found);
        run.advance(duration * f64::from(look + 1) / 7.0)?;
    }
    Ok(())
}

fn undeclared(table: &Table, found: &Pairs) -> Vec<String> {
    let declares = |(unknown, _): &&(u32, u32)| {
        table.by_reference(*unknown).is_some_and(|entry| entry.variable.depends_on.is_some())
    };
    names(table, found.difference(&declared(table)).filter(declares).copied())
}

/// Declared dependencies; variables that declare nothing depend on everything, which needs no look.
fn declared(table: &Table) -> Pairs {
    let of = |it: &Variable| it.depends_on.iter().flatten().map(|known| (it.reference, *known)).collect::<Vec<_>>();
    table.computed().flat_map(of).collect()
}

/// The pairs whose derivative is not zero here.
fn by_derivatives(table: &Table, simulation: &dyn Simulation, found: &mut Pairs) {
    let knowns: Vec<u32> =
        [0].into_iter().chain(table.inputs().map(|input| input.reference)).chain(table.states()).collect();
    let (inputs, mut derivatives) = (table.inputs().count(), vec![0.0; table.computed().count()]);
    for (place, known) in knowns.iter().enumerate() {
        let mut seeds = vec![0.0; knowns.len()];
        seeds[place] = 1.0;
        let direction =
            Direction { time: seeds[0], inputs: &seeds[1..=inputs], states: &seeds[1 + inputs..], parameters: &[] };
        simulation.directional_derivative(direction, &mut derivatives);
        let depends = table.computed().zip(&derivatives).filter(|(_, derivative)| **derivative != 0.0);
        found.extend(depends.map(|(variable, _)| (variable.reference, *known)));
    }
}

/// The pairs whose value changes here when an input changes, little or much.
///
/// A change that sets off an event may move any number (a mass that Karnopp's band held shows its momentum at once):
/// then only Booleans count. Dependencies belong to the equations of a mode.
fn by_differences(table: &Table, simulation: &mut dyn Simulation, inputs: &[f64], found: &mut Pairs) {
    let is_flag = |variable: &Variable| variable.kind == Kind::Boolean;
    let count = table.computed().count();
    let (mut before, mut after, still) = (vec![0.0; count], vec![0.0; count], vec![0.0; inputs.len()]);
    simulation.set_inputs(inputs, &still);
    simulation.values(&mut before);
    for (place, input) in table.inputs().enumerate() {
        for difference in [1e-3, -1e-3, 0.3, -0.3, 30.0, -30.0] {
            let mut changed = inputs.to_vec();
            changed[place] = input.nearest(changed[place] + difference * input.nominal.unwrap_or(1.0));
            simulation.set_inputs(&changed, &still);
            simulation.values(&mut after);
            let pairs = table.computed().zip(before.iter().zip(&after));
            let depends: Vec<&Variable> = pairs.filter(differ).map(|(variable, _)| variable).collect();
            let is_event = depends.iter().any(|variable| is_flag(variable));
            let depends = depends.iter().filter(|variable| !is_event || is_flag(variable));
            found.extend(depends.map(|variable| (variable.reference, input.reference)));
        }
    }
    simulation.set_inputs(inputs, &still);
}

/// Whether two values differ by more than rounding.
fn differ((variable, (before, after)): &(&Variable, (&f64, &f64))) -> bool {
    let magnitude = before.abs().max(variable.nominal.unwrap_or(1.0));
    (*before - *after).abs() > 1e-12 * magnitude || (before != after && variable.kind == Kind::Boolean)
}

fn names(table: &Table, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<String> {
    let name = |reference| &table.by_reference(reference).expect("a variable").variable.name;
    pairs.map(|(unknown, known)| format!("{} on {}", name(unknown), name(known))).collect()
}
