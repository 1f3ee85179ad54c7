//! Points of a run without a derivative: every such case is refused by name, time and reason, and its neighbours are not.

use pneumatic_servo::model::{Model, Plant, Setup, Steps, Value};
use pneumatic_servo::models::{festoon, friction_bench, pneumatic_servo_cylinder};

fn start(model: &'static Model, changes: &[(&str, Value)]) -> Plant {
    let mut setup = Setup::new(model);
    changes.iter().for_each(|(name, value)| setup.change(name, *value).expect("legal"));
    setup.start(0.0).expect("starts")
}

/// A mass on the bench under a force, with a law and other values.
fn mass_under(force: f64, law: &str, changes: &[(&str, Value)]) -> Plant {
    let bare = [("bench.drive", "Free".into()), ("friction.law", law.into()), ("appliedForce", force.into())];
    start(&friction_bench::MODEL, &[&bare[..], changes].concat())
}

/// Why there is no derivative in a direction; nothing where there is one.
fn told(plant: &mut Plant, direction: usize) -> Option<String> {
    plant.sensitivities(direction).err().map(|error| error.to_string())
}

/// A mass that is pushed with next to as much as friction takes comes to rest as slowly as it pleases.
#[test]
fn grazing_is_told() {
    for (missing, is_told) in [(1e-9, true), (1e-8, false)] {
        let changes = [
            ("friction.coulomb.Fc", 2.0.into()),
            ("friction.coulomb.sigma2", 0.0.into()),
            ("velocity0", missing.into()),
            ("mass", 1.5.into()),
        ];
        let mut plant = mass_under(2.0 - missing, "Coulomb", &changes);
        plant.carry_sensitivities(&["friction.coulomb.Fc"]).expect("a parameter");
        plant.advance_to(5.0).expect("stops");
        let [stop] = &plant.crossings()[..] else { panic!("one event: {:?}", plant.crossings()) };
        assert_eq!((stop.event, stop.rate.is_nan()), ("stop", is_told));
        let told = told(&mut plant, 0);
        assert_eq!(told.is_some(), is_told, "{told:?}");
        if let Some(told) = told {
            assert!(told.contains("s on, at stop: the motion only grazes its limit, at -6.66"), "{told}");
        }
    }
}

/// Two trolleys that hang alike on slack ropes break away at one instant; a single one has a derivative.
#[test]
fn two_events_at_one_instant_are_told() {
    for (trolleys, is_told) in [(2.0, true), (1.0, false)] {
        let changes =
            [("trolleys", trolleys.into()), ("friction.law", "CoulombStiction".into()), ("load.angle0", 1.5.into())];
        let mut plant = start(&festoon::MODEL, &changes);
        plant.carry_sensitivities(&["load.mass"]).expect("a parameter");
        plant.advance_to(0.1).expect("swings");
        assert_eq!(plant.crossings()[0].event, "breakAway");
        let told = told(&mut plant, 0);
        assert_eq!(told.is_some(), is_told, "{told:?}");
        if let Some(told) = told {
            assert!(told.ends_with("s on, at breakAway: breakAway happens at the same instant"), "{told}");
        }
    }
}

/// A force of just the static friction at the start: with any more of it the mass slides.
#[test]
fn mode_that_begins_exactly_at_its_limit_is_told() {
    for (force, is_told) in [(1.5, true), (1.4, false), (1.6, false)] {
        let changes = [("friction.coulombStiction.Fs", 1.5.into()), ("friction.coulombStiction.Fc", 1.0.into())];
        let mut plant = mass_under(force, "CoulombStiction", &changes);
        plant.carry_sensitivities(&["appliedForce", "friction.coulombStiction.Fs", "mass"]).expect("directions");
        plant.advance_to(0.1).expect("advances");
        for direction in [0, 1] {
            let told = told(&mut plant, direction);
            assert_eq!(told.is_some(), is_told, "{force} N: {told:?}");
            if let Some(told) = told {
                let expected =
                    "the run has no derivative from t = 0 s on, at the start: the modes differ from one side";
                assert!(told.starts_with(expected), "{told}");
            }
        }
        assert_eq!(told(&mut plant, 2), None, "the mass does not matter to that");
    }
}

