//! Co-simulation and model exchange of the same equations, compared.

use std::f64::consts::TAU;

use crate::bounds::smaller;
use pneumatic_servo::co_simulation::Direction;
use pneumatic_servo::conformance::{Agreement, Course, Host, both_ways};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::models::{self, driven_slider, festoon, friction_bench, pneumatic_servo_cylinder, vibro_impact};
use pneumatic_servo::variables::{Kind, Place, Variable, units};

const KARNOPP: i32 = 8;
const BRISTLE: i32 = 11;
const MAXWELL_SLIP: i32 = 17;

/// Of the host, relative to the nominal values.
const OUTSIDE: f64 = 1e-9;
/// Tolerance of co-simulation, which allows the spool thirty times the error of other states.
const INSIDE: f64 = 1e-10;

fn numbers(model: &Model) -> [usize; 2] {
    [model.table().number_of_states(), model.indicators().len()]
}

fn setup(model: &'static Model, law: &str) -> Setup {
    Setup::new(model).set("friction.law", law).expect("a law").tolerance(INSIDE)
}

fn outside(setup: &Setup, course: Course) -> Host {
    let exchange = setup.exchange(0.0).expect("parameters that fit").expect("a model with states");
    Host::new(exchange, setup.inputs(), numbers(setup.model()), course, OUTSIDE)
}

fn laws() -> impl Iterator<Item = &'static str> {
    LAWS.items.iter().map(|(_, name, _)| *name)
}

/// The cylinder's voltage swings by 2 V around 5 V once a second, on straight lines between milliseconds.
fn swing(time: f64, inputs: &mut [f64]) {
    let at = |count: f64| 5.0 + 2.0 * (TAU * 1e-3 * count).sin();
    let (count, share) = ((time / 1e-3).floor(), (time / 1e-3).fract());
    inputs[..3].copy_from_slice(&[at(count) + share * (at(count + 1.0) - at(count)), 0.0, 6e5]);
}

/// Runs both ways from grid point to grid point and compares lengths to 1e-7 m, pressures to 1 Pa, and the number of
/// events.
fn agree(setup: &Setup, course: Course, step: f64, count: u32) {
    let law = setup.get("friction.law").expect("a law") as i32;
    // Where an indicator touches 0, rounding decides whether that is an event: returns to the edge of Karnopp's band, and
    // elements that are at their limit just when the motion turns.
    let touches = setup.model().name != "PneumaticServoCylinder" && [KARNOPP, MAXWELL_SLIP].contains(&law);
    // Bonds break where random numbers say: what is left of an error in the time of one counts in the next.
    let bound = if law == BRISTLE { within::<1_000> } else { within::<100> };
    let agreement = Agreement { inside: INSIDE, outside: OUTSIDE, bound, events: if touches { 0.15 } else { 0.0 } };
    both_ways(setup, &agreement, course, step, count);
}

/// Lengths and pressures are compared to a number of nm.
fn within<const NANOMETRES: u32>(variable: &Variable, _: f64) -> Option<f64> {
    match variable.kind {
        Kind::Real(units::METRE) => Some(f64::from(NANOMETRES) * 1e-9),
        Kind::Real(units::PASCAL) => Some(1.0),
        _ => None,
    }
}

/// Inputs stay at their start values.
fn cylinder_pushed(_: f64, inputs: &mut [f64]) {
    inputs[..3].copy_from_slice(&[7.0, 0.0, 6e5]);
}

#[test]
fn both_ways_agree_under_every_law() {
    for law in laws() {
        agree(&setup(&pneumatic_servo_cylinder::MODEL, law), swing, 1e-3, 250);
    }
}

#[test]
fn both_ways_agree_with_a_regulator_with_polytropic_gas_and_with_a_table_of_openings() {
    for (name, value) in
        [("actuation", "PressureRegulator"), ("thermal.model", "Polytropic"), ("valve.characteristic", "Table")]
    {
        let setup = setup(&pneumatic_servo_cylinder::MODEL, "Stribeck").set(name, value).expect("an option");
        agree(&setup, cylinder_pushed, 1e-3, 200);
    }
}

