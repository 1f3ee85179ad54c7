//! Sensitivities of runs, compared with closed forms and with differences of runs.

use std::f64::consts::{PI, TAU};

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Plant;
use pneumatic_servo::model::{Model, Setup, Value};
use pneumatic_servo::models::{festoon, friction_bench, pneumatic_servo_cylinder};

fn setup(model: &'static Model, changes: &[(&str, Value)]) -> Setup {
    let mut setup = Setup::new(model);
    changes.iter().for_each(|(name, value)| setup.change(name, *value).expect("legal"));
    setup
}

fn place(plant: &Plant, name: &str) -> usize {
    plant.table().computed().position(|variable| variable.name == name).expect("a computed variable")
}

/// The sensitivities of a variable to all that are carried along.
fn of(plant: &mut Plant, name: &str, count: usize) -> Vec<f64> {
    let place = place(plant, name);
    (0..count).map(|direction| plant.sensitivities(direction).expect("a derivative")[place]).collect()
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found}, not {expected}");
    }
}

/// A free mass stops after `m*v0^2/(2*Fc)`, and stays there.
#[test]
fn stopping_distance_under_coulomb_friction() {
    let [friction, speed, mass] = [2.0, 3.0, 1.5];
    let setup = setup(
        &friction_bench::MODEL,
        &[
            ("bench.drive", "Free".into()),
            ("friction.law", "Coulomb".into()),
            ("friction.coulomb.Fc", friction.into()),
            ("friction.coulomb.sigma2", 0.0.into()),
            ("velocity0", speed.into()),
            ("mass", mass.into()),
        ],
    );
    let mut plant = setup.start(0.0).expect("starts");
    plant.carry_sensitivities(&["friction.coulomb.Fc", "velocity0", "mass"]).expect("parameters");
    plant.advance_to(5.0).expect("stops");
    let expected = [
        -mass * speed * speed / (2.0 * friction * friction),
        mass * speed / friction,
        speed * speed / (2.0 * friction),
    ];
    // Differences of one evaluation hold ten digits.
    assert_near(&of(&mut plant, "position", 3), &expected, 1e-9);
    assert_eq!(of(&mut plant, "velocity", 3), [0.0; 3], "what sticks has no velocity, whatever the parameters");
    let [stop] = &plant.crossings()[..] else { panic!("one event: {:?}", plant.crossings()) };
    assert_eq!(stop.event, "stop");
    assert_near(&[stop.rate], &[-friction / mass], 1e-9);
    assert_near(&stop.delays, &[-mass * speed / (friction * friction), mass / friction, speed / friction], 1e-9);
}

/// Directions that a run carries together have the derivatives that each has alone, through breaking away and stopping; a parameter
/// that is 0, a state and an input are among them.
#[test]
fn directions_do_not_meet() {
    let names = ["valve.C", "friction.stribeck.Fs", "friction.kappaDifference", "position", "valveVoltage"];
    let found = |names: &[&str]| {
        let mut plant = cylinder("Stribeck", 1e-9).start(0.0).expect("starts");
        plant.carry_sensitivities(names).expect("directions");
        experiment(&mut plant, 0.7, |_| {});
        let delays: Vec<Vec<f64>> = plant.crossings().into_iter().map(|crossing| crossing.delays).collect();
        (of(&mut plant, "position", names.len()), delays)
    };
    let (together, delays) = found(&names);
    assert!(delays.len() > 2, "{delays:?}");
    for (place, name) in names.iter().enumerate() {
        let (alone, own) = found(&[name]);
        assert_near(&[together[place]], &alone, 1e-6);
        for (delays, own) in delays.iter().zip(own) {
            assert!((delays[place] - own[0]).abs() <= 1e-6 * own[0].abs() + 1e-12, "{name}: {delays:?}, not {own:?}");
        }
    }
}

/// The bench of the stick-slip cycle that is known in closed form.
fn stick_slip() -> Setup {
    setup(
        &friction_bench::MODEL,
        &[
            ("friction.law", "CoulombStiction".into()),
            ("friction.coulombStiction.Fs", 1.5.into()),
            ("friction.coulombStiction.Fc", 1.0.into()),
            ("friction.coulombStiction.sigma2", 0.0.into()),
            ("solver.relativeTolerance", 1e-10.into()),
        ],
    )
}

