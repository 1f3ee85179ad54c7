//! The trajectories of `tests/reference/systems.json` and `sensors.json` (SciPy, other unknowns) are reproduced.

use std::collections::BTreeMap;
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
    /// Times in s and the values from there on.
    inputs: BTreeMap<String, Vec<(f64, f64)>>,
    stop_time: f64,
    output_step: f64,
    columns: Vec<String>,
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference")
}

fn cases(file: &str) -> Vec<Case> {
    let text = std::fs::read_to_string(folder().join(file)).expect(file);
    serde_json::from_str(&text).expect("well-formed cases")
}

/// Largest deviation of each column.
fn deviations(case: &Case, tolerance: f64) -> BTreeMap<&str, f64> {
    let mut rig = Rig::new(&case.model).set("solver.relativeTolerance", tolerance).with(&case.parameters);
    for (name, steps) in &case.inputs {
        rig = rig.set(name, steps[0].1);
    }
    let mut run = rig.start().unwrap_or_else(|error| panic!("{}: {error}", case.name));
    let text = std::fs::read_to_string(folder().join(format!("{}.csv", case.name))).expect("the trajectory");
    let mut worst = BTreeMap::new();
    let mut rows = 0;
    for line in text.lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        run.advance(row[0]).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        for (name, steps) in &case.inputs {
            if let Some((_, value)) = steps.iter().find(|(time, _)| *time == row[0]) {
                run.set(name, *value);
            }
        }
        for (column, expected) in case.columns.iter().zip(&row[1..]) {
            let apart = (run.get(column) - expected).abs();
            let largest = worst.entry(column.as_str()).or_insert(0.0f64);
            *largest = larger(*largest, apart);
        }
        rows += 1;
    }
    assert_eq!(rows, (case.stop_time / case.output_step).round() as usize + 1, "{}", case.name);
    worst
}

/// Bounds of lengths and angles, and of their rates.
struct Allowed {
    lengths: f64,
    rates: f64,
    /// In Pa and N, of what sensors measure.
    pressures: f64,
    forces: f64,
}

/// Runs all cases of a file at a tolerance and holds each column against what is allowed; what is counted agrees.
fn compare(file: &str, tolerance: f64, allowed: &Allowed) {
    for case in cases(file) {
        for (column, found) in deviations(&case, tolerance) {
            let at = format!("{}, {column}", case.name);
            println!("{at:50} {found:.1e}");
            match column.rsplit('.').next() {
                Some("sticking" | "impacts") => assert_eq!(found, 0.0, "{at}"),
                Some("velocity" | "relativeVelocity" | "displacementRate") => within(found, allowed.rates, at),
                _ if column.contains("pressure") => within(found, allowed.pressures, at),
                _ if column.to_lowercase().contains("force") => within(found, allowed.forces, at),
                _ => within(found, allowed.lengths, at),
            }
        }
    }
}

/// Measured: 9e-12 m and rad, 1e-10 m/s. The references themselves change by 2e-9 m from tolerance 1e-10 to 1e-12.
#[test]
fn tight_tolerance_reproduces_the_independent_solutions() {
    compare("systems.json", 1e-10, &Allowed { lengths: 1e-10, rates: 1e-9, pressures: 0.0, forces: 0.0 });
}

/// The default tolerance allows 1e-9 m (slider, vibro-impact) to 1e-8 m (festoon) per step, over hundreds of steps.
#[test]
fn default_tolerance_is_accurate_to_a_tenth_of_a_micrometre() {
    compare("systems.json", 1e-6, &Allowed { lengths: 1e-7, rates: 2e-6, pressures: 0.0, forces: 0.0 });
}

/// A rounded reading differs by its resolution or not at all. The references change by 2e-9 m, 4e-3 Pa and 3e-6 N from
/// tolerance 1e-9 to 1e-11.
#[test]
fn sensors_read_what_the_independent_solution_reads() {
    compare("sensors.json", 1e-10, &Allowed { lengths: 3e-10, rates: 0.0, pressures: 2e-4, forces: 3e-7 });
}

#[test]
fn sensors_read_it_to_a_tenth_of_a_micrometre_by_default() {
    compare("sensors.json", 1e-6, &Allowed { lengths: 1e-7, rates: 0.0, pressures: 0.05, forces: 1e-4 });
}
