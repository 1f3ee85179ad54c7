//! The dependencies that the tables declare, compared with derivatives and with differences: at initialization and
//! between steps, under every law and on every rig.

use std::f64::consts::TAU;

use pneumatic_servo::co_simulation::Direction;
use pneumatic_servo::conformance;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable};

use crate::cases::{Changes, cases, setup, start, try_start};

/// Whether two values differ by more than rounding.
fn differ((variable, (before, after)): &(&Variable, (&f64, &f64))) -> bool {
    let magnitude = before.abs().max(variable.nominal.unwrap_or(1.0));
    (*before - *after).abs() > 1e-12 * magnitude || (before != after && variable.kind == Kind::Boolean)
}

/// Four valves whose coils are on, and that take a second to open, with and without hoses: their flow depends on the time.
fn coils_on() -> [Changes; 2] {
    let valves = [("actuation", 3.0), ("switching.command", 3.0), ("switching.travelTime", 1.0)];
    let coils = [("coil[1]", 1.0), ("coil[2]", 1.0), ("coil[3]", 1.0), ("coil[4]", 1.0)];
    let filled = [("chamberA.pressure0", 4e5), ("chamberB.pressure0", 3e5)];
    let hoses = [("hoseA.length", 1.0), ("hoseB.length", 1.0), ("consumption.enabled", 1.0)];
    [[&valves[..], &coils, &filled].concat(), [&valves[..], &coils, &hoses].concat()]
}

#[test]
fn declared_dependencies_are_those_that_derivatives_and_differences_show() {
    for model in models::ALL {
        let coils = model.table().find("coil[1]").map_or_else(Vec::new, |_| coils_on().into());
        let all: Vec<_> = cases(model).into_iter().chain(coils).collect();
        conformance::dependencies(&all.iter().map(|case| setup(model, case)).collect::<Vec<_>>());
    }
}

#[test]
fn knowns_are_inputs_states_and_time() {
    for model in models::ALL {
        let table = model.table();
        let is_known = |reference: u32| {
            let entry = table.by_reference(reference).expect("a variable");
            entry.state.is_some() || matches!(entry.variable.role, Role::Input | Role::Time)
        };
        for variable in table {
            let (model, name, declared) = (model.name, &variable.name, variable.depends_on.as_ref());
            assert!(declared.is_some() || !variable.is_computed(), "{model}: {name} does not say what it depends on");
            assert!(declared.into_iter().flatten().all(|known| is_known(*known)), "{model}: {name}");
        }
    }
}

/// At initialization states follow from inputs, if they do, and nothing else of the inputs enters.
#[test]
fn initial_values_follow_from_the_inputs_that_are_declared() {
    for model in models::ALL {
        let table = model.table();
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
                    let changes = case.iter().copied().chain(changed).collect();
                    // A large one may be refused, as a position beyond the stroke is.
                    if difference.abs() > 1.0 && try_start(model, &changes).is_err() {
                        continue;
                    }
                    let after = values_at(&changes);
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

/// While the input pushes the hysteresis of the valve, the spool's acceleration has the derivative of that side, also
/// after the hysteresis has followed; inside it has none.
#[test]
fn spool_follows_the_voltage_while_it_pushes_the_play() {
    let model = models::find("PneumaticServoCylinder").expect("a model");
    let table = model.table();
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