/// A mass that a spring pulls with a speed is released at `Fs/(k*V)`.
#[test]
fn release_time_of_a_mass_that_a_spring_pulls() {
    let mut plant = stick_slip().start(0.0).expect("starts");
    plant
        .carry_sensitivities(&["friction.coulombStiction.Fs", "driveVelocity", "spring.stiffness"])
        .expect("directions");
    plant.advance_to(8.0).expect("is released");
    let release = &plant.crossings()[0];
    let [limit, stiffness, speed] = [1.5, 2.0, 0.1];
    let expected =
        [1.0 / (stiffness * speed), -limit / (stiffness * speed * speed), -limit / (stiffness * stiffness * speed)];
    assert_eq!(release.event, "breakAway");
    assert_near(&release.delays, &expected, 1e-8);
}

/// Where a parameter is just at its limit, only one side is legal. What a spring that has caught the mass holds has nearly the same
/// slope by a viscous friction of 0 as by one of 0.01 g/s, which is far from the limit compared with the differences.
#[test]
fn parameter_at_its_limit_has_the_slope_of_those_beside_it() {
    let slopes = [0.0, 1e-5].map(|viscous| {
        let mut plant = setup(
            &friction_bench::MODEL,
            &[
                ("bench.drive", "Free".into()),
                ("friction.law", "StickSlipSpring".into()),
                ("friction.stickSlipSpring.sigma2", viscous.into()),
                ("velocity0", 0.5.into()),
                ("solver.relativeTolerance", 1e-10.into()),
            ],
        )
        .start(0.0)
        .expect("starts");
        plant.carry_sensitivities(&["friction.stickSlipSpring.sigma2"]).expect("a parameter");
        let mut found = Vec::new();
        for k in 1..=200 {
            plant.advance_to(f64::from(k) * 1e-3).expect("advances");
            if plant.get("sticking") == Ok(1.0) {
                found.push(["position", "frictionForce"].map(|name| of(&mut plant, name, 1)[0]));
            }
        }
        found
    });
    let [at, beside] = &slopes;
    assert!(at.len() == beside.len() && at.len() > 10, "{} and {}", at.len(), beside.len());
    for quantity in 0..2 {
        let largest = beside.iter().map(|slopes| slopes[quantity].abs()).fold(0.0, f64::max);
        for (at, beside) in at.iter().zip(beside) {
            let error = (at[quantity] - beside[quantity]).abs() / largest;
            // Differences by so little friction hold about five digits.
            assert!(largest > 0.0 && error < 2e-5, "{at:?} at the limit, {beside:?} beside it");
        }
    }
}

/// `T = 2*e0/V + (2/w)*(pi - atan(e0*w/V))` with `e0 = (Fs - Fc)/k` and `w^2 = k/m`.
#[test]
fn period_of_a_stick_slip_cycle_by_the_speed_of_pulling() {
    let mut plant = stick_slip().start(0.0).expect("starts");
    plant.carry_sensitivities(&["driveVelocity"]).expect("an input");
    plant.advance_to(40.0).expect("sticks and slips");
    let crossings = plant.crossings().to_vec();
    of(&mut plant, "position", 1);
    let releases: Vec<_> = crossings.iter().filter(|crossing| crossing.event == "breakAway").collect();
    assert!(releases.len() >= 4, "{releases:?}");
    let (offset, speed, rate) = (0.25, 0.1, 2.0f64.sqrt());
    let period = 2.0 * offset / speed + (2.0 / rate) * (PI - (offset * rate / speed).atan());
    let ratio = offset * rate / speed;
    let slope = -2.0 * offset / (speed * speed) + (2.0 / rate) * (ratio / speed) / (1.0 + ratio * ratio);
    for pair in releases.windows(2) {
        assert_near(&[pair[1].time - pair[0].time, pair[1].delays[0] - pair[0].delays[0]], &[period, slope], 1e-7);
    }
}

/// Runs the default experiment of the cylinder for a time in s, and looks after every step.
fn experiment(plant: &mut Plant, end: f64, mut look: impl FnMut(&mut Plant)) {
    for k in 0..(end * 1e3).round() as u32 {
        plant.set("valveVoltage", 5.0 + 2.0 * (TAU * f64::from(k) * 1e-3).sin()).expect("legal");
        plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
        look(plant);
    }
}

/// Positions of the default experiment.
fn positions(setup: &Setup, end: f64) -> Vec<f64> {
    let (mut plant, mut found) = (setup.start(0.0).expect("starts"), Vec::new());
    experiment(&mut plant, end, |plant| found.push(plant.get("position").expect("a variable")));
    found
}

