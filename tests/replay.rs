//! Replays of runs: their values are those of the run bit for bit, their slopes those of differences of runs.
#![cfg(feature = "sensitivities")]

use std::collections::HashMap;

use pneumatic_servo::friction::Friction;
use pneumatic_servo::models::pneumatic_servo_cylinder::{MODEL, PneumaticServoCylinder};
use pneumatic_servo::numbers::Varied;
use pneumatic_servo::pneumatics::actuator::Actuator;
use pneumatic_servo::replay::Replay;
use pneumatic_servo::session::{Start, build};
use pneumatic_servo::solver::{Mark, Method, Run};
use pneumatic_servo::system::System;

type Cylinder = PneumaticServoCylinder<Friction, Actuator>;

/// The eight directions: parameters, that of an input last.
const STRIBECK: [&str; 7] = [
    "friction.stribeck.Fs",
    "friction.stribeck.Fc",
    "friction.stribeck.vs",
    "friction.stribeck.sigma2",
    "valve.C",
    "valve.hysteresis",
    "wireForce",
];
const LUGRE: [&str; 7] = [
    "friction.lugre.Fs",
    "friction.lugre.Fc",
    "friction.lugre.vs",
    "friction.lugre.sigma1",
    "valve.C",
    "valve.hysteresis",
    "wireForce",
];

fn voltage(course: &str, step: u32) -> f64 {
    let t = f64::from(step) * 1e-3;
    match course {
        "down" => 3.0,
        "slow" => 5.0 + 1.0 * (std::f64::consts::TAU * 2.0 * t).sin(),
        _ => 5.0 + 2.0 * (std::f64::consts::TAU * t).sin(),
    }
}

struct Case {
    law: f64,
    names: [&'static str; 7],
    tolerance: Option<f64>,
    course: String,
}

impl Case {
    fn parameters(&self, offsets: &HashMap<&str, f64>) -> Vec<f64> {
        let table = (MODEL.variables)();
        table
            .parameters()
            .map(|variable| {
                let name = variable.name.as_str();
                let start = if name == "friction.law" { self.law } else { variable.start.expect("a start") };
                start + offsets.get(name).copied().unwrap_or(0.0)
            })
            .collect()
    }

    fn run<const N: usize>(&self, steps: u32, offsets: &HashMap<&str, f64>, added: f64) -> ([f64; N], [u64; 4]) {
        let parameters = self.parameters(offsets);
        let first = [voltage(&self.course, 0) + added, 0.0, 6e5];
        let start = Start { time: 0.0, parameters: &parameters, inputs: &first, tolerance: self.tolerance };
        let (equations, settings) = build::<Cylinder, 3>(&start, &[]).expect("legal");
        let (x, memory) = equations.start::<N>(&first);
        let mut run = Run::new(equations, settings, 0.0, x, memory, first);
        for step in 0..steps {
            run.set_inputs([voltage(&self.course, step) + added, 0.0, 6e5], [0.0; 3]);
            run.advance(f64::from(step + 1) * 1e-3).expect("goes on");
        }
        let counters = run.counters();
        (*run.state().0, [counters.steps, counters.rejected, counters.events, counters.jacobians])
    }

