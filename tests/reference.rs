//! Every trajectory of `tests/reference` (independent solvers, a second formulation) is reproduced.

mod rig;

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

use rig::{Rig, Value};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Case {
    name: String,
    model: String,
    parameters: BTreeMap<String, Value>,
    inputs: BTreeMap<String, Signal>,
    stop_time: f64,
    communication_step: f64,
    output_step: f64,
    file: String,
}

/// A constant, or `offset + amplitude*sin(2*pi*frequency*t)`.
#[derive(Deserialize)]
#[serde(untagged)]
enum Signal {
    Constant(f64),
    Sine { offset: f64, amplitude: f64, frequency: f64 },
}

impl Signal {
    fn at(&self, time: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Sine { offset, amplitude, frequency } => offset + amplitude * (TAU * frequency * time).sin(),
        }
    }
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference")
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string(folder().join("cases.json")).expect("tests/reference/cases.json");
    serde_json::from_str(&text).expect("well-formed cases")
}

/// Largest deviations in position (m) and pressure (Pa), and rms deviation in friction force (N).
#[derive(Debug, Default)]
struct Deviation {
    position: f64,
    pressure: f64,
    friction: f64,
}

fn deviation(case: &Case, tolerance: f64) -> Deviation {
    let mut rig = Rig::new(&case.model).set("solver.relativeTolerance", tolerance).with(&case.parameters);
    for (name, signal) in &case.inputs {
        rig = rig.set(name, signal.at(0.0));
    }
    let mut running = rig.start().unwrap_or_else(|error| panic!("{}: {error}", case.name));
    let text = std::fs::read_to_string(folder().join(&case.file)).expect("the trajectory");
    let rows = text
        .lines()
        .skip(1)
        .map(|line| -> Vec<f64> { line.split(',').map(|cell| cell.parse().expect("a number")).collect() });
    let steps_per_row = (case.output_step / case.communication_step).round() as usize;
    let mut worst = Deviation::default();
    let mut squares = 0.0;
    let mut count = 0u32;
    for (index, row) in rows.enumerate() {
        if index > 0 {
            for step in (index - 1) * steps_per_row..index * steps_per_row {
                let (time, end) = (step as f64 * case.communication_step, (step + 1) as f64 * case.communication_step);
                for (name, signal) in &case.inputs {
                    running.set(name, signal.at(time));
                }
                running.advance(end).unwrap_or_else(|error| panic!("{}: {error}", case.name));
            }
        }
        let mut apart = |name: &str, column: usize| (running.get(name) - row[column]).abs();
        worst.position = worst.position.max(apart("position", 1));
        worst.pressure = worst.pressure.max(apart("chamberA.pressure", 3)).max(apart("chamberB.pressure", 5));
        squares += apart("frictionForce", 8).powi(2);
        count += 1;
    }
    assert_eq!(count as usize, (case.stop_time / case.output_step).round() as usize + 1, "{}", case.name);
    worst.friction = (squares / f64::from(count)).sqrt();
    worst
}

/// Runs all cases at a tolerance and reports those that deviate by more than allowed.
fn compare(tolerance: f64, allowed: &Deviation) {
    let mut failures = String::new();
    for case in cases() {
        let found = deviation(&case, tolerance);
        println!("{:32} {found:?}", case.name);
        if found.position > allowed.position || found.pressure > allowed.pressure || found.friction > allowed.friction {
            failures += &format!("{}: {found:?}\n", case.name);
        }
    }
    assert!(failures.is_empty(), "beyond {allowed:?}:\n{failures}");
}

/// The references are good to 4e-9 m, 0.03 Pa and 1e-4 N (see `tests/reference/README.md`).
#[test]
fn tight_tolerance_reproduces_the_independent_solutions() {
    compare(1e-10, &Deviation { position: 1e-8, pressure: 0.05, friction: 1e-4 });
}

/// The default tolerance allows 1e-7 m and 0.5 Pa per step; over 3000 steps, most of which are far better, a few times
/// that adds up. The friction force jumps when sliding starts or stops, which makes its rms depend on event times.
#[test]
fn default_tolerance_is_accurate_to_a_micrometre_and_a_pascal() {
    compare(1e-6, &Deviation { position: 1e-6, pressure: 1.0, friction: 1e-3 });
}
