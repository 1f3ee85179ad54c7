//! Every trajectory of `tests/reference` (independent solvers, a second formulation) is reproduced.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

use crate::bounds::{larger, within};
use crate::rig::{Rig, Value};
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

/// Largest deviations in position (m), velocity (m/s), pressure (Pa), temperature (K) and spool, rms deviation in friction
/// force (N), and share of the rows that differ in sticking.
#[derive(Debug, Default)]
struct Deviation {
    position: f64,
    velocity: f64,
    pressure: f64,
    temperature: f64,
    spool: f64,
    friction: f64,
    sticking: f64,
}

/// The columns of a trajectory after its time.
const COLUMNS: [&str; 9] = [
    "position",
    "velocity",
    "chamberA.pressure",
    "chamberA.temperature",
    "chamberB.pressure",
    "chamberB.temperature",
    "valve.spool",
    "frictionForce",
    "sticking",
];

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
    let (mut squares, mut differ, mut count) = (0.0, 0u32, 0u32);
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
        let (_, expected) = row.split_first().expect("a time");
        assert_eq!(expected.len(), COLUMNS.len(), "{}", case.name);
        let mut apart = COLUMNS.iter().zip(expected).map(|(name, expected)| (running.get(name) - expected).abs());
        let [x, v, pressure_a, temperature_a, pressure_b, temperature_b, spool, friction, sticking] =
            std::array::from_fn(|_| apart.next().expect("a column"));
        worst.position = larger(worst.position, x);
        worst.velocity = larger(worst.velocity, v);
        worst.pressure = larger(worst.pressure, larger(pressure_a, pressure_b));
        worst.temperature = larger(worst.temperature, larger(temperature_a, temperature_b));
        worst.spool = larger(worst.spool, spool);
        squares += friction.powi(2);
        differ += u32::from(sticking != 0.0);
        count += 1;
    }
    assert_eq!(count as usize, (case.stop_time / case.output_step).round() as usize + 1, "{}", case.name);
    worst.friction = (squares / f64::from(count)).sqrt();
    worst.sticking = f64::from(differ) / f64::from(count);
    worst
}

/// Runs all cases at a tolerance and holds their deviations against what is allowed.
fn compare(tolerance: f64, allowed: &Deviation) {
    for case in cases() {
        let found = deviation(&case, tolerance);
        println!("{:32} {found:?}", case.name);
        let at = |quantity| format!("{}, {quantity}", case.name);
        within(found.position, allowed.position, at("position"));
        within(found.velocity, allowed.velocity, at("velocity"));
        within(found.pressure, allowed.pressure, at("pressure"));
        within(found.temperature, allowed.temperature, at("temperature"));
        within(found.spool, allowed.spool, at("spool"));
        within(found.friction, allowed.friction, at("friction force"));
        within(found.sticking, allowed.sticking, at("sticking"));
    }
}

/// The references are good to 4e-9 m, 8e-7 m/s, 0.03 Pa, 5e-5 K and 2e-10 of the spool's range; their friction forces to
/// 1e-4 N in the worst row, some hundredths of which remain of the rms (see `tests/reference/README.md`).
#[test]
fn tight_tolerance_reproduces_the_independent_solutions() {
    let allowed = Deviation {
        position: 5e-9,
        velocity: 1e-6,
        pressure: 0.03,
        temperature: 5e-5,
        spool: 1e-9,
        friction: 3e-5,
        sticking: 0.0,
    };
    compare(1e-10, &allowed);
}

/// The default tolerance allows 1e-7 m and 0.5 Pa per step; over 3000 steps, most of which are far better, a few times
/// that adds up. The friction force jumps when sliding starts or stops, which makes its rms depend on event times.
#[test]
fn default_tolerance_is_accurate_to_a_micrometre_and_a_pascal() {
    let allowed = Deviation {
        position: 1e-6,
        velocity: 1e-4,
        pressure: 1.0,
        temperature: 1e-3,
        spool: 1e-5,
        friction: 1e-3,
        sticking: 0.0,
    };
    compare(1e-6, &allowed);
}
