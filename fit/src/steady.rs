//! Steady motions: runs at a constant velocity and load until what is recorded no longer changes.

use std::collections::BTreeMap;

use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::variables::Place;

use crate::experiment::Experiment;
use crate::refused::Refused;
use crate::runs::{COUNTED, Given, Run};

/// Input of a bench that is its velocity.
const VELOCITY: &str = "driveVelocity";
/// Time in s and path in m of the first half of a run: lags of a lubricant and deflections of bristles end within them, or the run
/// is doubled.
const TIME: f64 = 0.5;
const PATH: f64 = 5e-4;
/// Doublings after which friction is given up as not steady.
const DOUBLINGS: usize = 12;
/// Relative change of a recorded variable in the second half of a run below which it is steady.
const STEADY: f64 = 1e-6;

/// Recorded variables at the communication points, each of which is a steady motion of its own.
pub fn recorded(
    experiment: &dyn Experiment,
    given: &Given,
    outputs: &[&str],
    tolerance: f64,
    most: f64,
    goes_on: &dyn Fn(f64) -> bool,
) -> Run {
    let points = given.inputs[0].1.len();
    let mut run = Run { outputs: vec![vec![f64::NAN; points]; outputs.len()], steps: 0.0, failure: None };
    let mut known: BTreeMap<Vec<u64>, Vec<f64>> = BTreeMap::new();
    let base = match setup(experiment, given, tolerance) {
        Ok(base) => base,
        Err(failure) => return Run { failure: Some(failure), ..run },
    };
    for point in 0..points {
        if !goes_on(point as f64 / points as f64) {
            return Run { failure: Some(Refused("interrupted".to_owned())), ..run };
        }
        // Repeated points have one run.
        let inputs: Vec<(&str, f64)> = given.inputs.iter().map(|(name, course)| (*name, course[point])).collect();
        let key: Vec<u64> = inputs.iter().map(|(_, value)| value.to_bits()).collect();
        let found = match known.get(&key) {
            Some(found) => Ok(found.clone()),
            None => at(&base, &inputs, outputs, most, &mut run.steps),
        };
        match found {
            Ok(values) => {
                run.outputs.iter_mut().zip(&values).for_each(|(course, value)| course[point] = *value);
                known.insert(key, values);
            }
            Err(failure) => return Run { failure: Some(failure), ..run },
        }
    }
    run
}

/// A bench under settings.
fn setup(experiment: &dyn Experiment, given: &Given, tolerance: f64) -> Result<Setup, Refused> {
    let mut setup = Setup::new(experiment.given().model);
    setup.change("solver.relativeTolerance", tolerance)?;
    for (name, value) in &given.settings {
        setup.change(name, *value)?;
    }
    Ok(setup)
}

/// Recorded variables at constant inputs, once they are steady.
fn at(base: &Setup, inputs: &[(&str, f64)], outputs: &[&str], most: f64, steps: &mut f64) -> Result<Vec<f64>, Refused> {
    let mut setup = base.clone();
    for (name, value) in inputs {
        setup.change(name, *value)?;
    }
    let refused = |error: &dyn std::fmt::Display| Refused(error.to_string());
    let mut plant = setup.start(0.0).map_err(|error| refused(&error))?;
    let place_of = |name: &str| base.table().find(name).expect("a variable of the model").place;
    let places: Vec<Place> = outputs.iter().map(|name| place_of(name)).collect();
    let counted = COUNTED.map(place_of);
    let velocity = inputs.iter().find(|(name, _)| *name == VELOCITY).map_or(0.0, |(_, velocity)| *velocity);
    let path = if velocity == 0.0 { 0.0 } else { PATH / velocity.abs() };
    let read = |plant: &mut Plant| places.iter().map(|place| plant.value(*place)).collect::<Vec<f64>>();
    let mut time = TIME + path;
    plant.advance_to(time).map_err(|error| refused(&error))?;
    let mut before = read(&mut plant);
    for _ in 0..DOUBLINGS {
        time *= 2.0;
        plant.advance_to(time).map_err(|error| refused(&error))?;
        let after = read(&mut plant);
        let is_steady = |(before, after): (&f64, &f64)| (after - before).abs() <= STEADY * after.abs();
        let done = before.iter().zip(&after).all(is_steady);
        if done {
            *steps += counted.iter().map(|place| plant.value(*place)).sum::<f64>();
            if *steps > most {
                return Err(Refused(format!(
                    "at a velocity of {velocity} m/s the points were given up after {steps} solver steps of {most}"
                )));
            }
            return Ok(after);
        }
        before = after;
    }
    Err(Refused(format!("at a velocity of {velocity} m/s friction is not steady after {time} s")))
}
