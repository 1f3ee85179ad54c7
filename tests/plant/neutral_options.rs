//! What acts on nothing changes no bit of a run and no step of it: options that observe or count, and places to spare in the
//! vector of states.

use pneumatic_servo::co_simulation::Embedded;
use pneumatic_servo::friction::{LAWS, MAX_STATES};
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::{MODEL, PneumaticServoCylinder};
use pneumatic_servo::system::System;
use pneumatic_servo::variables::StateSet;

/// Communication steps of 1 ms.
const STEPS: u32 = 250;

/// Settings under which each of the methods takes steps: beside the default, the midpoint rule, and thermal and leaking
/// chambers, whose Jacobian has other parts.
const GROUNDS: [&[(&str, f64)]; 4] = [
    &[("friction.kappaA", 1e-6), ("chamberA.pressure0", 2e5)],
    &[("solver.relativeTolerance", 1e-4)],
    &[("piston.leakage", 1e-14), ("thermal.model", 3.0)],
    &[("solver.scheme", 3.0), ("solver.step", 1e-3)],
];

const NEUTRAL: [&[(&str, f64)]; 8] = [
    &[("sensor.endDistance[1]", 0.1), ("sensor.endDistance[2]", 0.26)],
    &[("sensor.position.offset", 1e-3)],
    &[("sensor.pressureA.sampleTime", 1e-3), ("sensor.pressureA.noise", 500.0)],
    &[("sensor.force.sampleTime", 1e-3), ("sensor.force.resolution", 0.1)],
    &[("consumption.enabled", 1.0)],
    &[("consumption.enabled", 1.0), ("sensor.endDistance[1]", 0.1), ("sensor.force.offset", 1.0)],
    &[("balance.enabled", 1.0)],
    &[("balance.enabled", 1.0), ("consumption.enabled", 1.0)],
];

fn setup(law: i32, changes: &[&[(&str, f64)]]) -> Setup {
    let setup = Setup::new(&MODEL).set("friction.law", law).unwrap();
    let changes = changes.iter().copied().flatten();
    changes.fold(setup, |setup, (name, value)| setup.set(name, *value).unwrap_or_else(|error| panic!("{error}")))
}

/// A voltage that jumps in every step, and feeds and vents each chamber.
fn voltage(step: u32) -> f64 {
    5.0 + 3.0 * (0.05 * f64::from(step)).sin() + 0.2 * f64::from(step % 3)
}

/// Whether a computed variable is the answer of one of the options.
fn is_answer(name: &str) -> bool {
    ["sensor.", "supply.", "balance.", "der(sensor.", "der(supply."].iter().any(|start| name.starts_with(start))
}

/// Bits of all other computed variables, the work of the solver among them, after each step.
fn bits(setup: &Setup) -> Vec<(String, Vec<u64>)> {
    let mut plant = setup.start(0.0).unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<String> = MODEL.table().computed().map(|variable| variable.name.clone()).collect();
    let mut columns: Vec<_> = names.into_iter().map(|name| (name, Vec::new())).collect();
    for step in 0..STEPS {
        plant.set_input(0, voltage(step)).unwrap();
        plant.advance_to(f64::from(step + 1) * 1e-3).unwrap_or_else(|error| panic!("{error}"));
        let computed = plant.computed();
        columns.iter_mut().zip(computed).for_each(|((_, column), value)| column.push(value.to_bits()));
    }
    columns.retain(|(name, _)| !is_answer(name));
    columns
}

/// The law, the option and the variable of each difference.
fn differences(law: &str, option: &str, expected: &[(String, Vec<u64>)], found: &[(String, Vec<u64>)]) -> Vec<String> {
    let differs = expected.iter().zip(found).filter(|(expected, found)| expected != found);
    differs.map(|((name, _), _)| format!("{law}, {option}: {name}")).take(1).collect()
}

#[test]
fn options_that_act_on_nothing_change_no_bit() {
    let mut differing = Vec::new();
    for (id, law, _) in LAWS.items {
        for ground in GROUNDS {
            let plain = bits(&setup(*id, &[ground]));
            for option in NEUTRAL {
                let with_option = bits(&setup(*id, &[ground, option]));
                differing.extend(differences(law, &format!("{ground:?} with {option:?}"), &plain, &with_option));
            }
        }
    }
    assert!(differing.is_empty(), "{} of runs differ:\n{}", differing.len(), differing.join("\n"));
}

/// The model takes the least of several sizes that is enough; here all laws have as many places as the largest of them.
#[test]
fn places_to_spare_change_no_bit() {
    type Equations = PneumaticServoCylinder;
    const OTHERS: usize = <<Equations as System<3>>::State as StateSet<<Equations as System<3>>::Parameters>>::OTHERS;
    const MOST: usize = OTHERS + MAX_STATES + 1;
    let names: Vec<String> = MODEL.table().computed().map(|variable| variable.name.clone()).collect();
    let last = MODEL.table().parameters().filter(|variable| variable.chooses.is_some()).count();
    let mut differing = Vec::new();
    for (id, law, _) in LAWS.items {
        let setup = setup(*id, &[GROUNDS[0]]);
        let parameters = &setup.parameters()[..setup.parameters().len() - last];
        let mut inputs: [f64; 3] = std::array::from_fn(|place| setup.inputs()[place]);
        let mut run = Embedded::<Equations, MOST, 3>::new(parameters, &inputs, names.len()).unwrap();
        let mut columns: Vec<_> = names.iter().map(|name| (name.clone(), Vec::new())).collect();
        let mut computed = vec![0.0; names.len()];
        for step in 0..STEPS {
            inputs[0] = voltage(step);
            run.set_inputs(&inputs);
            run.advance(f64::from(step + 1) * 1e-3).unwrap();
            run.values(&mut computed);
            columns.iter_mut().zip(&computed).for_each(|((_, column), value)| column.push(value.to_bits()));
        }
        columns.retain(|(name, _)| !is_answer(name));
        differing.extend(differences(law, "with places to spare", &bits(&setup), &columns));
    }
    assert!(differing.is_empty(), "{differing:#?}");
}