/// Sensitivities of these positions, and those without.
fn sensitivities(setup: &Setup, end: f64, names: &[&str]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut plant = setup.start(0.0).expect("starts");
    plant.carry_sensitivities(names).expect("directions");
    let (mut slopes, mut found) = (vec![Vec::new(); names.len()], Vec::new());
    experiment(&mut plant, end, |plant| {
        found.push(plant.get("position").expect("a variable"));
        let rows = of(plant, "position", names.len());
        slopes.iter_mut().zip(rows).for_each(|(slopes, slope)| slopes.push(slope));
    });
    (slopes, found)
}

/// The largest distance between sensitivities and central differences, relative to the largest of these.
fn distance(setup: &Setup, end: f64, name: &str, slopes: &[f64], share: f64) -> f64 {
    let value = setup.get(name).expect("a parameter");
    let [above, below] = [1.0, -1.0].map(|sign| {
        let moved = setup.clone().set(name, value * (1.0 + sign * share)).expect("legal");
        positions(&moved, end)
    });
    let differences: Vec<f64> =
        above.iter().zip(below).map(|(above, below)| (above - below) / (2.0 * share * value)).collect();
    let largest = differences.iter().fold(0.0f64, |largest, slope| largest.max(slope.abs()));
    differences.iter().zip(slopes).fold(0.0f64, |worst, (one, other)| worst.max((one - other).abs())) / largest
}

fn cylinder(law: &str, tolerance: f64) -> Setup {
    let changes = [("friction.law", law.into()), ("solver.relativeTolerance", tolerance.into())];
    setup(&pneumatic_servo_cylinder::MODEL, &changes)
}

/// Differences of runs at a tolerance of 1e-10 hold five digits and more; of what the sensitivities are, they tell no more.
fn agrees_with_differences(law: &str, level: &str) {
    let names = ["valve.C", level, "mass.moving", "chamberA.pressure0", "supplyPressure"];
    let setup = cylinder(law, 1e-10);
    let (slopes, found) = sensitivities(&setup, 2.0, &names);
    assert!(found == positions(&setup, 2.0), "{law}: the values are the same bits with and without");
    for (name, slopes) in names.iter().zip(&slopes) {
        let distance = distance(&setup, 2.0, name, slopes, 3e-5);
        assert!(distance < 1e-5, "{law} by {name}: {distance}");
    }
}

#[test]
fn sensitivities_of_stribeck_are_those_of_differences() {
    agrees_with_differences("Stribeck", "friction.stribeck.Fs");
}

#[test]
fn sensitivities_of_polito_are_those_of_differences() {
    agrees_with_differences("Polito", "friction.polito.Fs");
}

#[test]
fn sensitivities_of_lugre_are_those_of_differences() {
    agrees_with_differences("LuGre", "friction.lugre.Fs");
}

#[test]
fn sensitivities_of_gms_are_those_of_differences() {
    agrees_with_differences("GMS", "friction.gms.Fs");
}

#[test]
fn sensitivities_of_karnopp_are_those_of_differences() {
    agrees_with_differences("Karnopp", "friction.karnopp.Fs");
}

/// Differences of runs of 0.25 s at a tolerance of 1e-9: most laws agree to 1e-6 and better. Slopes converge with the tolerance, more slowly
/// where elements slip one by one.
///
/// Under law Bristle bonds break one after the other: differences straddle some of the breaks.
#[test]
fn sensitivities_under_all_laws_are_those_of_differences() {
    for (_, law, _) in LAWS.items.iter().filter(|(_, law, _)| *law != "DNLRX") {
        let setup = cylinder(law, if *law == "MaxwellSlip" { 1e-10 } else { 1e-9 });
        let names = ["valve.C", "mass.moving", "valve.bandwidth"];
        let (slopes, _) = sensitivities(&setup, 0.25, &names);
        for (name, slopes) in names.iter().zip(&slopes) {
            // The motion depends little on the bandwidth.
            let bound = match (*law, *name) {
                ("Bristle", _) => 4e-3,
                (_, "valve.bandwidth") => 4e-5,
                _ => 1e-5,
            };
            let distance = distance(&setup, 0.25, name, slopes, 3e-5);
            assert!(distance < bound, "{law} by {name}: {distance}");
        }
    }
}

/// Law DNLRX holds its force between samples: on a free mass it acts as a delay, and small changes grow from sample to sample.
#[test]
fn law_that_holds_its_force_between_samples_is_refused_by_name() {
    for (_, law, _) in LAWS.items {
        let setup = cylinder(law, 1e-6);
        let mut plant = setup.start(0.0).expect("starts");
        let carried = plant.carry_sensitivities(&["mass.moving"]).err().map(|error| error.to_string());
        let step = plant.transition(1e-3, &[], &["position"]).err().map(|error| error.to_string());
        for refused in [carried, step] {
            assert_eq!(refused.is_some(), *law == "DNLRX", "{law}: {refused:?}");
            assert!(refused.is_none_or(|refused| refused.contains("friction.law = DNLRX")));
        }
    }
}

