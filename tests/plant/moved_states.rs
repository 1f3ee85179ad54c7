//! Moving a continuous state moves that state and no other, in every model, under every law and with every option that brings states
//! or leaves some out.

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::{Model, Plant, Setup};
use pneumatic_servo::models::{self, pneumatic_servo_cylinder};
use pneumatic_servo::variables::SettingError;

/// Settings under which models integrate other states.
const OPTIONS: [&[(&str, f64)]; 12] = [
    &[],
    &[("load.stiffness", 100.0), ("load.rest", 0.25)],
    &[("chamberB.open", 1.0)],
    &[("friction.position.amplitude", 0.2)],
    &[("friction.kappaDifference", 1e-7)],
    &[("sensor.position.lag", 1e-3), ("sensor.pressureA.sampleTime", 1e-3)],
    &[("supply.volume", 1e-3)],
    &[("hoseA.length", 2.0), ("hoseB.length", 1.0)],
    &[("hoseA.length", 2.0), ("supply.volume", 1e-3), ("sensor.position.lag", 1e-3)],
    &[("actuation", 2.0)],
    &[("actuation", 3.0)],
    &[("actuation", 3.0), ("hoseB.length", 1.0), ("supply.volume", 1e-3)],
];

/// All states in the order of the table, those that are not integrated with their start values.
fn states(model: &Model, plant: &Plant) -> Vec<f64> {
    let exchange = plant.simulation().exchange(model.indicators()).expect("a model with states");
    let mut states = vec![0.0; plant.table().number_of_states()];
    exchange.states(&mut states);
    states
}

fn walk(model: &'static Model, law: &str, options: &[(&str, f64)]) -> usize {
    let label = || format!("{} under {law} with {options:?}", model.name);
    let mut setup = Setup::new(model).set("friction.law", law).expect("a law");
    for (name, value) in options {
        setup = setup.set(name, *value).unwrap_or_else(|error| panic!("{}: {error}", label()));
    }
    let mut plant = setup.start(0.0).unwrap_or_else(|error| panic!("{}: {error}", label()));
    plant.advance_to(1e-3).unwrap_or_else(|error| panic!("{}: {error}", label()));
    let table = plant.table();
    let names: Vec<&str> =
        table.states().map(|reference| &*table.by_reference(reference).expect("a variable").variable.name).collect();
    let integrated: Vec<&str> = plant.states().map(|variable| &*variable.name).collect();
    let (saved, before) = (plant.save(), states(model, &plant));
    for moved in &integrated {
        let place = names.iter().position(|name| name == moved).expect("a state of the table");
        let value = before[place] + 1e-3 * before[place].abs().max(1e-3);
        plant.move_state(moved, value).unwrap_or_else(|error| panic!("{}: {moved}: {error}", label()));
        let after = states(model, &plant);
        for (state, (was, is)) in before.iter().zip(&after).enumerate() {
            let expected = if state == place { value } else { *was };
            assert_eq!(
                is.to_bits(),
                expected.to_bits(),
                "{}: moving {moved} to {value} sets {}",
                label(),
                names[state]
            );
        }
        plant.restore(&saved).unwrap_or_else(|error| panic!("{}: {error}", label()));
    }
    integrated.len()
}

#[test]
fn a_moved_state_is_the_one_that_is_named_and_no_other() {
    let mut moves = 0;
    for model in models::ALL.iter().filter(|model| Setup::new(model).table().number_of_states() > 0) {
        let is_cylinder = model.name == pneumatic_servo_cylinder::MODEL.name;
        for (_, law, _) in LAWS.items {
            let options = if is_cylinder { &OPTIONS[..] } else { &OPTIONS[..1] };
            moves += options.iter().map(|options| walk(model, law, options)).sum::<usize>();
        }
    }
    assert!(moves > 3000, "{moves} moves");
}

#[test]
fn a_state_is_moved_to_finite_values_only_and_what_is_no_state_is_refused() {
    let mut plant = Setup::new(&pneumatic_servo_cylinder::MODEL).start(0.0).expect("a plant");
    let refused = |outcome: Result<(), SettingError>| outcome.expect_err("a refusal").to_string();
    assert!(refused(plant.move_state("position", f64::NAN)).contains("must be a finite number"));
    assert!(refused(plant.move_state("hoseA.pressure[1]", 1e5)).contains("no continuous state of this run"));
}
