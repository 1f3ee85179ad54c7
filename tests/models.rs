//! What holds for every model: the dependencies its table declares, and results that do not depend on how it is stepped.

mod rig;

use std::collections::BTreeSet;

use pneumatic_servo::co_simulation::{Direction, Simulation};
use pneumatic_servo::model::{Model, Start};
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable};

/// The laws of a model; one without a name for a model that has no choice.
fn laws(model: &Model) -> Vec<i32> {
    let law = (model.variables)().iter().find(|variable| variable.name == "friction.law");
    match law.map(|variable| variable.kind) {
        Some(Kind::Enumeration(of)) => of.items.iter().map(|(id, ..)| *id).collect(),
        _ => vec![0],
    }
}

/// A run under a law with inputs away from their start values.
fn running(model: &Model, law: i32) -> Box<dyn Simulation> {
    let variables = (model.variables)();
    let starts = |of: fn(&Variable) -> bool| -> Vec<f64> {
        variables.iter().filter(|variable| of(variable)).filter_map(|variable| variable.start).collect()
    };
    let mut parameters = starts(Variable::is_parameter);
    let place = variables.iter().filter(|v| v.is_parameter()).position(|v| v.name == "friction.law");
    if let Some(place) = place {
        parameters[place] = f64::from(law);
    }
    let inputs: Vec<f64> = starts(|variable| variable.role == Role::Input).iter().map(|u| 1.1 * u + 0.3).collect();
    let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None };
    (model.start)(&start).unwrap_or_else(|error| panic!("{}: {error}", model.name))
}

/// Every derivative that is not zero is declared, at several instants under every law.
#[test]
fn dependencies_are_complete() {
    for model in models::ALL {
        let variables = (model.variables)();
        let computed: Vec<&Variable> = variables.iter().filter(|variable| variable.is_computed()).collect();
        let inputs: Vec<u32> = variables.iter().filter(|v| v.role == Role::Input).map(|v| v.reference).collect();
        let states: Vec<u32> = variables.iter().filter_map(|variable| variable.derivative_of).collect();
        let mut missing = BTreeSet::new();
        for law in laws(model) {
            let mut run = running(model, law);
            for instant in 1..=8 {
                run.advance(f64::from(instant) * 0.05 * model.experiment.stop_time).unwrap();
                for (known, reference) in inputs.iter().chain(&states).enumerate() {
                    let mut seeds = [vec![0.0; inputs.len()], vec![0.0; states.len()]];
                    match known.checked_sub(inputs.len()) {
                        None => seeds[0][known] = 1.0,
                        Some(state) => seeds[1][state] = 1.0,
                    }
                    let mut derivatives = vec![f64::NAN; computed.len()];
                    let direction = Direction { time: 0.0, inputs: &seeds[0], states: &seeds[1] };
                    run.directional_derivative(direction, &mut derivatives);
                    for (variable, derivative) in computed.iter().zip(derivatives) {
                        if derivative != 0.0 && !variable.depends_on.contains(reference) {
                            missing.insert(format!("{} on {reference}", variable.name));
                        }
                    }
                }
            }
        }
        assert!(missing.is_empty(), "{}: {missing:?}", model.name);
    }
}

/// The derivative of each state is the variable that the table says, by central differences between fine steps.
#[test]
fn derivatives_are_those_of_their_states() {
    for model in models::ALL {
        let variables = (model.variables)();
        let computed: Vec<&Variable> = variables.iter().filter(|variable| variable.is_computed()).collect();
        let place = |reference: u32| computed.iter().position(|variable| variable.reference == reference);
        let mut run = running(model, 4);
        let middle = 0.21 * model.experiment.stop_time;
        let size = 1e-6;
        let mut values = [0, 1, 2].map(|_| vec![0.0; computed.len()]);
        for (index, values) in values.iter_mut().enumerate() {
            run.advance(middle + (index as f64 - 1.0) * size).unwrap();
            run.values(values);
        }
        for (index, variable) in computed.iter().enumerate() {
            let Some(state) = variable.derivative_of.and_then(place) else { continue };
            let difference = (values[2][state] - values[0][state]) / (2.0 * size);
            let rate = values[1][index];
            let noise = 1e-15 * values[1][state].abs() / size;
            assert!(
                (rate - difference).abs() <= 1e-4 * rate.abs() + 1e-6 + noise,
                "{} {}: {rate}, not about {difference}",
                model.name,
                variable.name
            );
        }
    }
}

/// Under the default tolerance many communication steps and one give the same end, but for the solver's tolerance.
#[test]
fn end_does_not_depend_on_the_communication_step() {
    for model in models::ALL {
        let computed: Vec<&Variable> = (model.variables)().iter().filter(|variable| variable.is_computed()).collect();
        let end = 0.1 * model.experiment.stop_time;
        let value_after = |steps: u32| {
            let mut run = running(model, 7);
            for step in 1..=steps {
                run.advance(end * f64::from(step) / f64::from(steps)).unwrap();
            }
            let mut values = vec![0.0; computed.len()];
            run.values(&mut values);
            values[0]
        };
        let (one, many) = (value_after(1), value_after(97));
        assert!((one - many).abs() < 1e-6, "{} {}: {one} and {many}", model.name, computed[0].name);
    }
}
