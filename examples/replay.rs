//! What a replay costs, and how it agrees with differences: `replay LAW WHAT [MILLISECONDS]`.

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
        eprintln!(
            "classical, midpoint, other: {methods:?}; lost {lost:?}; {} steps, {} other bits",
            replay.steps, replay.other_bits
        );
        replay
    }
}

fn all<const N: usize>(case: &Case, what: &str, steps: u32) {
    match what {
        "run" => {
            let (x, counters) = case.run::<N>(steps, &HashMap::new(), 0.0);
            println!("{counters:?} {x:?}");
        }
        "log" => drop(case.replay::<N, 1>(steps, false)),
        "one" => println!("{:?}", case.replay::<N, 1>(steps, true).x.map(|it| it.0.slope[0])),
        "eight" => println!("{:?}", case.replay::<N, 8>(steps, true).x[N - 1]),
        _ => {
            let replay = case.replay::<N, 8>(steps, true);
            for way in 0..8 {
                let start = |name: &str| {
                    (MODEL.variables)().parameters().find(|it| it.name == name).and_then(|it| it.start).unwrap_or(0.0)
                };
                let by = |share: f64| match case.names.get(way) {
                    Some(name) => {
                        let magnitude = if *name == "wireForce" { 1.0 } else { start(name).abs() };
                        let offset = share * step_share() * magnitude;
                        (case.run::<N>(steps, &HashMap::from([(*name, offset)]), 0.0).0, offset)
                    }
                    None => (
                        case.run::<N>(steps, &HashMap::new(), share * 0.1 * step_share()).0,
                        share * 0.1 * step_share(),
                    ),
                };
                let ((above, up), (below, down)) = (by(1.0), by(-1.0));
                let name = case.names.get(way).copied().unwrap_or("valveVoltage");
                for (label, i) in [("position", N - 2), ("velocity", N - 1), ("spool", 1), ("pressureA", N - 4)] {
                    let difference = (above[i] - below[i]) / (up - down);
                    let slope = replay.x[i].0.slope[way];
                    println!(
                        "{name:24} x[{i}] {label:10} {slope:+.8e} {difference:+.8e} {:+.1e}",
                        slope / difference - 1.0
                    );
                }
            }
        }
    }
}

/// Offsets of differences as a share of a parameter.
fn step_share() -> f64 {
    std::env::var("OFFSET").ok().and_then(|it| it.parse().ok()).unwrap_or(1e-4)
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let (law, what) = (arguments[1].as_str(), arguments[2].as_str());
    let steps = arguments.get(3).map_or(1000, |steps| steps.parse().expect("a number"));
    let course = arguments.get(4).cloned().unwrap_or_default();
    let number = |name: &str, usual: f64| std::env::var(name).ok().and_then(|it| it.parse().ok()).unwrap_or(usual);
    let tolerance = (what == "compare").then_some(number("TOLERANCE", 1e-11));
    match law {
        "LuGre" => all::<9>(&Case { law: 14.0, names: LUGRE, tolerance, course }, what, steps),
        _ => all::<8>(&Case { law: 7.0, names: STRIBECK, tolerance, course }, what, steps),
    }
}