/// Up to the exponent 1/2 the equations do not tell how a mass leaves its rest, and so neither how that changes.
#[test]
fn infinite_slope_behind_a_break_away_is_told() {
    for (exponent, is_told) in [(0.4, true), (0.5, true), (0.6, false), (1.0, false)] {
        let mut plant = start(&pneumatic_servo_cylinder::MODEL, &[("friction.stribeck.delta", exponent.into())]);
        plant.carry_sensitivities(&["friction.stribeck.Fs"]).expect("a parameter");
        plant.set("valveVoltage", 6.5).expect("legal");
        plant.advance_to(0.2).expect("breaks away");
        assert!(plant.crossings().iter().any(|crossing| crossing.event == "breakAway"));
        let told = told(&mut plant, 0);
        assert_eq!(told.is_some(), is_told, "{exponent}: {told:?}");
        if let Some(told) = told {
            let expected = "at breakAway: behind it rates have an infinite slope by a state that was held";
            assert!(told.ends_with(expected), "{told}");
        }
    }
}

/// A force beyond break-away turns the motion without a rest. Below an exponent of about 0.8 friction is so steep there that this is told;
/// else the derivative equals the difference of runs.
#[test]
fn steep_friction_where_the_motion_turns_is_told() {
    let run = |exponent: f64, mass: f64| {
        let changes = [
            ("friction.stribeck.delta", exponent.into()),
            ("mass.moving", mass.into()),
            ("velocity0", 0.3.into()),
            ("externalForce", (-200.0).into()),
            ("solver.relativeTolerance", 1e-10.into()),
        ];
        let mut plant = start(&pneumatic_servo_cylinder::MODEL, &changes);
        plant.carry_sensitivities(&["mass.moving"]).expect("a parameter");
        plant.advance_to(0.02).expect("turns");
        assert!(plant.get("velocity").expect("a variable") < 0.0);
        plant
    };
    for (exponent, is_told) in [(0.5, true), (0.6, true), (0.75, true), (0.9, false), (1.0, false), (2.0, false)] {
        let mut plant = run(exponent, 0.88);
        let lost = told(&mut plant, 0);
        assert_eq!(lost.is_some(), is_told, "{exponent}: {lost:?}");
        if !is_told {
            let place = plant.table().computed().position(|it| it.name == "velocity").expect("a computed variable");
            let found = plant.sensitivities(0).expect("a derivative")[place];
            let [more, less] =
                [0.88 + 1e-6, 0.88 - 1e-6].map(|mass| run(exponent, mass).get("velocity").expect("a variable"));
            let difference = (more - less) / 2e-6;
            assert!((found - difference).abs() < 1e-3 * difference.abs(), "{exponent}: {found} for {difference}");
        }
    }
}

/// At 0 and 10 V more of the voltage does something else than less, with and without play; what does not move it is none the worse.
#[test]
fn voltage_just_at_an_end_of_its_range_is_told() {
    for (play, voltage, is_told) in [(0.0, 10.0, true), (0.0, 0.0, true), (0.01, 10.0, true), (0.0, 9.9, false)] {
        let mut plant = start(&pneumatic_servo_cylinder::MODEL, &[("valve.hysteresis", play.into())]);
        plant.carry_sensitivities(&["valveVoltage", "valve.offset", "valve.C"]).expect("directions");
        for (voltage, end) in [(7.0, 0.1), (voltage, 0.101)] {
            plant.set("valveVoltage", voltage).expect("legal");
            plant.advance_to(end).expect("advances");
        }
        for direction in [0, 1] {
            let told = told(&mut plant, direction);
            let expected = "from t = 0.1 s on, at valveVoltage: its slope upwards differs from its slope downwards";
            assert_eq!(told.is_some(), is_told, "{voltage} V, {play}: {told:?}");
            assert!(told.as_ref().is_none_or(|told| told.ends_with(expected)), "{voltage} {play} {direction} {told:?}");
        }
        assert_eq!(told(&mut plant, 2), None, "it does not move the end");
        let step = plant.transition(0.002, &["valve.C"], &["position"]).expect("a step");
        // With play a voltage that rests at the end moves nothing, neither by more nor by less.
        let lost =
            step.lost.iter().find(|(column, _)| *column == step.states.len()).map(|(_, lost)| lost.event.as_str());
        assert_eq!(lost, (is_told && play == 0.0).then_some("valveVoltage"), "{voltage} V, {play}");
        assert!(step.q[0][0].is_finite());
    }
}

