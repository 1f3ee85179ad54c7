//! What holds for every model: derivatives of its states, and results that do not depend on how it is stepped.

mod rig;

use pneumatic_servo::co_simulation::Simulation;
use pneumatic_servo::model::{Model, Start};
use pneumatic_servo::models;
use pneumatic_servo::variables::{Role, Variable};

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

/// Under the default tolerance many communication steps and one give the same end, but for the solver's tolerance: all
/// states agree to 1 ppm of their nominal values or of themselves.
#[test]
fn end_does_not_depend_on_the_communication_step() {
    for model in models::ALL {
        let table = (model.variables)();
        let end = 0.1 * model.experiment.stop_time;
        let values_after = |steps: u32| {
            let mut run = running(model, 7);
            for step in 1..=steps {
                run.advance(end * f64::from(step) / f64::from(steps)).unwrap();
            }
            let mut values = vec![0.0; table.computed().count()];
            run.values(&mut values);
            values
        };
        let (one, many) = (values_after(1), values_after(97));
        for ((variable, one), many) in table.computed().zip(one).zip(many) {
            if table.find(&variable.name).is_some_and(|entry| entry.state.is_some()) {
                let magnitude = one.abs().max(variable.nominal.unwrap_or(1.0));
                assert!((one - many).abs() < 1e-6 * magnitude, "{} {}: {one} and {many}", model.name, variable.name);
            }
        }
    }
}