#[test]
fn both_ways_agree_with_options_of_the_cylinder() {
    for law in ["Stribeck", "LuGre", "GMS"] {
        let mut setup = setup(&pneumatic_servo_cylinder::MODEL, law).set("chamberB.open", true).expect("an option");
        for (name, value) in [("load.stiffness", 100.0), ("load.rest", 0.2), ("friction.position.amplitude", 0.2)] {
            setup.change(name, value).expect("an option");
        }
        agree(&setup, swing, 1e-3, 200);
    }
}

#[test]
fn both_ways_agree_in_every_model_under_every_law() {
    for law in laws() {
        // Stick-slip on a spring stiff enough to see some cycles.
        let bench = setup(&friction_bench::MODEL, law).set("spring.stiffness", 2e3).expect("a parameter");
        agree(&bench, |_, inputs| inputs.copy_from_slice(&[0.1, 0.0, 0.0, 1.0]), 1e-3, 300);
        // On a shaken tray the bonds that random numbers break keep no two runs together for long.
        let count = if law == "Bristle" { 80 } else { 200 };
        agree(&setup(&driven_slider::MODEL, law), |_, inputs| inputs.fill(0.0), 1e-3, count);
        agree(&setup(&vibro_impact::MODEL, law), |_, inputs| inputs.fill(0.0), 1e-3, 200);
        agree(&setup(&festoon::MODEL, law), |_, inputs| inputs.copy_from_slice(&[0.3, 0.0]), 1e-2, 60);
    }
}

#[test]
fn model_without_continuous_states_needs_no_solver() {
    let controller = models::find("PositionController").expect("the controller");
    assert!(Setup::new(controller).exchange(0.0).expect("parameters that fit").is_none());
    assert_eq!(numbers(controller), [0, 0]);
}

/// The indicators and states of a model have their places under all laws; no indicator rests at 0.
#[test]
fn vectors_have_one_length_and_no_indicator_rests_at_zero() {
    for model in models::ALL.iter().filter(|model| model.table().number_of_states() > 0) {
        for law in laws() {
            let host = outside(&setup(model, law), |_, inputs| inputs.fill(0.0));
            let smallest = host.indicators().into_iter().fold(f64::INFINITY, smaller);
            assert!(smallest > 0.0, "{} {law}: {smallest}", model.name);
            let mut nominals = vec![0.0; host.states().len()];
            host.model.nominals(&mut nominals);
            assert!(nominals.iter().all(|nominal| nominal.is_finite() && *nominal > 0.0), "{} {law}", model.name);
        }
    }
}

#[test]
fn stuck_carriage_has_rates_of_exactly_zero_and_does_not_drift() {
    let course = |_: f64, inputs: &mut [f64]| inputs[..3].copy_from_slice(&[5.0, 3.0, 6e5]);
    let setup = setup(&pneumatic_servo_cylinder::MODEL, "Stribeck");
    let mut host = outside(&setup, course);
    let position = host.states()[0];
    for step in 1..=50 {
        host.advance(f64::from(step) * 0.01);
        let mut rates = vec![f64::NAN; host.states().len()];
        host.model.rates(&mut rates).expect("admissible states");
        assert_eq!(rates[..2], [0.0, 0.0]);
        assert_eq!(host.states()[0].to_bits(), position.to_bits());
    }
}