    fn replay<const N: usize, const K: usize>(&self, steps: u32, replays: bool) -> Replay<Cylinder, N, 3, K> {
        let parameters = self.parameters(&HashMap::new());
        let places: HashMap<&str, usize> =
            (MODEL.variables)().parameters().enumerate().map(|(place, it)| (it.name.as_str(), place)).collect();
        let mut slopes = vec![0.0; K.min(7) * parameters.len()];
        for (way, name) in self.names.iter().take(K).enumerate() {
            slopes[way * parameters.len() + places[name]] = 1.0;
        }
        let first = [voltage(&self.course, 0), 0.0, 6e5];
        let start = Start { time: 0.0, parameters: &parameters, inputs: &first, tolerance: self.tolerance };
        let (equations, settings) = build::<Cylinder, 3>(&start, &[]).expect("legal");
        let (varied, _) = build::<Cylinder, 3>(&start, &slopes).expect("legal");
        let (x, memory) = equations.start::<N>(&first);
        let mut run = Run::new(equations, settings, 0.0, x, memory.clone(), first);
        run.leave_trail(true);
        let input = |value: f64, varies: bool| {
            let mut slope = [0.0; K];
            if K == 8 && varies {
                slope[7] = 1.0;
            }
            Varied::new(value, slope)
        };
        let inputs = |voltage: f64| [input(voltage, true), input(0.0, false), input(6e5, false)];
        let mut replay =
            Replay::new(varied, 0.0, x.map(|value| Varied::new(value, [0.0; K])), inputs(first[0]), memory);
        let (mut methods, mut lost) = ([0; 3], None);
        for step in 0..steps {
            let voltage = voltage(&self.course, step);
            run.set_inputs([voltage, 0.0, 6e5], [0.0; 3]);
            run.advance(f64::from(step + 1) * 1e-3).expect("goes on");
            let marks = run.take_trail();
            for mark in &marks {
                if let Mark::Moves { how, .. } = mark {
                    methods[match how.method {
                        Method::Classical => 0,
                        Method::Midpoint => 1,
                        Method::Other => 2,
                    }] += 1;
                }
            }
            if replays && lost.is_none() {
                replay.set_inputs(inputs(voltage), true);
                if let Err(end) = replay.follow(&marks) {
                    lost = Some((end, run.time()));
                }
            }
        }
        assert_eq!((lost, replay.other_bits), (None, 0));
        assert!(replay.steps == methods.iter().sum::<usize>() && replay.steps > 0);
        replay
    }
}

fn case(law: f64, course: &str) -> Case {
    let names = if law == 14.0 { LUGRE } else { STRIBECK };
    Case { law, names, tolerance: Some(1e-11), course: course.to_owned() }
}

/// Slopes of position and velocity in all eight directions against central differences.
fn agrees<const N: usize>(case: &Case) {
    let (steps, share) = (200, 1e-4);
    let replay = case.replay::<N, 8>(steps, true);
    for way in 0..8 {
        let ends = [share, -share].map(|share| match case.names.get(way) {
            Some(name) => {
                let start = (MODEL.variables)().parameters().find(|it| it.name == *name).and_then(|it| it.start);
                let offset = share * start.filter(|start| *start != 0.0).unwrap_or(1.0).abs();
                (case.run::<N>(steps, &HashMap::from([(*name, offset)]), 0.0).0, offset)
            }
            None => (case.run::<N>(steps, &HashMap::new(), 0.1 * share).0, 0.1 * share),
        });
        for state in [N - 2, N - 1] {
            let difference = (ends[0].0[state] - ends[1].0[state]) / (ends[0].1 - ends[1].1);
            let slope = replay.x[state].0.slope[way];
            assert!(
                (slope / difference - 1.0).abs() < 1e-4,
                "state {state}, direction {way}: {slope}, not {difference}"
            );
        }
    }
}

#[test]
fn slopes_under_stribeck_are_those_of_differences_through_events() {
    agrees::<8>(&case(7.0, ""));
}

#[test]
fn slopes_under_lugre_are_those_of_differences() {
    agrees::<9>(&case(14.0, ""));
}

/// The set point that is dragged downwards moves by the half width of the play, not by half of it.
#[test]
fn spool_that_is_dragged_downwards_moves_with_the_play() {
    for (course, slope) in [("down", 1.0), ("", -1.0)] {
        let replay = case(7.0, course).replay::<8, 8>(100, true);
        assert!((replay.x[1].0.slope[5] - slope).abs() < 1e-9, "{course}: {}", replay.x[1].0.slope[5]);
    }
}