/// A rounded signal has no derivative; the signal before has one, and so has the reading without rounding.
#[test]
fn reading_that_is_rounded_has_no_number() {
    for resolution in [1e-5, 0.0] {
        let sampled = [("sensor.position.sampleTime", 1e-3.into()), ("sensor.position.resolution", resolution.into())];
        let mut plant = start(&pneumatic_servo_cylinder::MODEL, &sampled);
        plant.carry_sensitivities(&["valve.C"]).expect("a parameter");
        plant.set("valveVoltage", 6.5).expect("legal");
        plant.advance_to(0.3).expect("advances");
        let [position, reading] = ["position", "sensor.position.reading"]
            .map(|name| plant.table().computed().position(|variable| variable.name == name).expect("computed"));
        let slopes = plant.sensitivities(0).expect("a derivative");
        assert!(slopes[position] > 0.0, "{}", slopes[position]);
        assert_eq!(slopes[reading].is_nan(), resolution > 0.0, "{}", slopes[reading]);
    }
}

/// Backwards and forwards over a run, too; what is beside the reading is none the worse.
#[test]
fn reading_that_is_rounded_has_no_gradient() {
    let sampled = [("sensor.position.sampleTime", 1e-3.into()), ("sensor.position.resolution", 1e-5.into())];
    let free = [("valve.hysteresis", 0.0.into())];
    let (ends, inputs) = ([0.1, 0.2], [6.5, 6.4].map(|voltage| vec![voltage, 0.0, 6e5, 0.25, 0.0, 5.0, 5.0]));
    for (output, is_told) in [("sensor.position.reading", true), ("position", false)] {
        let begin = || start(&pneumatic_servo_cylinder::MODEL, &[&sampled[..], &free].concat());
        let steps = || Steps { ends: &ends, inputs: &inputs };
        let weight = |row: usize, _: usize| f64::from(u8::from(row == 2));
        let backwards = begin().gradient(steps(), &["valve.C"], &[output], weight, || true).map(|_| ());
        let forwards = begin().tangent(steps(), (&["valve.C"], &[1.0]), &[output], |_, _| 0.0, || true).map(|_| ());
        for (found, time) in [(backwards, 0.2), (forwards, 0.1)] {
            let told = found.err().map(|error| error.to_string());
            let expected = format!("from t = {time} s on, at {output}: it is rounded");
            assert_eq!(told.is_some(), is_told, "{told:?}");
            assert!(told.as_ref().is_none_or(|told| told.contains(&expected)), "{told:?}, not {expected}");
        }
    }
}

