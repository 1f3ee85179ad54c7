//! Properties of every model: derivatives of its states, results that do not depend on how it is stepped, choices by number,
//! and saved states.

use std::collections::BTreeSet;

use crate::rig::Rig;
use pneumatic_servo::co_simulation::{Simulation, Snapshot, SnapshotError};
use pneumatic_servo::conformance;
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Saved;
use pneumatic_servo::model::{Model, Seeds, Setup, Start};
use pneumatic_servo::models;
use pneumatic_servo::variables::{Chosen, Kind, Role, Table, Variable};

/// A run under a law with inputs away from their start values.
fn running(model: &Model, law: i32) -> Box<dyn Simulation> {
    let variables = model.table();
    let starts = |of: fn(&Variable) -> bool| -> Vec<f64> {
        variables.iter().filter(|variable| of(variable)).filter_map(|variable| variable.start).collect()
    };
    let mut parameters = starts(Variable::is_parameter);
    let place = variables.iter().filter(|v| v.is_parameter()).position(|v| v.name == "friction.law");
    if let Some(place) = place {
        parameters[place] = f64::from(law);
    }
    let inputs: Vec<f64> = starts(|variable| variable.role == Role::Input).iter().map(|u| 1.1 * u + 0.3).collect();
    let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
    (model.functions.start)(&start).unwrap_or_else(|error| panic!("{}: {error}", model.name))
}

