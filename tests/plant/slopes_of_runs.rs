//! Runs in numbers with slopes: values have the bits of plain runs, slopes agree with differences of runs.

use pneumatic_servo::friction::{Friction, LAWS};
use pneumatic_servo::models::pneumatic_servo_cylinder::{MODEL, PneumaticServoCylinder};
use pneumatic_servo::numbers::{Real, STILL, Scalar, Tangent, Varying};
use pneumatic_servo::pneumatics::actuator::Actuator;
use pneumatic_servo::session::{Seeds, Start, build};
use pneumatic_servo::solver::Run;
use pneumatic_servo::system::System;

type Cylinder = PneumaticServoCylinder<Friction, Actuator>;

/// Enough for every law.
const N: usize = 18;

/// A cylinder under a law, driven by 5 V and a sine, along a direction: a parameter, or the voltage.
#[derive(Clone, Copy)]
struct Case<'a> {
    law: i32,
    along: &'a str,
    tolerance: f64,
    amplitude: f64,
}

impl Case<'_> {
    /// The states after some milliseconds, with an offset in the direction, in numbers `S` with a slope of 1 in it.
    fn run<S: Varying>(&self, steps: u32, offset: f64) -> Run<Cylinder, N, 3, S> {
        let table = MODEL.table();
        let start =
            |name: &str, start: Option<f64>| if name == "friction.law" { f64::from(self.law) } else { start.unwrap() };
        let mut parameters: Vec<f64> = table.parameters().map(|it| start(&it.name, it.start)).collect();
        let unit = Tangent::varying(0.0, 1.0).slopes;
        let mut slopes = vec![STILL; parameters.len()];
        let place = table.parameters().position(|it| it.name == self.along);
        if let Some(place) = place {
            parameters[place] += offset;
            slopes[place] = unit;
        }
        let added = if place.is_none() { offset } else { 0.0 };
        let inputs = |step: u32| {
            let time = 1e-3 * f64::from(step);
            let voltage = 5.0 + self.amplitude * (std::f64::consts::TAU * 2.0 * time).sin() + added;
            [S::with(voltage, if place.is_none() { unit } else { STILL }), S::of(0.0), S::of(6e5)]
        };
        let first = inputs(0);
        let plain = first.map(S::value);
        let seeds = Seeds { parameters: if S::VARIES { &slopes[..] } else { &[] }, ..Seeds::NONE };
        let tolerance = Some(self.tolerance);
        let start = Start { time: 0.0, parameters: &parameters, inputs: &plain, tolerance, seeds };
        let (equations, settings) = build::<Cylinder, 3>(&start).expect("legal");
        let (x, memory) = equations.start::<S, N>(&first);
        let mut run = Run::new(equations, settings, 0.0, x, memory, first);
        for step in 0..steps {
            run.set_inputs(inputs(step), [0.0; 3]);
            run.advance(1e-3 * f64::from(step + 1)).expect("goes on");
        }
        run
    }

    /// The largest distance between slopes and central differences, relative to the largest of the differences of a state.
    fn distance(&self, steps: u32, size: f64) -> f64 {
        let varied = self.run::<Tangent>(steps, 0.0);
        let plain = self.run::<Real>(steps, 0.0);
        let bits = |x: [f64; N]| x.map(f64::to_bits);
        assert_eq!(
            bits(varied.state().0.map(Tangent::value)),
            bits(plain.state().0.map(Real::value)),
            "law {}",
            self.law
        );
        if varied.lost(0).is_some() {
            return f64::NAN;
        }
        let [above, below] = [size, -size].map(|offset| self.run::<Real>(steps, offset).state().0.map(Real::value));
        let of = |state: usize| {
            let difference = (above[state] - below[state]) / (2.0 * size);
            (varied.state().0[state].slopes[0] - difference).abs() / difference.abs().max(1e-300)
        };
        of(N - 2).max(of(N - 1))
    }
}

/// Of the directions that a run of the cylinder has: the valve's command, the load, the flow, the mass and the spool. Under law DNLRX the carriage rattles
/// with its samples, so that small changes grow beyond every difference. Central differences of runs at this tolerance hold five
/// digits; implicit steps do not end on kinks, which costs one of them. A law with a steep line through rest has slopes that bend
/// within micronewtons, and the bonds of Bristle break one by one.
#[test]
fn slopes_under_all_laws_are_those_of_differences() {
    for (law, name, ..) in LAWS.items.iter().filter(|(_, name, ..)| *name != "DNLRX") {
        for (along, size) in [
            ("voltage", 1e-6),
            ("wireForce", 1e-4),
            ("valve.C", 1e-13),
            ("mass.moving", 1e-6),
            ("valve.bandwidth", 0.2),
        ] {
            let bound = match *name {
                "Bristle" => 1e-2,
                "StepRegularised" | "SineRegularised" => 1e-3,
                _ => 4e-5,
            };
            let distance = Case { law: *law, along, tolerance: 1e-11, amplitude: 2.0 }.distance(200, size);
            assert!(distance < bound, "{name} by {along}: {distance:e}");
        }
    }
}
