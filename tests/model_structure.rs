//! The dependencies that the tables declare, compared with derivatives and with differences: at initialization and
//! between steps, under every law and on every rig.

mod cases;

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use pneumatic_servo::co_simulation::{Direction, Simulation};
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Table, Variable};

use cases::{Changes, cases, start};

/// Pairs of value references: a computed variable, and a known on which it depends.
type Pairs = BTreeSet<(u32, u32)>;

fn declared(table: &Table) -> Pairs {
    table.computed().flat_map(|it| it.depends_on.iter().map(|known| (it.reference, *known))).collect()
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
/// then only what is true or false counts. The equations of a mode are what the dependencies are about.
fn by_differences(table: &Table, simulation: &mut dyn Simulation, inputs: &[f64], found: &mut Pairs) {
    let is_flag = |variable: &Variable| variable.kind == Kind::Boolean;
    let count = table.computed().count();
    let (mut before, mut after, still) = (vec![0.0; count], vec![0.0; count], vec![0.0; inputs.len()]);
    simulation.set_inputs(inputs, &still);
    simulation.values(&mut before);
    for (place, input) in table.inputs().enumerate() {
        for difference in [1e-3, -1e-3, 0.3, -0.3, 30.0, -30.0] {
            let mut changed = inputs.to_vec();
            changed[place] += difference * input.nominal.unwrap_or(1.0);
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

/// All pairs that are found in a case, by seven looks in a run with moving inputs.
fn found(model: &Model, changes: &Changes) -> Pairs {
    let table = (model.variables)();
    let mut found = Pairs::new();
    let (mut simulation, _, starts) = start(model, changes);
    let duration = (0.1 * model.experiment.stop_time).min(1.0);
    for look in 0..7 {
        let phase = TAU * f64::from(look) / 6.0;
        let inputs: Vec<f64> = table
            .inputs()
            .zip(&starts)
            .map(|(input, start)| start + 0.7 * input.nominal.unwrap_or(1.0) * phase.sin())
            .collect();
        by_differences(table, simulation.as_mut(), &inputs, &mut found);
        by_derivatives(table, simulation.as_ref(), &mut found);
        let end = duration * f64::from(look + 1) / 7.0;
        simulation.advance(end).unwrap_or_else(|error| panic!("{} {changes:?}: {error}", model.name));
    }
    found
}

fn names(table: &Table, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<String> {
    let name = |reference| &table.by_reference(reference).expect("a variable").variable.name;
    pairs.map(|(unknown, known)| format!("{} on {}", name(unknown), name(known))).collect()
}

#[test]
fn declared_dependencies_are_those_that_derivatives_and_differences_show() {
    let mut never = Vec::new();
    for model in models::ALL {
        let table = (model.variables)();
        let declared = declared(table);
        let mut all = Pairs::new();
        for case in cases(model) {
            let found = found(model, &case);
            let missing = names(table, found.difference(&declared).copied());
            assert!(missing.is_empty(), "{}: not declared by `depends_on`: {missing:#?}, in {case:?}", model.name);
            all.extend(found);
        }
        // What is true or false has no derivative: on what it depends beyond the inputs no host can try.
        let is_real =
            |reference: u32| matches!(table.by_reference(reference).expect("a variable").variable.kind, Kind::Real(_));
        let is_input = |known: u32| table.inputs().any(|input| input.reference == known);
        let shown = |(unknown, known): &&(u32, u32)| is_real(*unknown) || is_input(*known);
        let of_model = names(table, declared.difference(&all).filter(shown).copied());
        never.extend(of_model.into_iter().map(|pair| format!("{}: {pair}", model.name)));
    }
    assert!(never.is_empty(), "declared by `depends_on`, without effect: {never:#?}");
}

#[test]
fn knowns_are_inputs_states_and_time() {
    for model in models::ALL {
        let table = (model.variables)();
        let is_known = |reference: u32| {
            let entry = table.by_reference(reference).expect("a variable");
            entry.state.is_some() || matches!(entry.variable.role, Role::Input | Role::Time)
        };
        for variable in table {
            assert!(variable.depends_on.iter().all(|known| is_known(*known)), "{} {}", model.name, variable.name);
        }
    }
}

/// At initialization states follow from inputs, if they do, and nothing else of the inputs enters.
#[test]
fn initial_values_follow_from_the_inputs_that_are_declared() {
    for model in models::ALL {
        let table = (model.variables)();
        for case in cases(model) {
            let values_at = |changes: &Changes| {
                let mut values = vec![0.0; table.computed().count()];
                start(model, changes).0.values(&mut values);
                values
            };
            let before = values_at(&case);
            for input in table.inputs() {
                let start = input.start.expect("a start value");
                for difference in [1e-3, -1e-3, 0.3, -0.3, 30.0, -30.0] {
                    let changed = [(input.name.as_str(), start + difference * input.nominal.unwrap_or(1.0))];
                    let after = values_at(&case.iter().copied().chain(changed).collect());
                    for (variable, _) in table.computed().zip(before.iter().zip(&after)).filter(differ) {
                        let declared = table.initial_dependencies(variable);
                        let name = &variable.name;
                        assert!(
                            declared.contains(&input.reference),
                            "{}: {name} follows from {} at first, which is not declared, in {case:?}",
                            model.name,
                            input.name
                        );
                    }
                }
            }
        }
    }
}

/// While the input pushes the play of the valve, the spool's acceleration has the slope of the side that is pushed, also
/// after the play has followed; inside the play it has none.
#[test]
fn spool_follows_the_voltage_while_it_pushes_the_play() {
    let model = models::find("PneumaticServoCylinder").expect("a model");
    let table = (model.variables)();
    let (mut simulation, _, mut inputs) = start(model, &Changes::new());
    let still = vec![0.0; inputs.len()];
    let place = table.computed().position(|variable| variable.name == "der(valve.spoolVelocity)").expect("a variable");
    let mut values = vec![0.0; table.computed().count()];
    for step in 1..=50 {
        inputs[0] = 5.0 + 0.02 * f64::from(step);
        simulation.set_inputs(&inputs, &still);
        simulation.advance(1e-3 * f64::from(step)).expect("a step");
    }
    let mut slope_at = |voltage: f64| {
        let mut inputs = inputs.clone();
        inputs[0] = voltage;
        simulation.set_inputs(&inputs, &still);
        let mut seeds = vec![0.0; inputs.len()];
        seeds[0] = 1.0;
        let states = vec![0.0; table.number_of_states()];
        let direction = Direction { time: 0.0, inputs: &seeds, states: &states, parameters: &[] };
        simulation.directional_derivative(direction, &mut values);
        values[place]
    };
    // wn^2/5: the command has the slope 1/5.
    let expected = (TAU * 115.0).powi(2) / 5.0;
    for voltage in [6.0, 6.01] {
        assert!((slope_at(voltage) / expected - 1.0).abs() < 1e-12, "{} at {voltage} V", slope_at(voltage));
    }
    assert_eq!(slope_at(5.99), 0.0);
}