/// A run with all defaults from a time in s on.
fn started(model: &Model, time: f64) -> Box<dyn Simulation> {
    let starts =
        |variables: &mut dyn Iterator<Item = &Variable>| variables.filter_map(|it| it.start).collect::<Vec<_>>();
    let table = model.table();
    let (parameters, inputs) = (starts(&mut table.parameters()), starts(&mut table.inputs()));
    let start = Start { time, parameters: &parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
    (model.functions.start)(&start).unwrap_or_else(|error| panic!("{}: {error}", model.name))
}

/// A model under a law with inputs away from their start values.
fn pushed(model: &'static Model, law: i32) -> Setup {
    let mut setup = Setup::new(model);
    if setup.table().find("friction.law").is_some() {
        setup.change("friction.law", law).expect("a law");
    }
    for input in setup.table().inputs() {
        let value = input.nearest(1.1 * input.start.expect("a start value") + 0.3);
        setup.change(&input.name, value).expect("a legal value");
    }
    setup
}

/// The derivative of each state is the variable that the table says, by central differences between fine steps.
#[test]
fn derivatives_are_those_of_their_states() {
    for model in models::ALL {
        conformance::rates(&pushed(model, 4), 0.21 * model.experiment.stop_time);
    }
}

/// Values at hand without an evaluation have the bits of computed ones: sliding and held, and where an input has just
/// changed.
#[test]
fn values_at_hand_are_those_that_are_computed() {
    let mut looked = 0;
    for (model, law) in models::ALL.iter().flat_map(|model| LAWS.items.iter().map(move |(law, ..)| (model, *law))) {
        let mut run = running(model, law);
        let variables = model.table();
        let mut values = vec![0.0; variables.iter().filter(|variable| variable.is_computed()).count()];
        let starts = variables.iter().filter(|variable| variable.role == Role::Input).filter_map(|input| input.start);
        let inputs: Vec<f64> = starts.collect();
        for index in 0..20 {
            run.advance(0.01 * f64::from(index)).unwrap();
            if index == 10 {
                run.set_inputs(&inputs, &vec![0.0; inputs.len()]);
            }
            run.values(&mut values);
            for (place, value) in values.iter().enumerate() {
                let mut at_hand = [0.0];
                if run.at_hand(&[place], &mut at_hand) {
                    assert_eq!(at_hand[0].to_bits(), value.to_bits(), "{} {law}: place {place}", model.name);
                    looked += 1;
                }
            }
        }
    }
    assert!(
        looked > LAWS.items.len() * 15 * 4,
        "position, velocity and pressures of the cylinder, as a rule: {looked}"
    );
}

/// Nothing finite goes on from inputs that are not: the error then says under which friction law.
#[test]
fn run_that_cannot_go_on_names_its_friction_law() {
    for model in models::ALL {
        let variables = model.table();
        let Some(choice) = variables.iter().find(|variable| variable.name == "friction.law") else { continue };
        let Kind::Enumeration(laws) = choice.kind else { panic!("{}: the law is no choice", model.name) };
        let count = variables.iter().filter(|variable| variable.role == Role::Input).count();
        for (id, law, _) in laws.items {
            let mut run = running(model, *id);
            run.set_inputs(&vec![f64::INFINITY; count], &vec![0.0; count]);
            let error = run.advance(0.1).expect_err("infinite inputs").to_string();
            assert!(error.contains(&format!("friction law {law}")), "{}, {law}: {error}", model.name);
        }
    }
}

/// A state far out of its range is named, unless it first takes another one out of range.
#[test]
fn state_that_goes_out_of_range_is_named() {
    for model in models::ALL {
        let start = || Setup::new(model).start(0.0).expect("the defaults fit");
        let names: Vec<String> = start().states().map(|state| state.name.to_string()).collect();
        for moved in &names {
            let mut plant = start();
            plant.move_state(moved, 1e15).expect("a state");
            let error = plant.step(1e-3).expect_err("no state has such a value").to_string();
            let is_named = |name: &&String| error.contains(&format!("the magnitude of {name} goes beyond"));
            let named = names.iter().find(is_named);
            assert!(named.is_some(), "{}, {moved}: {error}", model.name);
            assert_eq!(error.contains("from 1.000e15"), named == Some(moved), "{}, {moved}: {error}", model.name);
        }
    }
}

/// Under the default tolerance many communication steps and one give the same end, but for the solver's tolerance: all
/// states agree to 1 ppm of their nominal values or of themselves.
#[test]
fn end_does_not_depend_on_the_communication_step() {
    for model in models::ALL {
        conformance::steps(&pushed(model, 7), 0.1 * model.experiment.stop_time, 1e-6);
    }
}

/// A differentiated run is the same run: under every law and in every model.
#[test]
fn values_have_the_same_bits_in_numbers_with_slopes() {
    for model in models::ALL {
        conformance::numbers(&pushed(model, 14), 0.05 * model.experiment.stop_time);
    }
    for (law, ..) in LAWS.items {
        conformance::numbers(&pushed(&models::friction_bench::MODEL, *law), 0.1);
        conformance::numbers(&pushed(&models::pneumatic_servo_cylinder::MODEL, *law), 0.1);
    }
}

/// The bits of all computed values after a short run.
fn outcome(setup: &Setup) -> Vec<u64> {
    let mut plant = setup.start(0.0).unwrap_or_else(|error| panic!("{}: {error}", setup.model().name));
    plant.advance_to(1e-3 * setup.model().experiment.stop_time).unwrap();
    plant.computed().iter().map(|value| value.to_bits()).collect()
}

/// A host's tolerance takes the place of the parameter at its default, and yields to any other value of it.
#[test]
fn tolerance_of_a_setup_is_that_of_the_solver() {
    let setup = || Setup::new(&models::pneumatic_servo_cylinder::MODEL).set("valveVoltage", 8.0).unwrap();
    let set = |tolerance: f64| setup().set("solver.relativeTolerance", tolerance).unwrap();
    let (fine, default) = (outcome(&set(1e-9)), outcome(&setup()));
    assert_ne!(fine, default);
    assert_eq!(outcome(&setup().tolerance(1e-9)), fine);
    assert_eq!(outcome(&set(1e-9).tolerance(1e-3)), fine);
}

#[test]
fn numbers_choose_as_the_items_they_stand_for() {
    for model in models::ALL {
        let table = model.table();
        let numbers = table.parameters().filter_map(|variable| Some((&variable.name, variable.chooses?)));
        for (number, Chosen { reference, of }) in numbers {
            let name = &table.by_reference(reference).expect("the enumeration").variable.name;
            for (id, item, _) in of.items {
                let by_name = Setup::new(model).set(name, *item).unwrap();
                // The number counts, not the enumeration.
                let by_number = Setup::new(model).set(name, of.items[0].0).unwrap().set(number, *id).unwrap();
                assert_eq!(by_number.get(name), Ok(f64::from(*id)), "{}: {number}", model.name);
                assert_eq!(outcome(&by_number), outcome(&by_name), "{}: {number} = {id}", model.name);
            }
        }
    }
}

#[test]
fn laws_chosen_by_number_differ() {
    let of = |law: i32| outcome(&Setup::new(&models::ALL[0]).set("friction.lawNumber", law).unwrap());
    let laws = [of(0), of(10), of(14)];
    assert_eq!(laws[0], of(7), "7, the law by default");
    assert!(laws[0] != laws[1] && laws[1] != laws[2] && laws[2] != laws[0]);
}

#[test]
fn running_plant_says_by_the_enumeration_which_law_a_number_has_chosen() {
    let mut plant = Setup::new(&models::ALL[0]).set("friction.lawNumber", 14).unwrap().start(0.0).unwrap();
    assert_eq!((plant.get("friction.law"), plant.get("friction.lawNumber")), (Ok(14.0), Ok(14.0)));
    plant.set("wireForce", 1.0).unwrap();
    assert_eq!(plant.get("friction.law"), Ok(14.0), "after a tunable parameter");
}

#[test]
fn numbers_between_integers_are_refused_for_all_that_is_no_real_number() {
    for model in models::ALL {
        let others = model.table().parameters().filter(|variable| !matches!(variable.kind, Kind::Real(_)));
        for variable in others {
            for value in [0.5, 1.5, 3e9] {
                let refused = Setup::new(model).set(&variable.name, value).expect_err(&variable.name).to_string();
                assert!(refused.starts_with(&format!("{} = {value} is refused: ", variable.name)), "{refused}");
            }
        }
    }
}

#[test]
fn stroke_below_the_initial_position_says_what_to_do() {
    let setup = Setup::new(&models::ALL[0]).set("cylinder.stroke", 0.2).unwrap();
    let refused = setup.start(0.0).expect_err("position0 is 0.25 m").to_string();
    let expected = "position0 = 0.25 is refused: it must not exceed cylinder.stroke = 0.2; this is its default: give position0, too";
    assert_eq!(refused, expected);
    let given = setup.clone().set("position0", 0.3).unwrap().start(0.0).expect_err("beyond the stroke").to_string();
    assert_eq!(given, "position0 = 0.3 is refused: it must not exceed cylinder.stroke = 0.2", "it was given");
    assert!(setup.set("position0", 0.1).unwrap().start(0.0).is_ok(), "what it says helps");
}

/// A tunable parameter changed before the first step is as good as one set from the beginning: nothing computed from the
/// old value, such as the magnitudes that errors are judged by, remains.
#[test]
fn parameter_tuned_at_the_start_is_like_one_set_before() {
    for model in models::ALL {
        let table = model.table();
        let laws = table.find("friction.law").map_or(vec![None], |entry| {
            let Kind::Enumeration(of) = entry.variable.kind else { panic!("laws have names") };
            // Their discrete state at the start depends on parameters: the delay line, and the held force.
            let laws = of.items.iter().filter(|(_, name, _)| !["Armstrong", "DNLRX"].contains(name));
            laws.map(|(id, ..)| Some(*id)).collect()
        });
        let is_remembered = |name: &str| name.starts_with("friction.armstrong.") || name.starts_with("friction.dnlrx.");
        let tunable = table.parameters().filter(|it| it.role == Role::Tunable && !is_remembered(&it.name));
        let mut left: BTreeSet<&str> = tunable.map(|variable| variable.name.as_str()).collect();
        for law in laws {
            let setup = || law.map_or(Setup::new(model), |law| Setup::new(model).set("friction.law", law).unwrap());
            for variable in table.parameters().filter(|variable| matches_law(variable, law, table)) {
                let start = variable.start.expect("parameters have start values");
                let value = match start {
                    // More than the static friction at first, or off.
                    _ if variable.name.ends_with(".FsInf") => 20.0,
                    0.0 => variable.nominal.unwrap_or(1.0) * 1e-3,
                    _ => 0.9 * start,
                };
                let Ok(before) = setup().set(&variable.name, value) else { continue };
                let (Ok(mut before), mut tuned) = (before.start(0.0), setup().start(0.0).unwrap()) else { continue };
                if tuned.set(&variable.name, value).is_err() {
                    continue;
                }
                for plant in [&mut before, &mut tuned] {
                    for input in table.inputs() {
                        plant.set(&input.name, input.nearest(1.1 * input.start.unwrap() + 0.3)).unwrap();
                    }
                    plant.advance_to(0.005 * model.experiment.stop_time).unwrap();
                }
                left.remove(variable.name.as_str());
                for computed in table.computed() {
                    let [expected, found] = [&mut before, &mut tuned].map(|plant| plant.get(&computed.name).unwrap());
                    let name = &computed.name;
                    assert_eq!(
                        found.to_bits(),
                        expected.to_bits(),
                        "{} {law:?}: {name} after {}",
                        model.name,
                        variable.name
                    );
                }
            }
        }
        assert!(left.is_empty(), "{}: not compared: {left:?}", model.name);
    }
}

/// Each state costs time in every step, so a run has room for those that are integrated: for no other one in a cylinder
/// or on the bench with default options, nor anywhere under a law with at most one; for two others with options.
#[test]
fn run_has_room_for_few_states_that_it_does_not_integrate() {
    let spare = |setup: &Setup| {
        let plant = setup.start(0.0).expect("legal values");
        plant.simulation().save().states.len() - plant.states().count()
    };
    for model in models::ALL {
        let Some(choice) = model.table().find("friction.law") else { continue };
        let Kind::Enumeration(laws) = choice.variable.kind else { panic!("{}: the law is no choice", model.name) };
        let is_exact = ["PneumaticServoCylinder", "FrictionBench"].contains(&model.name);
        for (id, law, _) in
            laws.items.iter().filter(|(_, law, _)| is_exact || !["GMS", "BlimanSorine", "RevisedLuGre"].contains(law))
        {
            let setup = Setup::new(model).set("friction.law", *id).expect("an id");
            assert_eq!(spare(&setup), 0, "{}, {law}", model.name);
        }
    }
    let cylinder = Setup::new(&models::ALL[0]);
    let lags = cylinder.model().table().parameters().filter(|variable| variable.name.ends_with(".lag"));
    let lines = ["hoseA.length", "hoseB.length", "throttleA.C", "throttleB.C", "supply.volume"];
    let options = [vec!["friction.position.amplitude"], lines.to_vec(), lags.map(|lag| lag.name.as_str()).collect()];
    for (options, law) in options.iter().flat_map(|options| ["None", "LuGre", "BlimanSorine"].map(|law| (options, law)))
    {
        let value = |name: &str| if name.ends_with(".C") { 1e-9 } else { 1e-3 };
        let set = |setup: Setup, name: &&str| setup.set(name, value(name)).expect("an option");
        let setup = options.iter().fold(cylinder.clone(), set).set("friction.law", law).expect("a law");
        assert!(spare(&setup) <= 2, "{options:?}, {law}: {}", spare(&setup));
    }
}

/// An input with a slope varies over one step, and then keeps the value that it has reached.
#[test]
fn slope_of_an_input_lasts_for_a_step() {
    for model in models::ALL {
        for input in model.table().inputs() {
            let mut plant = Setup::new(model).start(0.0).expect("the defaults fit");
            let start = plant.get(&input.name).expect("an input");
            let outcome = plant.set_slope(&input.name, 0.5);
            if input.kind == Kind::Boolean {
                let refusal = outcome.expect_err("true or false").to_string();
                assert!(refusal.contains(&input.name), "{refusal}");
                continue;
            }
            outcome.expect("a real input");
            for step in 1..=2 {
                plant.advance_to(0.25 * f64::from(step)).expect("a small change");
                let value = plant.get(&input.name).expect("an input");
                assert_eq!(value, start + 0.125, "{} {} after step {step}", model.name, input.name);
            }
        }
    }
}

/// Settings of a run belong to its saved states, the friction law first of all.
#[test]
fn saved_states_of_another_law_or_geometry_are_refused() {
    for model in models::ALL {
        let table = model.table();
        let plant =
            |law: &str| Setup::new(model).set("friction.law", law).expect("a law").start(0.0).expect("defaults");
        if table.find("friction.law").is_none() {
            continue;
        }
        for (_, law, _) in LAWS.items {
            let mut run = plant(law);
            let own = run.save();
            for (_, other, _) in LAWS.items.iter().filter(|(_, other, _)| other != law) {
                assert!(run.restore(&plant(other).save()).is_err(), "{}: {other} under {law}", model.name);
            }
            assert_eq!(run.save(), own, "{}: {law}", model.name);
        }
    }
    let plant = |bore: f64| {
        Setup::new(&models::pneumatic_servo_cylinder::MODEL)
            .set("cylinder.bore", bore)
            .expect("legal")
            .start(0.0)
            .expect("legal")
    };
    let refused = plant(0.04).restore(&plant(0.05).save()).expect_err("another bore");
    let SnapshotError::Fixed { name, saved, present } = refused else { panic!("{refused}") };
    assert_eq!((name.as_str(), saved, present), ("cylinder.bore", 0.05, 0.04));
}

/// A saved state with another number of parameters, inputs or slopes than the model has, such as one of another model,
/// is refused, and changes nothing.
#[test]
fn saved_states_that_do_not_fit_are_refused() {
    let plants = || models::ALL.iter().map(|model| Setup::new(model).start(0.0).expect("the defaults fit"));
    for (index, mut plant) in plants().enumerate() {
        let (model, own) = (plant.model().name, plant.save());
        for other in plants().enumerate().filter(|(other, _)| *other != index).map(|(_, other)| other) {
            let refused = plant.restore(&other.save()).expect_err("a saved state of another model");
            assert_eq!(refused, SnapshotError::Lengths, "{model} from {}", other.model().name);
            assert_eq!(plant.save(), own, "{model} after {}", other.model().name);
        }
        for list in ["parameters", "inputs", "slopes"] {
            let mut changed = serde_json::to_value(&own).expect("plain data");
            changed[list].as_array_mut().expect("a list").push(0.0.into());
            let changed: Saved = serde_json::from_value(changed).expect("plain data");
            assert!(plant.restore(&changed).is_err(), "{model}: {list}");
            assert_eq!(plant.save(), own, "{model} after {list}");
        }
        plant.restore(&own).expect("its own");
    }
}

/// The discrete state of a friction law or an actuator is of no use to another, even with the same number of states.
#[test]
fn memories_of_other_laws_and_actuators_are_refused() {
    for (model, choice) in models::ALL.iter().flat_map(|model| ["friction.law", "actuation"].map(|it| (model, it))) {
        let Some(entry) = model.table().find(choice) else { continue };
        let Kind::Enumeration(of) = entry.variable.kind else { panic!("{}: {choice} is no choice", model.name) };
        let start = |(id, ..): &(i32, _, _)| Rig::new(model.name).set(choice, f64::from(*id)).start();
        let mut runs: Vec<_> = of.items.iter().map(|item| start(item).expect("the defaults fit")).collect();
        let saved: Vec<_> = runs.iter_mut().map(|run| run.simulation().save()).collect();
        for ((own, (_, item, _)), run) in of.items.iter().enumerate().zip(&mut runs) {
            let mut outside = run.simulation().exchange(model.indicators()).expect("a model with states");
            let outsiders = outside.save();
            for ((other, (_, name, _)), snapshot) in of.items.iter().enumerate().zip(&saved) {
                let restored = run.simulation().restore(snapshot).is_ok();
                assert_eq!(restored, own == other, "{}: {item} from {name}", model.name);
            }
            outside.restore(&outsiders).expect("its own");
        }
    }
}

/// The run is exactly where the host says, whichever way it goes there, and goes back exactly there, though it counts its own
/// time from its start: near 0, that rounds to multiples of 1e-15 s.
#[test]
fn clock_is_exactly_where_the_host_says() {
    for model in models::ALL {
        let mut runs = [0, 1].map(|_| started(model, -7.3));
        for step in 1..=50 {
            let end = 1e-3 * f64::from(step);
            runs[0].advance(end).expect("a step");
            while runs[1].advance_to_event(end).expect("a step") {
                runs[1].update().expect("an event");
            }
            for run in &mut runs {
                assert_eq!(run.time(), end, "{}", model.name);
                let own = run.save();
                run.restore(&own).expect("its own");
                assert_eq!(run.time(), end, "{}", model.name);
            }
        }
    }
}

#[test]
fn spoilt_saved_states_are_refused() {
    for model in models::ALL.iter().filter(|model| model.table().number_of_states() > 0) {
        let mut run = started(model, 100.1);
        run.advance(100.2).expect("a step");
        let own = run.save();
        let mut refuse = |what: &str, spoil: &dyn Fn(&mut Snapshot)| {
            let mut spoilt = own.clone();
            spoil(&mut spoilt);
            assert!(run.restore(&spoilt).is_err(), "{}: {what}", model.name);
            assert_eq!(run.save(), own, "{}: {what}", model.name);
        };
        refuse("a clock behind the solver's", &|it| it.time -= 1e-9);
        refuse("a clock ahead of the solver's", &|it| it.time += 1e-9);
        refuse("a time that is no number", &|it| it.time = f64::NAN);
        refuse("a state that is no number", &|it| it.states[0] = f64::NAN);
        refuse("a missing state", &|it| it.states.truncate(1));
        refuse("bytes that are missing", &|it| it.memory.truncate(1));
        // The start ends the bytes, and in front of it a 0 says that no event is pending.
        let (pending, start) = (own.memory.len() - 9, own.memory.len() - 8);
        refuse("a start that is no number", &|it| it.memory[start..].copy_from_slice(&f64::NAN.to_le_bytes()));
        refuse("an event that is none", &|it| drop(it.memory.splice(pending..start, [1, 100])));
    }
}

/// Whether a variable is tunable and belongs to a law, or to none.
fn matches_law(variable: &Variable, law: Option<i32>, table: &Table) -> bool {
    let group = law.and_then(|law| {
        let Kind::Enumeration(of) = table.find("friction.law")?.variable.kind else { return None };
        of.items.iter().find(|(id, ..)| *id == law).map(|(_, name, _)| format!("friction.{}.", name.to_lowercase()))
    });
    let is_of_law = variable.name.starts_with("friction.") && variable.name.matches('.').count() == 2;
    let belongs = !is_of_law || group.is_some_and(|group| variable.name.to_lowercase().starts_with(&group));
    variable.role == Role::Tunable && belongs
}
