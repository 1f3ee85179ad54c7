//! Causes of residuals that are in proportion to every change: projections tell the answers.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use pneumatic_servo_fit::causes::{Candidates, Cause, Change, Changeable, Choice, causes, is_quiet};
use pneumatic_servo_fit::parameter::Parameter;
use pneumatic_servo_fit::problem::{Interrupted, Problem, STEP, Segment, Simulated};
use pneumatic_servo_fit::sensor::Sensor;

/// Samples of each of two signals, and their noise.
const SAMPLES: usize = 30;
const NOISE: [f64; 2] = [0.5, 0.2];
/// Numbers of the traces, in units of the noise, of the estimated parameter and of faults.
const FREE: usize = 3;
const OFFSET: usize = 7;
const DELAY: usize = 10;
const OTHER: usize = 17;

type Trace = Vec<f64>;

/// One of 60 traces that are orthogonal to each other and have the norm 1, from the discrete cosine transform.
fn trace(number: usize) -> Trace {
    let count = 2 * SAMPLES;
    let of =
        |row: usize| (2.0 / count as f64).sqrt() * libm::cos(PI * (row as f64 + 0.5) * number as f64 / count as f64);
    (0..count).map(of).collect()
}

fn sum(terms: &[(f64, usize)]) -> Trace {
    let traces: Vec<_> = terms.iter().map(|(size, number)| (size, trace(*number))).collect();
    (0..2 * SAMPLES).map(|row| traces.iter().map(|(size, trace)| *size * trace[row]).sum()).collect()
}

/// Residuals in units of the noise, and what a unit of each change takes from them; an estimated parameter takes the trace `FREE`.
#[derive(Clone)]
struct Straight {
    residuals: Trace,
    changes: BTreeMap<String, Trace>,
    estimated: Option<Parameter>,
    clock: f64,
    item: String,
}

impl Simulated for Straight {
    fn differences(&self, vectors: &[Vec<f64>], _: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        let none = vec![0.0; 2 * SAMPLES];
        let of = |name: &str| self.changes.get(name).unwrap_or(&none);
        let (free, clock, item) = (trace(FREE), of("time"), of(&self.item));
        let by = |x: &Vec<f64>, row: usize| {
            let more = self.estimated.as_ref().map_or(0.0, |one| (one.outer(x[1]) - one.start) * of(&one.name)[row]);
            self.residuals[row] - x[0] * free[row] - more - (self.clock - 1.0) * clock[row] - item[row]
        };
        Ok(vectors.iter().map(|x| (0..2 * SAMPLES).map(|row| by(x, row) * NOISE[row / SAMPLES]).collect()).collect())
    }
}

impl Changeable for Straight {
    fn signals(&self) -> Vec<String> {
        vec!["position".to_owned(), "velocity".to_owned()]
    }

    fn changed<'a>(&'a self, change: Change<'a>) -> Result<Box<dyn Simulated + 'a>, Interrupted> {
        let mut changed = self.clone();
        match change {
            Change::Estimated(parameter) => changed.estimated = Some(parameter.clone()),
            Change::Chosen { item, .. } => changed.item = item.to_owned(),
            Change::Clock(clock) => changed.clock = clock,
        }
        Ok(Box::new(changed))
    }
}

fn linear(name: &str, unit: &str, start: f64) -> Parameter {
    let any = [f64::NEG_INFINITY, f64::INFINITY];
    let (name, unit) = (name.to_owned(), unit.to_owned());
    Parameter { name, unit, start, bounds: any, scale: 1.0, is_given: false, is_bounded: false, legal: any }
}

fn sensor(name: &str) -> Parameter {
    let (kind, signal) = name.split_once('.').expect("a kind and a signal");
    Parameter::of_sensor(kind, signal, "N").expect("a property of a sensor")
}

/// Causes of residuals among all candidates that have a trace; a setting is one whose name has no dot.
fn asked(residuals: Trace, changes: &[(&str, Trace)], is_noise: bool) -> Vec<Cause> {
    let changes: BTreeMap<String, Trace> =
        changes.iter().map(|(name, trace)| ((*name).to_owned(), trace.clone())).collect();
    let straight = Straight { residuals, changes, estimated: None, clock: 1.0, item: String::new() };
    let names = || straight.changes.keys().filter(|name| !["time", "Other"].contains(&name.as_str()));
    let [name, fixed, other] = ["thermal.model", "Usual", "Other"].map(str::to_owned);
    let choice = Choice { name, fixed, others: vec![other] };
    let candidates = Candidates {
        settings: names().filter(|name| !name.contains('.')).map(|name| linear(name, "kg", 2.0)).collect(),
        sensors: names().filter(|name| name.contains('.')).map(|name| sensor(name)).collect(),
        choices: if straight.changes.contains_key("Other") { vec![choice] } else { vec![] },
        has_clock: straight.changes.contains_key("time"),
    };
    let problem = Problem {
        parameters: vec![linear("free", "1", 0.0)],
        segments: vec![Segment { samples: SAMPLES, begins: 0, record: 0 }],
        sensors: NOISE.map(|noise| Sensor { noise, step: 0.0, is_coarse: false }).to_vec(),
        simulated: &straight,
        step: STEP,
    };
    causes(&straight, &candidates, &problem, &[0.0], is_noise).expect("nobody interrupts")
}

fn assert_close(value: f64, right: f64) {
    assert!((value - right).abs() < 1e-6 * right.abs(), "{value}, not {right}");
}