/// A run that starts at rest has another mode with any start velocity; one that starts on the move has the same.
#[test]
fn mode_that_differs_to_both_sides_is_told_by_time_and_reason() {
    let mut plant = cylinder("Stribeck", 1e-6).start(0.0).expect("starts");
    plant.carry_sensitivities(&["velocity0", "valve.C"]).expect("parameters");
    plant.advance_to(0.01).expect("advances");
    let told = plant.sensitivities(0).expect_err("no derivative").to_string();
    assert!(told.starts_with("the run has no derivative from t = 0 s on, at the start: the modes differ"), "{told}");
    assert!(plant.sensitivities(1).is_ok(), "other directions are none the worse");
}

/// Changes that slopes cannot follow end them; without names there are none to follow.
#[test]
fn sensitivities_begin_where_they_are_asked_for() {
    // With a play, a voltage that rests has no derivative: more of it moves the spool, less does not.
    let setup = cylinder("Stribeck", 1e-8).set("valve.hysteresis", 0.0).expect("legal");
    let mut plant = setup.start(0.0).expect("starts");
    plant.set("valveVoltage", 6.5).expect("legal");
    plant.advance_to(0.3).expect("advances");
    plant.carry_sensitivities(&["position", "valveVoltage", "chamberA.pressure0"]).expect("directions");
    plant.advance_to(0.301).expect("advances");
    let [of_position, of_voltage, of_start] = of(&mut plant, "position", 3)[..] else { panic!("three") };
    // A millisecond later the position is about where it was, and more voltage has not done much.
    assert!((of_position - 1.0).abs() < 1e-2 && of_voltage > 0.0 && of_voltage < 1e-4, "{of_position} {of_voltage}");
    assert_eq!(of_start, 0.0, "the start is over");
}

/// `C` belongs to the outputs at the end.
#[test]
fn transition_is_that_of_small_differences() {
    // With a play, the set point of a voltage that rests has no derivative: see `sensitivities_begin_where_they_are_asked_for`.
    let setup = cylinder("Stribeck", 1e-10).set("valve.hysteresis", 0.0).expect("legal");
    let mut plant = setup.start(0.0).expect("starts");
    plant.set("valveVoltage", 6.5).expect("legal");
    plant.advance_to(0.3).expect("slides");
    let saved = plant.save();
    let outputs = ["position", "velocity", "chamberA.pressure", "frictionForce"];
    let mut moved = |name: &str, change: f64| {
        plant.restore(&saved).expect("its own state");
        let value = plant.get(name).expect("a state");
        plant.move_state(name, value + change).expect("a state");
        plant.advance_to(0.301).expect("advances");
        outputs.map(|output| plant.get(output).expect("an output"))
    };
    let mut differences = |name: &str, change: f64| {
        let (above, below) = (moved(name, change), moved(name, -change));
        [0, 1, 2, 3].map(|row| (above[row] - below[row]) / (2.0 * change))
    };
    let expected =
        [("velocity", differences("velocity", 1e-6)), ("chamberA.pressure", differences("chamberA.pressure", 10.0))];
    plant.restore(&saved).expect("its own state");
    let step = plant.transition(1e-3, &[], &outputs).expect("a derivative");
    for (name, expected) in expected {
        let column = step.states.iter().position(|state| state == name).expect("a state");
        for (row, expected) in expected.into_iter().enumerate() {
            let found = step.c[row][column];
            // Differences of a step with errors of 1e-10 of the scales.
            assert!(
                (found - expected).abs() < 2e-5 * expected.abs().max(1e-9),
                "{} by {name}: {found}, not {expected}",
                outputs[row]
            );
        }
    }
    assert!(step.states.contains(&"valve.command".to_owned()), "where the play stands: {:?}", step.states);
    let position = step.next_states.iter().position(|state| state == "position").expect("a state");
    assert_eq!(step.a[position], step.c[0], "a state that is an output");
}

