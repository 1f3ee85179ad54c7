//! Sensors of a rig: readings beside the quantities, without effect on the motion.

use std::f64::consts::TAU;

use crate::bounds::close;
use crate::rig::{Rig, Running};
use pneumatic_servo::conformance::Host;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const SENSORS: [(&str, &str); 4] = [
    ("position", "position"),
    ("pressureA", "chamberA.pressure"),
    ("pressureB", "chamberB.pressure"),
    ("force", "rodForce"),
];

fn with(law: &str, values: &[(&str, f64)]) -> Rig {
    values.iter().fold(Rig::cylinder(law), |rig, (name, value)| rig.set(name, *value))
}

/// Runs to the end of a step under a sine of 2 V and 1 Hz.
fn step(running: &mut Running, number: u32) {
    let time = f64::from(number) * 1e-3;
    running.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
    running.advance(time + 1e-3).unwrap();
}

#[test]
fn sensors_without_faults_read_the_quantities() {
    for law in ["Stribeck", "GMS"] {
        let mut running = Rig::cylinder(law).start().unwrap();
        for number in 0..300 {
            step(&mut running, number);
            for (sensor, quantity) in SENSORS {
                assert_eq!(running.get(&format!("sensor.{sensor}.reading")), running.get(quantity), "{quantity}");
            }
        }
    }
}

#[test]
fn readings_are_shown_in_the_units_of_their_quantities() {
    let table = MODEL.table();
    let display = |name: &str| table.find(name).expect(name).variable.display;
    for (sensor, quantity) in SENSORS {
        for name in ["reading", "lagged"] {
            assert_eq!(display(&format!("sensor.{sensor}.{name}")), display(quantity), "{quantity}");
        }
    }
}

/// Sensors change nothing of the measured quantities, but for the ends of the solver's steps.
#[test]
fn carriage_does_not_feel_its_sensors() {
    let faulty = [
        ("sensor.position.offset", 1e-3),
        ("sensor.position.lag", 0.01),
        ("sensor.pressureA.noise", 1e4),
        ("sensor.pressureA.sampleTime", 3e-3),
        ("sensor.force.resolution", 0.5),
        ("sensor.force.sampleTime", 7e-4),
    ];
    let run = |rig: Rig| {
        let mut running = rig.set("solver.relativeTolerance", 1e-8).start().unwrap();
        (0..500).for_each(|number| step(&mut running, number));
        running.get("position")
    };
    let (with, without) = (run(with("Stribeck", &faulty)), run(Rig::cylinder("Stribeck")));
    close(with, without, 1e-10, "m");
    assert!((with - 0.25).abs() > 0.01, "{with} m");
}

/// A force on the held carriage jumps, and with it the force of the rod; what the lag hands on follows as `1 - exp(-t/tau)`.
#[test]
fn lag_follows_a_step_exponentially() {
    let rig = with("Stribeck", &[("sensor.force.lag", 0.02), ("sensor.force.offset", 0.5), ("cylinder.rodA", 0.006)]);
    let mut running = rig.set("valve.leakage", 0.0).start().unwrap();
    running.advance(0.5).unwrap();
    let before = running.get("rodForce");
    close(running.get("sensor.force.reading") - before, 0.5, 5e-15, "lag follows a step exponentially");
    running.set("externalForce", -8.0);
    for number in 1..=100 {
        let time = f64::from(number) * 1e-3;
        running.advance(0.5 + time).unwrap();
        let expected = before + 0.5 + 8.0 * (1.0 - (-time / 0.02).exp());
        let found = running.get("sensor.force.reading");
        assert!(running.get("sticking") == 1.0);
        close(found, expected, 1e-6, "N");
    }
}

/// The lag of a moving quantity, integrated from outside: exactly along straight lines through points 0.1 ms apart, whose
/// error of 1e-8 times the acceleration in m/s2 over 8 is far below the bound.
#[test]
fn lag_is_that_of_a_filter_outside() {
    const TAU_LAG: f64 = 5e-3;
    let mut running = with("LuGre", &[("sensor.position.lag", TAU_LAG), ("valveVoltage", 7.0)]).start().unwrap();
    let (mut filtered, mut before, interval) = (0.25, 0.25, 1e-4);
    let decay = (-interval / TAU_LAG).exp();
    for number in 1..=3000 {
        running.advance(f64::from(number) * interval).unwrap();
        let now = running.get("position");
        let slope = (now - before) / interval;
        filtered = now - slope * TAU_LAG + (filtered - before + slope * TAU_LAG) * decay;
        before = now;
        let found = running.get("sensor.position.reading");
        close(found, filtered, 5e-8, "m");
    }
    assert!((before - filtered).abs() > 1e-4, "the carriage moves: {before} m");
}

/// At each communication point on a sample the reading is this point's, independent of the steps in between.
#[test]
fn reading_is_the_rounded_quantity_of_the_last_sample() {
    let sensor = [("sensor.position.sampleTime", 2e-3), ("sensor.position.resolution", 1e-5)];
    let rounded = |position: f64| 1e-5 * (position / 1e-5).round();
    let mut running = with("Stribeck", &sensor).start().unwrap();
    let mut expected = rounded(0.25);
    assert_eq!(running.get("sensor.position.reading"), expected);
    for number in 0..400 {
        step(&mut running, number);
        if number % 2 == 1 {
            expected = rounded(running.get("position"));
        }
        assert_eq!(running.get("sensor.position.reading"), expected, "after step {number}");
    }
    assert!(expected != rounded(0.25));
}