/// A minute of a slow pull: the mass sticks and slips some two hundred times. The host itself asserts that one update
/// settles each event.
#[test]
fn slow_pull_sticks_and_slips_alike_and_without_drift() {
    let pull = |_: f64, inputs: &mut [f64]| inputs.copy_from_slice(&[1e-3, 0.0, 0.0, 1.0]);
    let setup = setup(&friction_bench::MODEL, "Stribeck");
    let setup = ["spring.stiffness", "driveVelocity"]
        .into_iter()
        .zip([2e4, 1e-3])
        .fold(setup, |setup, (name, value)| setup.set(name, value).expect("a parameter"));
    let table = setup.table();
    let places =
        ["position", "sticking", "solver.events"].map(|name| match table.find(name).map(|entry| entry.place) {
            Some(Place::Computed(place)) => place,
            _ => panic!("{name} is computed"),
        });
    let (mut inside, mut host) = (setup.start(0.0).expect("a run"), outside(&setup, pull));
    let mut seen = vec![0.0; table.computed().count()];
    let mut look = |host: &mut Host| {
        host.model.values(&mut seen);
        places.map(|place| seen[place])
    };
    let mut before = look(&mut host);
    for step in 1..=6000 {
        let end = f64::from(step) * 1e-2;
        host.advance(end);
        inside.advance_to(end).expect("a step");
        let now @ [position, sticking, events] = look(&mut host);
        let expected = inside.get("position").expect("a variable");
        assert!((position - expected).abs() <= 1e-7, "{position} outside, {expected} inside, at {end} s");
        if [sticking, events] == [1.0, before[2]] {
            assert_eq!(position.to_bits(), before[0].to_bits(), "drift at {end} s");
        }
        before = now;
    }
    let events = before[2];
    assert_eq!(events, inside.get("solver.events").expect("a variable"));
    assert!(events > 400.0, "{events} events");
}

#[test]
fn saved_states_repeat_bit_for_bit() {
    for law in laws() {
        let setup = setup(&pneumatic_servo_cylinder::MODEL, law);
        let run = |host: &mut Host| -> Vec<u64> {
            host.advance(0.25);
            host.states().iter().map(|state| state.to_bits()).collect()
        };
        let mut one = outside(&setup, swing);
        one.advance(0.2);
        let saved = one.model.save();
        let mut exchange = setup.exchange(0.0).expect("parameters that fit").expect("a model with states");
        exchange.restore(&saved).expect("a state of the same model");
        // Both go on from the same point with the same step.
        let mut one = Host::new(one.model, setup.inputs(), numbers(setup.model()), swing, OUTSIDE);
        let mut other = Host::new(exchange, setup.inputs(), numbers(setup.model()), swing, OUTSIDE);
        assert_eq!(run(&mut other), run(&mut one), "{law}");
    }
}

/// The equations count their time from the start, under any clock: the sampled law, the delay, the shaken tray and its
/// walk do the same at all starts, as in co-simulation.
#[test]
fn runs_that_start_at_another_time_are_the_same_runs() {
    for (model, law) in [
        (&pneumatic_servo_cylinder::MODEL, "DNLRX"),
        (&pneumatic_servo_cylinder::MODEL, "Armstrong"),
        (&driven_slider::MODEL, "Stribeck"),
    ] {
        let setup = setup(model, law);
        let at = |start: f64| {
            let exchange = setup.exchange(start).expect("parameters that fit").expect("a model with states");
            assert_eq!(exchange.time(), start);
            let still: Course = match setup.inputs().len() {
                1 => |_, inputs| inputs.fill(0.0),
                _ => cylinder_pushed,
            };
            let mut host = Host::new(exchange, setup.inputs(), numbers(model), still, OUTSIDE);
            host.advance(start + 0.25);
            host.states().to_vec()
        };
        let expected = at(0.0);
        // Powers of two, so that steps of the host round alike but for the last bits of its clock.
        for start in [-0.5, 1024.0] {
            for (one, other) in at(start).iter().zip(&expected) {
                let bound = 1e-6 * other.abs().max(1e-3);
                assert!((one - other).abs() <= bound, "{} {law} from {start} s: {one}, not {other}", model.name);
            }
        }
    }
}