#[test]
fn transitions_refuse_what_is_no_parameter_and_no_output() {
    let mut plant = cylinder("Stribeck", 1e-6).start(0.0).expect("starts");
    let mut refused = |parameters: &[&str], outputs: &[&str]| {
        plant.transition(1e-3, parameters, outputs).expect_err("refused").to_string()
    };
    assert!(refused(&["position"], &[]).contains("with respect to position: it is no parameter"));
    assert!(refused(&[], &["valve.C"]).contains("valve.C: as an output: it is not computed"));
    assert!(refused(&[], &["position", "sticking"]).contains("sticking: as an output: it is no real number"));
    assert!(refused(&[], &["posiion"]).starts_with("there is no variable posiion; did you mean position"));
    assert_eq!(plant.time(), 0.0, "nothing has been done");
}

/// The reading of a sensor with a resolution changes in jumps; all else is none the worse, and without a resolution it has a slope.
#[test]
fn reading_that_is_rounded_has_no_slope() {
    for resolution in [1e-5, 0.0] {
        let setup = cylinder("Stribeck", 1e-8).set("sensor.position.sampleTime", 1e-3).expect("legal");
        let setup = setup.set("sensor.position.resolution", resolution).expect("legal");
        let mut plant = setup.start(0.0).expect("starts");
        plant.carry_sensitivities(&["valve.C"]).expect("a parameter");
        plant.set("valveVoltage", 6.5).expect("legal");
        plant.advance_to(0.3).expect("slides");
        let [reading, position] = ["sensor.position.reading", "position"].map(|name| of(&mut plant, name, 1)[0]);
        assert!(position > 1e6, "{position}");
        if resolution > 0.0 {
            assert!(reading.is_nan(), "{reading}");
        } else {
            // The sample of this very moment, by differences of one evaluation.
            assert_near(&[reading], &[position], 2e-8);
        }
    }
}

/// A force of just the static friction moves nothing, and any more does.
#[test]
fn input_that_brings_an_event_exactly_to_its_limit_is_told() {
    for (force, is_at_limit) in [(1.5, true), (1.4, false), (1.6, false)] {
        let setup = stick_slip().set("bench.drive", "Free").expect("a drive");
        let mut plant = setup.start(0.0).expect("starts");
        plant.carry_sensitivities(&["appliedForce", "friction.coulombStiction.Fs", "mass"]).expect("directions");
        plant.advance_to(0.1).expect("rests");
        plant.set("appliedForce", force).expect("legal");
        plant.advance_to(0.2).expect("advances");
        for direction in [0, 1] {
            let told = plant.sensitivities(direction).map_err(|error| error.to_string());
            assert_eq!(told.is_err(), is_at_limit, "{force} N: {told:?}");
            if let Err(told) = told {
                assert!(told.contains("t = 0.1 s on, at breakAway: an input brings it exactly to its limit"), "{told}");
            }
        }
        assert!(plant.sensitivities(2).is_ok(), "the mass does not matter to that");
    }
}

/// A direction of sliding is no state of a linear map, wherever a model keeps it: three trolleys have three contacts.
#[test]
fn directions_of_sliding_are_no_states() {
    let mut plant = Setup::new(&festoon::MODEL).start(0.0).unwrap();
    plant.set("pulseForce", 500.0).unwrap();
    plant.advance_to(0.2).unwrap();
    assert!(plant.get("trolley[1].velocity").unwrap() != 0.0, "a trolley slides");
    let step = plant.transition(0.01, &[], &["trolley[1].position"]).unwrap();
    let kept: Vec<_> = step.states.iter().chain(&step.next_states).filter(|name| name.ends_with(".Sliding")).collect();
    assert!(kept.is_empty(), "{kept:?}");
}

/// The pulse of a switching valve ends the later, the higher the voltage: what is read there is of a time that moves.
#[test]
fn pulses_of_switching_valves_end_later_with_the_voltage() {
    let at = |voltage: f64| {
        setup(
            &pneumatic_servo_cylinder::MODEL,
            &[
                ("actuation", "SwitchingValves".into()),
                ("valveVoltage", voltage.into()),
                ("solver.relativeTolerance", 1e-10.into()),
            ],
        )
        .start(0.0)
        .expect("starts")
    };
    let mut plant = at(7.0);
    plant.carry_sensitivities(&["valveVoltage"]).expect("an input");
    plant.advance_to(0.3).expect("runs");
    for name in ["position", "chamberA.pressure"] {
        let [above, below] = [1e-4, -1e-4].map(|change| {
            let mut plant = at(7.0 + change);
            plant.advance_to(0.3).expect("runs");
            plant.get(name).expect("a variable")
        });
        let found = of(&mut plant, name, 1);
        // Positions are good to 1e-12 m or so, and 0.2 mV change them by 2e-5 m.
        assert_near(&found, &[(above - below) / 2e-4], 2e-7);
    }
}