/// The same samples in steps of 1 ms, of 10 ms, and of any length.
#[test]
fn readings_do_not_depend_on_the_communication_steps() {
    let sensor = [
        ("sensor.pressureA.sampleTime", 1e-3),
        ("sensor.pressureA.noise", 500.0),
        ("sensor.pressureA.resolution", 100.0),
        ("valveVoltage", 6.0),
    ];
    let run = |ends: &[f64]| {
        let mut running = with("Stribeck", &sensor).set("solver.relativeTolerance", 1e-10).start().unwrap();
        ends.iter().for_each(|end| running.advance(*end).unwrap());
        running.get("sensor.pressureA.reading")
    };
    let many: Vec<f64> = (1..=100).map(|number| f64::from(number) * 1e-3).collect();
    let (fine, coarse, odd) = (run(&many), run(&[0.1]), run(&[0.0123, 0.0501, 0.1]));
    assert_eq!([coarse, odd], [fine; 2]);
    assert_eq!(fine % 100.0, 0.0);
}

#[test]
fn noise_depends_on_the_seed_alone_and_differs_between_sensors() {
    let noise = |seed: f64| {
        let values = [
            ("sensor.seed", seed),
            ("sensor.pressureA.sampleTime", 1e-3),
            ("sensor.pressureA.noise", 100.0),
            ("sensor.pressureB.sampleTime", 1e-3),
            ("sensor.pressureB.noise", 100.0),
        ];
        let mut running = with("Stribeck", &values).start().unwrap();
        let mut errors = Vec::new();
        for number in 1..=500 {
            running.advance(f64::from(number) * 1e-3).unwrap();
            let error = |running: &mut Running, side: &str| {
                running.get(&format!("sensor.pressure{side}.reading")) - running.get(&format!("chamber{side}.pressure"))
            };
            errors.push([error(&mut running, "A"), error(&mut running, "B")]);
        }
        errors
    };
    let first = noise(1.0);
    assert_eq!(first, noise(1.0));
    assert_ne!(first, noise(2.0));
    let mean = |of: fn(&[f64; 2]) -> f64| first.iter().map(of).sum::<f64>() / 500.0;
    let [deviation, together] = [mean(|[a, _]| a * a).sqrt(), mean(|[a, b]| a * b) / 1e4];
    // Of 500 numbers, within four standard deviations.
    assert!((deviation / 100.0 - 1.0).abs() < 0.13 && together.abs() < 0.18, "{deviation} Pa, {together}");
}

#[test]
fn saved_noise_goes_on_bit_for_bit() {
    let values = [
        ("sensor.force.lag", 1e-3),
        ("sensor.force.sampleTime", 1e-3),
        ("sensor.force.noise", 0.2),
        ("hoseA.length", 0.5),
        ("valveVoltage", 7.0),
    ];
    let mut running = with("GMS", &values).start().unwrap();
    running.advance(0.0995).unwrap();
    let saved = running.simulation().save();
    let names = ["sensor.force.reading", "sensor.force.lagged", "position", "hoseA.massFlow[2]"];
    running.advance(0.15).unwrap();
    let first = names.map(|name| running.get(name).to_bits());
    running.simulation().restore(&saved).unwrap();
    running.advance(0.15).unwrap();
    assert_eq!(names.map(|name| running.get(name).to_bits()), first);
}

#[test]
fn noise_without_samples_is_refused_by_name() {
    let error = with("Stribeck", &[("sensor.pressureB.noise", 10.0)]).start().err().unwrap();
    let expected = "sensor.pressureB.noise = 10 is refused: only samples have it: set sampleTime, too";
    assert_eq!(error.to_string(), expected);
}

/// A host with a solver of its own integrates the lags and is told the samples.
#[test]
fn solver_outside_sees_the_same_readings() {
    let mut setup = Setup::new(&MODEL).set("friction.law", "LuGre").unwrap();
    for (name, value) in [
        ("valveVoltage", 7.0),
        ("sensor.position.lag", 2e-3),
        ("sensor.pressureA.sampleTime", 1.5e-3),
        ("sensor.pressureA.noise", 100.0),
        ("solver.relativeTolerance", 1e-9),
    ] {
        setup.change(name, value).unwrap();
    }
    let table = setup.table();
    let counts = [table.number_of_states(), MODEL.indicators().len()];
    let model = setup.exchange(0.0).unwrap().unwrap();
    let mut host =
        Host::new(model, setup.inputs(), counts, |_, inputs| inputs[..3].copy_from_slice(&[7.0, 0.0, 5e5]), 1e-9);
    let mut inside = setup.start(0.0).unwrap();
    for number in 1..=50 {
        let time = f64::from(number) * 1e-3 + 1e-4;
        host.advance(time);
        inside.advance_to(time).unwrap();
        let mut computed = vec![0.0; table.computed().count()];
        host.model.values(&mut computed);
        for (name, allowed) in [("sensor.position.reading", 1e-8), ("sensor.pressureA.reading", 2e-3)] {
            let place = table.computed().position(|variable| variable.name == name).unwrap();
            let (found, expected) = (computed[place], inside.get(name).unwrap());
            close(found, expected, allowed, format_args!("{name} at {time} s, inside {expected}"));
        }
    }
}
