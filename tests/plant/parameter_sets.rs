//! The packaged parameter sets do what they say.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::bounds::{close, within};
use crate::rig::{Rig, Value};
use serde::Deserialize;

#[derive(Deserialize)]
struct Set {
    name: String,
    values: BTreeMap<String, Value>,
}

/// A rig with those values of a set whose names start with a prefix.
fn with(rig: Rig, set: &str, prefix: &str) -> Rig {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("modelDescription/parameter_sets.json");
    let text = std::fs::read_to_string(file).expect("the sets");
    let sets: Vec<Set> = serde_json::from_str(&text).expect("well-formed sets");
    let set = sets.into_iter().find(|candidate| candidate.name == set).expect("a set of that name");
    rig.with(set.values.iter().filter(|(name, _)| name.starts_with(prefix)))
}

/// The virgin curve of the thesis, `y(1 um)` = 3.892 N and `y(2 um)` = 6.747 N, under a force held in between its steps.
#[test]
fn presliding_set_follows_its_virgin_curve() {
    let curve = |x: f64| 1.483e6 * x + 5.595 * (1.0 - (-5.631e5 * x).exp());
    let mut run = with(Rig::new("FrictionBench"), "PreslidingLeuven", "friction.")
        .choose("bench.drive", "Free")
        .set("solver.relativeTolerance", 1e-8)
        .start()
        .unwrap();
    let mut step = 0;
    for (displacement, expected) in [(1e-6, 3.892), (2e-6, 6.747)] {
        let force = curve(displacement);
        close(force, expected, 5e-4, "N");
        let last = (force * 100.0) as i32;
        while step <= last {
            run.set("appliedForce", f64::from(step) / 100.0);
            step += 1;
            run.advance(f64::from(step) * 0.02).unwrap();
        }
        run.set("appliedForce", force);
        step += 1;
        run.advance(f64::from(step) * 0.02).unwrap();
        // Each step of the force overshoots by a little, which the hysteresis keeps.
        let found = run.get("position");
        close(found / displacement, 1.0, 1e-5, format_args!("{found} m at {force} N"));
    }
}

/// The voltage about which the regulator oscillates holds the air spring of the plugged chamber in balance.
#[test]
fn regulator_sets_start_in_balance() {
    for set in ["SlidingRegulatorPolito", "SlidingRegulatorLuGre"] {
        let mut run = with(Rig::new("PneumaticServoCylinder"), set, "").start().unwrap();
        for step in 1..=20 {
            run.advance(f64::from(step) * 0.1).unwrap();
            // Far below the Coulomb friction of 0.7 N.
            let force = run.get("frictionForce");
            within(force.abs(), 0.01, format_args!("{set}, N"));
            close(run.get("position"), 0.25, 2e-6, format_args!("{set}, m"));
        }
    }
}

/// At the voltage of the set the carriage starts late and goes on in steps or creeps, as at the edge of the dead zone.
#[test]
fn transition_sets_move_slowly_after_a_rest() {
    for set in ["TransitionPolito", "TransitionDahl", "TransitionLuGre"] {
        let rig = with(Rig::new("PneumaticServoCylinder"), set, "");
        let mut run = rig.set("position0", 0.05).start().unwrap();
        run.advance(1.0).unwrap();
        close(run.get("position"), 0.05, 1.5e-3, format_args!("{set} rests at first"));
        run.advance(10.0).unwrap();
        let path = run.get("position") - 0.05;
        assert!(path > 5e-3 && path < 0.3, "{set}: {path} m in 10 s");
    }
}