/// A part of a fault that the estimated parameter explains as well does not count.
#[test]
fn an_offset_is_found_with_its_size_and_what_it_explains() {
    let effect = sum(&[(1.0, OFFSET), (4.0, FREE)]);
    let residuals = sum(&[(3.0, OFFSET), (12.0, FREE), (1.0, OTHER)]);
    let found = asked(residuals, &[("offset.force", effect), ("delay.force", trace(DELAY))], false);
    let [cause] = &found[..] else { panic!("{found:?}") };
    assert!(cause.is_sensor && cause.name == "offset.force", "{cause:?}");
    let (value, [low, high]) = cause.estimate.expect("a value");
    assert_close(value, 3.0);
    assert!(low < 3.0 && 3.0 < high && high - low < 3.0, "{cause:?}");
    assert_close(cause.gain, 9.0 + 144.0);
    assert!(
        cause.text.contains("would be gone if 3 [") && cause.text.contains("N of force were an offset"),
        "{cause:?}"
    );
    assert!(cause.text.ends_with("estimate offset.force") && cause.share > 0.9, "{cause:?}");
}

/// A delay may be either way; the lag of a filter is none below 0.
#[test]
fn a_delay_is_found_in_its_direction() {
    for size in [0.3, -0.3] {
        let residuals = || sum(&[(50.0 * size, DELAY), (1.0, OTHER)]);
        let effect = || sum(&[(100.0, DELAY)]);
        let late = asked(residuals(), &[("delay.velocity", effect())], false);
        assert_close(late[0].estimate.expect("a value").0, 0.5 * size);
        let lag = asked(residuals(), &[("lag.position", effect())], false);
        assert_eq!(lag.is_empty(), size < 0.0, "{lag:?}");
    }
}

#[test]
fn nothing_is_named_without_a_reason() {
    let offset = || ("offset.force", trace(OFFSET));
    // The fault has no effect of its own, or explains too little, or nothing is left.
    let same = ("gain.force", trace(FREE));
    assert_eq!(asked(sum(&[(3.0, FREE), (1.0, OTHER)]), &[same, offset()], false), []);
    assert_eq!(asked(sum(&[(1.0, OFFSET), (10.0, OTHER)]), &[offset()], false), []);
    assert_eq!(asked(vec![0.0; 2 * SAMPLES], &[offset()], false), []);
    // Noise of more than half of the squares leaves nothing else above half.
    assert!(is_quiet([(1.0, 0.71), (0.0, 1.0)]) && !is_quiet([(0.0, 1.0), (1.0, 0.7)]));
    assert_eq!(asked(sum(&[(3.0, OFFSET), (1.0, OTHER)]), &[offset()], true), []);
}

/// One sample explains it all: without its stretch of time the interval has the fixed value in it.
#[test]
fn a_cause_whose_interval_holds_the_fixed_value_is_none() {
    let mut peak = vec![0.0; 2 * SAMPLES];
    peak[5] = 1.0;
    let with = |size: f64, other: &[(f64, usize)]| -> Trace {
        sum(other).iter().zip(&peak).map(|(rest, peak)| size * peak + rest).collect()
    };
    for name in ["mass", "offset.force"] {
        let effect = with(1.0, &[(0.1, OFFSET)]);
        assert_eq!(asked(with(6.0, &[(1.0, OTHER)]), &[(name, effect)], false), [], "{name}");
    }
}

/// The same change of the simulation as a setting, as another one and as a sensor: settings come first, and both are named.
#[test]
fn settings_come_before_sensors_and_name_those_that_explain_as_much() {
    let residuals = sum(&[(6.0, OFFSET), (1.0, OTHER)]);
    let changes = [("mass", trace(OFFSET)), ("area", sum(&[(-2.0, OFFSET)])), ("offset.force", trace(OFFSET))];
    let found = asked(residuals.clone(), &changes, false);
    let [setting, fault] = &found[..] else { panic!("{found:?}") };
    assert!(!setting.is_sensor && fault.is_sensor, "{found:?}");
    let both = [setting.name.as_str(), setting.alike[0].as_str()];
    assert!(both == ["mass", "area"] || both == ["area", "mass"], "{setting:?}");
    assert_close(setting.estimate.expect("a value").0, if setting.name == "mass" { 8.0 } else { -1.0 });
    assert!(setting.text.ends_with(&format!("as much would be gone with another {}", both[1])), "{setting:?}");
    // A sensor that explains more comes before a setting.
    let half = ("mass", sum(&[(1.0, OFFSET), (0.5, OTHER)]));
    let found = asked(sum(&[(6.0, OFFSET), (-1.0, OTHER)]), &[half, ("offset.force", trace(OFFSET))], false);
    assert_eq!([found[0].is_sensor, found[1].is_sensor], [true, false], "{found:?}");
}

#[test]
fn a_model_and_a_clock_are_found() {
    let residuals = || sum(&[(6.0, OFFSET), (0.1, OTHER)]);
    let [model] = &asked(residuals(), &[("Other", sum(&[(6.0, OFFSET)]))], false)[..] else { panic!("a cause") };
    assert!(model.name == "thermal.model" && model.item.as_deref() == Some("Other"), "{model:?}");
    assert!(model.text.contains("thermal.model were Other in place of Usual"), "{model:?}");
    // 2 % fast; if noise is most of what is left, a clock is named that is off by much more than its interval.
    let effect = || ("time", sum(&[(-300.0, OFFSET)]));
    for is_noise in [false, true] {
        let [clock] = &asked(residuals(), &[effect()], is_noise)[..] else { panic!("a cause") };
        assert!(clock.name == "time" && clock.text.contains("check the clock"), "{clock:?}");
        assert_close(clock.estimate.expect("a value").0, 0.98);
    }
    let unsure = || sum(&[(6.0, OFFSET), (5.0, OTHER)]);
    assert_eq!(asked(unsure(), &[effect()], true), []);
    assert_eq!(asked(unsure(), &[effect()], false)[0].name, "time");
}