/// Choices, counts, settings of the solver and times of samples are none that vary little by little.
#[test]
fn names_of_no_direction_are_refused() {
    let mut plant = start(&pneumatic_servo_cylinder::MODEL, &[]);
    for (names, expected) in [
        (&["valve.D"][..], "there is no variable valve.D; did you mean"),
        (&["friction.law"], "there are no sensitivities with respect to friction.law: it is a choice"),
        (&["friction.gms.N"], "there are no sensitivities with respect to friction.gms.N: it is a whole number"),
        (
            &["solver.relativeTolerance"],
            "there are no sensitivities with respect to solver.relativeTolerance: it changes how",
        ),
        (&["friction.dnlrx.Ts"], "there are no sensitivities with respect to friction.dnlrx.Ts: it says when samples"),
        (
            &["sensor.position.sampleTime"],
            "there are no sensitivities with respect to sensor.position.sampleTime: it says when samples",
        ),
        (&["frictionForce"], "there are no sensitivities with respect to frictionForce: it is computed"),
        (
            &["friction.deflection"],
            "there are no sensitivities with respect to friction.deflection: it is no continuous state",
        ),
        (&["valve.C", "position", "valve.C"], "there are no sensitivities with respect to valve.C: it is given twice"),
        (&["time"], "there are no sensitivities with respect to time: it is the time"),
        (&["coil[1]"], "there are no sensitivities with respect to coil[1]: it is true or false"),
        (
            &["friction.direction.damping"],
            "there are no sensitivities with respect to friction.direction.damping: it is 0, and its slope upwards",
        ),
        (&["hoseA.length"], "there are no sensitivities with respect to hoseA.length: it is 0, which stands for none"),
        (
            &["supply.volume"],
            "there are no sensitivities with respect to supply.volume: it is 0, which stands for none",
        ),
        (
            &["sensor.position.lag"],
            "there are no sensitivities with respect to sensor.position.lag: it is 0, which stands for none",
        ),
    ] {
        let found = plant.carry_sensitivities(names).expect_err("refused").to_string();
        assert!(found.starts_with(expected), "{found}");
    }
}

/// A mass that sets out from rest slides at once; with any less velocity it would have to stop first. The force on it is none the worse.
#[test]
fn velocity_of_a_mass_that_sets_out_from_rest_is_told() {
    for law in ["Coulomb", "CoulombStiction", "Stribeck", "Polito"] {
        for (name, place) in [("velocity0", "the start"), ("velocity", "stop")] {
            for (velocity, is_told) in [(0.0, true), (0.01, false)] {
                let mut plant = mass_under(20.0, law, &[("velocity0", velocity.into())]);
                plant.carry_sensitivities(&[name, "appliedForce"]).expect("directions");
                plant.advance_to(1e-3).expect("advances");
                let told = [0, 1].map(|direction| told(&mut plant, direction));
                assert_eq!(told[0].is_some(), is_told, "{law}, {name}, {velocity} m/s: {told:?}");
                if let Some(told) = &told[0] {
                    let expected = format!("from t = 0 s on, at {place}: the modes differ from one side");
                    assert!(told.contains(&expected), "{told}");
                }
                assert_eq!(told[1], None, "{law}: the force");
            }
        }
    }
}

/// Steps are explicit, or implicit beside a throttle, a cushion or a quick exhaust.
#[test]
fn voltage_that_rests_at_the_edge_of_the_play_is_told_in_steps_of_any_kind() {
    let options: [&[(&str, Value)]; 4] = [
        &[],
        &[("throttleA.C", Value::Number(2e-9)), ("throttleB.C", Value::Number(2e-9))],
        &[("cushion.length", Value::Number(0.02))],
        &[("quickExhaustA.C", Value::Number(1e-8))],
    ];
    for option in options {
        let voltage = [("valveVoltage", Value::Number(6.5))];
        let mut plant = start(&pneumatic_servo_cylinder::MODEL, &[&voltage, option].concat());
        plant.advance_to(0.005).expect("advances");
        let found = plant.transition(1e-3, &[], &["velocity"]).expect("a transition");
        let column = found.states.len();
        let lost = found.lost.iter().find(|(place, _)| *place == column);
        let (_, why) = lost.unwrap_or_else(|| panic!("{option:?}: a slope by the voltage"));
        assert_eq!(why.event, "valveVoltage", "{option:?}");
        assert!(found.b.iter().all(|row| row[0].is_nan()), "{option:?}");
        // By a voltage that moves there is a slope.
        plant.set("valveVoltage", 6.6).expect("an input");
        let found = plant.transition(1e-3, &[], &["velocity"]).expect("a transition");
        assert!(found.lost.is_empty(), "{option:?}: {:?}", found.lost);
    }
}
