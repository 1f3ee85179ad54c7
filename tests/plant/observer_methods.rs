//! The two filters of an observer: the unscented one holds where a step has no useful derivative, and is the extended one where it has.

#![cfg(feature = "sensitivities")]

use std::error::Error;

use pneumatic_servo::model::{Method, Observed, Observer, Setup};
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo::numbers::random;
use pneumatic_servo::variables::find;

const PERIOD: f64 = 1e-3;
const NOISE: f64 = 20e-6;
const SHOWN: [&str; 4] = ["velocity", "frictionForce", "chamberA.pressure", "chamberB.pressure"];

/// Estimates, their deviations and the true values at a step.
struct Row {
    found: [f64; SHOWN.len()],
    deviation: [f64; SHOWN.len()],
    real: [f64; SHOWN.len()],
}

/// Lets an observer follow a plant under a voltage.
fn follow(
    law: &str,
    method: Method,
    measured: &[(&str, f64)],
    process: &[(&str, f64)],
    voltage: impl Fn(f64) -> f64,
    steps: usize,
) -> Result<Vec<Row>, Box<dyn Error>> {
    let setup = Setup::new(&MODEL).set("friction.law", law)?.set("supplyPressure", 6e5)?;
    let observed = Observed { measured, period: PERIOD, process, initial: &[], method };
    let (mut plant, mut observer) = (setup.start(0.0)?, Observer::new(&setup, observed)?);
    let (mut inputs, mut generator) = (setup.inputs().to_vec(), 7);
    let mut rows = Vec::new();
    for step in 0..steps {
        inputs[0] = voltage(step as f64 * PERIOD);
        plant.set_input(0, inputs[0])?;
        plant.step(PERIOD)?;
        let mut read = Vec::new();
        for (name, noise) in measured {
            read.push(Some(plant.get(name)? + noise * random::normal(&mut generator)));
        }
        observer.update(&inputs, &read)?;
        let mut row = Row { found: [0.0; 4], deviation: [0.0; 4], real: [0.0; 4] };
        for (index, name) in SHOWN.into_iter().enumerate() {
            let place = find(setup.table(), name)?.place;
            row.found[index] = observer.value(place);
            row.deviation[index] = observer.deviation(place);
            row.real[index] = plant.get(name)?;
        }
        rows.push(row);
    }
    Ok(rows)
}

/// A motion with reversals and rests.
fn to_and_fro(time: f64) -> f64 {
    let wave = |frequency: f64| libm::sin(std::f64::consts::TAU * frequency * time);
    5.0 + 1.2 * wave(0.8) + 0.5 * wave(2.3)
}

/// Shares of the rows in which each of the estimates is within twice its band of 95 %.
fn within_bands(rows: &[Row]) -> [f64; SHOWN.len()] {
    std::array::from_fn(|i| {
        let is_inside = |row: &&Row| (row.found[i] - row.real[i]).abs() < 2.0 * 1.96 * row.deviation[i] + 1e-9;
        rows.iter().filter(is_inside).count() as f64 / rows.len() as f64
    })
}

/// The bonds of a bristle law, which the filter does not estimate, break within the spread of its points.
#[test]
fn unscented_filter_knows_its_errors_under_bristles() -> Result<(), Box<dyn Error>> {
    let shares =
        |method| follow("Bristle", method, &[("position", NOISE)], &[], to_and_fro, 600).map(|it| within_bands(&it));
    let (extended, unscented) = (shares(Method::Extended)?, shares(Method::Unscented)?);
    let [velocity, friction, pressures @ ..] = unscented;
    assert!(velocity > 0.95 && friction > 0.7 && pressures.iter().all(|it| *it > 0.9), "{unscented:?}");
    assert!(friction > extended[1] + 0.05, "{extended:?}");
    Ok(())
}

/// With measured states, and with an acceleration beside them, whose slopes are those of a regression in one filter and exact in the
/// other; with an unknown force.
#[test]
fn filters_agree_while_the_carriage_slides() -> Result<(), Box<dyn Error>> {
    let all = [("position", NOISE), ("chamberA.pressure", 500.0), ("chamberB.pressure", 500.0), ("acceleration", 0.5)];
    for measured in [&all[..3], &all] {
        let rows = |method| follow("Stribeck", method, measured, &[("externalForce", 5.0)], |_| 6.0, 600);
        let (extended, unscented) = (rows(Method::Extended)?, rows(Method::Unscented)?);
        for (step, (one, other)) in extended.iter().zip(&unscented).enumerate().skip(200) {
            assert!(one.real[0] > 0.05, "it slides");
            for (place, name) in SHOWN.into_iter().enumerate() {
                let [this, that] = [one.deviation[place], other.deviation[place]];
                assert!((this / that - 1.0).abs() < 0.03, "deviation of {name} at {step}: {this} and {that}");
                let difference = (one.found[place] - other.found[place]).abs();
                assert!(difference < 0.05 * this, "{name} at {step}: {difference} beside {this}");
            }
        }
    }
    Ok(())
}

/// An estimate does not move the reading of a sensor that is held between samples, so that a measurement of it would be left out in
/// silence; a reading without samples moves.
#[test]
fn reading_that_is_held_between_samples_is_refused() -> Result<(), Box<dyn Error>> {
    let setup = Setup::new(&MODEL).set("sensor.position.offset", 1e-4)?;
    let measured = [("sensor.position.reading", NOISE)];
    for method in [Method::Extended, Method::Unscented] {
        let observed = Observed { measured: &measured, period: PERIOD, process: &[], initial: &[], method };
        Observer::new(&setup, observed)?;
        let sampled = setup.clone().set("sensor.position.sampleTime", 1e-3)?;
        for setup in [sampled.clone(), sampled.set("sensor.position.resolution", 1e-5)?] {
            let refused = Observer::new(&setup, observed).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(
                refused.contains("sensor.position.reading") && refused.contains("held between samples"),
                "{refused}"
            );
        }
    }
    Ok(())
}