/// The source of a delayed velocity must be known: the host is told to stop four times within each delay.
#[test]
fn time_events_are_no_further_apart_than_a_law_with_a_delay_can_remember() {
    const LAG: f64 = 8e-3;
    let with_states = models::ALL.iter().filter(|model| model.table().number_of_states() > 0);
    let mut models = 0;
    for model in with_states {
        let mut setup = setup(model, "Armstrong").set("friction.armstrong.tauL", LAG).expect("a delay");
        if model.name == "DrivenSlider" {
            // Steps of its walk, and turns of its tray, would come sooner.
            setup.change("walk.stepsPerPeriod", 0).expect("a parameter");
            setup.change("tray.frequency", 0.1).expect("a parameter");
        }
        let mut exchange = setup.exchange(0.5).expect("parameters that fit").expect("a model with states");
        for time in [0.5, 0.5 + 1e-3, 0.5 + 2e-3] {
            exchange.set_time(time);
            let next = exchange.update().expect("an update").next_time_event.expect("a time event");
            assert!(next > time && next <= time + LAG / 4.0, "{}: {next} s after {time} s", model.name);
        }
        let without = setup.set("friction.armstrong.tauL", 0.0).expect("no delay");
        let mut exchange = without.exchange(0.5).expect("parameters that fit").expect("a model with states");
        let next = exchange.update().expect("an update").next_time_event;
        assert!(next.is_none_or(|next| next > 0.5 + LAG), "{}: {next:?}", model.name);
        models += 1;
    }
    assert_eq!(models, 5);
}

/// Time alone moves the tray of the driven slider, and states that keep an instant. Derivatives by time agree with
/// differences at fixed states, inputs and memory, and have the same bits in co-simulation.
#[test]
fn slopes_by_time_are_those_of_differences_with_the_solver_outside_and_inside() {
    const START: f64 = -3.0;
    const TIME: f64 = START + 0.0137;
    const STEP: f64 = 1e-6;
    let mut moved = Vec::new();
    for model in models::ALL.iter().filter(|model| model.table().number_of_states() > 0) {
        for law in laws() {
            let setup = setup(model, law);
            let table = setup.table();
            let mut inside = setup.start(START).expect("parameters that fit");
            inside.advance_to(TIME).expect("a step");
            let mut outside = inside.simulation().exchange(model.indicators()).expect("a model with states");
            let (inputs, states) = (vec![0.0; setup.inputs().len()], vec![0.0; numbers(model)[0]]);
            let by_time = Direction { time: 1.0, inputs: &inputs, states: &states, parameters: &[] };
            let count = table.computed().count();
            let (mut one, mut other) = (vec![f64::NAN; count], vec![f64::NAN; count]);
            outside.directional_derivative(by_time, &mut one);
            inside.simulation().directional_derivative(by_time, &mut other);
            let mut at = |time: f64| {
                let mut values = vec![f64::NAN; count];
                outside.set_time(time);
                outside.values(&mut values);
                values
            };
            let (before, after) = (at(TIME - STEP), at(TIME + STEP));
            for (place, variable) in table.computed().enumerate() {
                let name = format!("{} {law}: {}", model.name, variable.name);
                assert_eq!(one[place].to_bits(), other[place].to_bits(), "{name}: inside");
                if !matches!(variable.kind, Kind::Real(_)) || variable.name.starts_with("solver.") {
                    continue;
                }
                let difference = (after[place] - before[place]) / (2.0 * STEP);
                // Rounding of the values, and the third derivative of a shaking at some hundred radians a second.
                let bound = 1e-15 * after[place].abs() / STEP + 1e-6 * difference.abs();
                let slope = one[place];
                assert!((slope - difference).abs() <= bound, "{name}: {slope}, not {difference}");
                if slope != 0.0 && law == "Stribeck" {
                    moved.push((model.name, variable.name.as_str()));
                }
            }
        }
    }
    let of_slider = moved.iter().filter(|(model, _)| *model == "DrivenSlider").count();
    assert!(of_slider >= 6, "{moved:?}");
}
