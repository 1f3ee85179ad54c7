//! Sensitivities of the position controller, and of the loop that it closes around the cylinder.

use std::collections::HashMap;

use pneumatic_servo::model::{Model, Plant, Setup, Value};
use pneumatic_servo::models::{pneumatic_servo_cylinder, position_controller};
use pneumatic_servo::sensitivity::Transition;

const PERIOD: f64 = 1e-3;

fn start(model: &'static Model, changes: &[(&str, Value)]) -> Plant {
    let mut setup = Setup::new(model);
    changes.iter().for_each(|(name, value)| setup.change(name, *value).expect("legal"));
    setup.start(0.0).expect("starts")
}

fn controller(changes: &[(&str, Value)]) -> Plant {
    start(&position_controller::MODEL, changes)
}

fn sensitivity(plant: &mut Plant, direction: usize, output: &str) -> Result<f64, String> {
    let place = plant.table().computed().position(|variable| variable.name == output).expect("a computed variable");
    plant.sensitivities(direction).map(|slopes| slopes[place]).map_err(|error| error.to_string())
}

/// Slopes by their names, for each direction.
type Slopes = HashMap<String, Vec<f64>>;

/// Goes on over a step: `rows*x + by_inputs*u + by_parameters*p`, with slopes of inputs for each direction.
fn times(
    rows: [&[Vec<f64>]; 3],
    transition: &Transition,
    slopes: &Slopes,
    inputs: &[Vec<f64>],
    parameters: usize,
) -> Vec<Vec<f64>> {
    let directions = inputs[0].len();
    let row = |row: usize| {
        let mut sums = vec![0.0; directions];
        for (name, factor) in transition.states.iter().zip(&rows[0][row]) {
            let Some(own) = slopes.get(name) else { continue };
            sums.iter_mut().zip(own).for_each(|(sum, slope)| *sum += factor * slope);
        }
        for (factor, own) in rows[1][row].iter().zip(inputs) {
            sums.iter_mut()
                .zip(own)
                .filter(|(_, slope)| **slope != 0.0)
                .for_each(|(sum, slope)| *sum += factor * slope);
        }
        (0..parameters).for_each(|place| sums[place] += rows[2][row][place]);
        sums
    };
    (0..rows[0].len()).map(row).collect()
}

/// Propagation of derivatives of the states by a step, and the derivatives of the outputs at its end.
fn go_on(transition: &Transition, slopes: &mut Slopes, inputs: &[Vec<f64>], parameters: usize) -> Vec<Vec<f64>> {
    let Transition { a, b, c, d, p, q, next_states, .. } = transition;
    let outputs = times([c, d, q], transition, slopes, inputs, parameters);
    let next = times([a, b, p], transition, slopes, inputs, parameters);
    *slopes = next_states.iter().cloned().zip(next).collect();
    outputs
}

/// The parts of a drive whose carriage rests 50 mm before its reference.
fn drive(changes: &[(&str, f64)]) -> [Plant; 2] {
    // With a play, a voltage that rests has no derivative.
    let of_plant = [("valve.hysteresis", 0.0.into()), ("solver.relativeTolerance", 1e-10.into())];
    let of_controller: Vec<(&str, Value)> =
        changes.iter().filter(|(name, _)| *name != REFERENCE).map(|(name, value)| (*name, (*value).into())).collect();
    [start(&pneumatic_servo_cylinder::MODEL, &of_plant), controller(&of_controller)]
}

const REFERENCE: &str = "referencePosition";
/// Errors of positions in m that runs at a tolerance of 1e-10 do not have in common.
const NOISE: f64 = 1e-11;
const STEPS: u32 = 400;

/// Hands on what each part of a drive needs of the other.
fn couple([plant, controller]: &mut [Plant; 2], reference: f64) {
    let mut hand = |from: &str, to: &str| {
        let value = plant.get(from).expect("an output");
        controller.set(to, value).expect("legal");
    };
    hand("position", "position");
    hand("velocity", "velocity");
    controller.set(REFERENCE, reference).expect("legal");
    let voltage = controller.get("valveVoltage").expect("an output");
    plant.set("valveVoltage", voltage).expect("legal");
}

/// Positions of the step response.
fn response(changes: &[(&str, f64)]) -> Vec<f64> {
    let mut drive = drive(changes);
    let reference = changes.iter().find(|(name, _)| *name == REFERENCE).map_or(0.3, |(_, value)| *value);
    let step = |index: u32| {
        couple(&mut drive, reference);
        drive.iter_mut().for_each(|part| part.advance_to(f64::from(index + 1) * PERIOD).expect("advances"));
        drive[0].get("position").expect("an output")
    };
    (0..STEPS).map(step).collect()
}

/// The drive goes 50 mm: by its gains, its limits, the valve as it knows it, and the height of the step, the position has the
/// slopes that the chain of transitions of both parts gives.
///
/// Differences have five digits, as for the cylinder alone, but for the noise of runs where a position hardly changes.
#[test]
fn step_response_has_the_slopes_of_differences() {
    // With the shares by which runs differ: more of them bends too much, less drowns in rounding.
    let gains = [
        ("gain.position", 12.0, 3e-5),
        ("gain.velocity", 8.0, 3e-5),
        ("gain.integral", 10.0, 3e-4),
        ("feedForward.gain", 1.6, 3e-5),
        ("limit.velocity", 0.2, 3e-5),
        ("valve.neutral", 5.0, 3e-6),
        ("valve.deadZone", 0.08, 3e-5),
        ("valve.transition", 0.1, 3e-4),
    ];
    let names = gains.map(|(name, ..)| name);
    let (count, directions) = (gains.len(), gains.len() + 1);
    let settings = gains.map(|(name, value, _)| (name, value));
    let mut drive = drive(&settings);
    drive[1].carry_sensitivities(&names).expect("parameters");
    let voltage_at_start = (0..count).map(|place| sensitivity(&mut drive[1], place, "valveVoltage").expect("a slope"));
    let mut voltage: Vec<f64> = voltage_at_start.chain([0.0]).collect();
    drive[1].carry_sensitivities(&[]).expect("none");
    let (mut of_plant, mut of_controller) = (Slopes::new(), Slopes::new());
    let (mut motion, mut found) = (vec![vec![0.0; directions]; 2], Vec::new());
    let still = vec![0.0; directions];
    let reference: Vec<f64> = (0..directions).map(|direction| f64::from(u8::from(direction == count))).collect();
    for index in 0..STEPS {
        couple(&mut drive, 0.3);
        let [time, end] = [index, index + 1].map(|index| f64::from(index) * PERIOD);
        let step = drive[0].transition(end - time, &[], &["position", "velocity"]).expect("a step");
        let sample = drive[1].transition(end - time, &names, &["valveVoltage"]).expect("a step");
        assert!(sample.lost.is_empty(), "{:?}", sample.lost);
        let inputs: Vec<&str> = drive[0].table().inputs().map(|input| input.name.as_str()).collect();
        let of_inputs: Vec<Vec<f64>> =
            inputs.iter().map(|name| if *name == "valveVoltage" { voltage.clone() } else { still.clone() }).collect();
        let moved = go_on(&step, &mut of_plant, &of_inputs, 0);
        let seen = [reference.clone(), still.clone(), motion[0].clone(), motion[1].clone()];
        voltage = go_on(&sample, &mut of_controller, &seen, count).remove(0);
        motion = moved;
        found.push(motion[0].clone());
    }
    for (place, (name, value, share)) in gains.into_iter().chain([(REFERENCE, 0.3, 3e-6)]).enumerate() {
        let [above, below] = [1.0, -1.0].map(|sign| {
            let moved = [(name, value * (1.0 + sign * share))];
            response(
                &[&moved[..], &settings.into_iter().filter(|(other, _)| *other != name).collect::<Vec<_>>()].concat(),
            )
        });
        let distance = 2.0 * share * value;
        let differences: Vec<f64> = above.iter().zip(below).map(|(above, below)| (above - below) / distance).collect();
        let largest = differences.iter().fold(0.0f64, |largest, slope| largest.max(slope.abs()));
        let worst =
            differences.iter().zip(&found).fold(0.0f64, |worst, (one, other)| worst.max((one - other[place]).abs()));
        assert!(worst < 1e-5 * largest + NOISE / distance, "{name}: {worst} of {largest}");
    }
}

/// `V = V0 + kf*w + kv*(w - v)` with `w = kx*(r - x)`, where nothing else is switched on.
#[test]
fn one_sample_has_the_slopes_of_its_formula() {
    let changes: [(&str, Value); 6] = [
        ("gain.integral", 0.0.into()),
        ("valve.deadZone", 0.0.into()),
        ("feedForward.source", "Input".into()),
        ("gain.position", 10.0.into()),
        ("gain.velocity", 8.0.into()),
        ("feedForward.gain", 1.6.into()),
    ];
    let mut controller = controller(&changes);
    let directions =
        ["gain.position", "gain.velocity", "feedForward.gain", "valve.neutral", "referencePosition", "velocity"];
    controller.carry_sensitivities(&directions).expect("directions");
    for (name, value) in [("referencePosition", 0.26), ("position", 0.25), ("velocity", 0.02)] {
        controller.set(name, value).expect("legal");
    }
    controller.advance_to(0.5 * PERIOD).expect("a sample");
    let expected = [0.01 * 9.6, 0.1 - 0.02, 0.1, 1.0, 10.0 * 9.6, -8.0];
    for (direction, expected) in expected.into_iter().enumerate() {
        let found = sensitivity(&mut controller, direction, "valveVoltage").expect("a slope");
        // Rounding of a few operations.
        assert!((found - expected).abs() < 1e-14 * expected.abs(), "{}: {found}", directions[direction]);
    }
}

/// A sample that finds a number just at its limit has no derivative by what moves that, and neither has what follows. Behind the
/// limit there is one.
#[test]
fn sample_just_at_a_limit_is_told() {
    // No integral part, no dead zone, no velocity: V = V0 + 9.6*w.
    let bare: [(&str, Value); 3] =
        [("gain.integral", 0.0.into()), ("valve.deadZone", 0.0.into()), ("feedForward.source", "Input".into())];
    let at = |limit: (&'static str, f64), velocity: f64| {
        let mut controller = controller(&[&bare[..], &[(limit.0, limit.1.into())]].concat());
        controller.carry_sensitivities(&["referenceVelocity", "valve.neutral"]).expect("directions");
        for (index, velocity) in [velocity, 0.01].into_iter().enumerate() {
            controller.set("referenceVelocity", velocity).expect("legal");
            controller.advance_to((index as f64 + 0.5) * PERIOD).expect("a sample");
            if index == 0 {
                assert_eq!(sensitivity(&mut controller, 1, "valveVoltage"), Ok(1.0), "it does not move the limit");
            }
        }
        sensitivity(&mut controller, 0, "valveVoltage")
    };
    for (limit, velocity, what) in [
        (("limit.velocity", 0.5), 0.5, "the wanted velocity just at its limit"),
        (("limit.velocity", 0.5), -0.5, "the wanted velocity just at its limit"),
        // 9.6 times a quarter, without rounding.
        (("valve.range", 2.4), 0.25, "the voltage just at an end of its range"),
    ] {
        let told = at(limit, velocity).expect_err("no slope");
        let expected = format!("the run has no derivative from t = 0 s on, at a sample: it finds {what}");
        assert_eq!(told, expected);
        for other in [0.9 * velocity, 1.1 * velocity] {
            assert!((at(limit, other).expect("a slope") - 9.6).abs() < 1e-12, "at {other} m/s");
        }
    }
}

/// Without a transition the voltage jumps across the dead zone, and the command begins there; with one it is on a line.
#[test]
fn command_in_the_dead_zone_has_a_slope_on_a_line_alone() {
    for (transition, expected) in [(0.1, Some(9.6 * (0.92 + 0.08 * 5.0 / 0.1))), (0.0, None)] {
        let mut controller =
            controller(&[("valve.transition", transition.into()), ("feedForward.source", "Input".into())]);
        controller.carry_sensitivities(&["referenceVelocity"]).expect("an input");
        controller.advance_to(0.5 * PERIOD).expect("a sample");
        let found = sensitivity(&mut controller, 0, "valveVoltage");
        match expected {
            // Rounding of a few operations.
            Some(expected) => {
                let found = found.expect("a slope");
                assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
            }
            None => assert!(found.expect_err("no slope").ends_with("just at an end of the line across the dead zone")),
        }
    }
}

/// Beyond the range the integral part is held unless the velocity is too large; at none too large it may be either.
#[test]
fn integral_part_that_is_just_held_is_told() {
    // More than the range even without an error of the velocity.
    let changes = [("feedForward.gain", 100.0.into()), ("feedForward.source", "Input".into())];
    let mut controller = controller(&changes);
    controller.carry_sensitivities(&["velocity", "feedForward.gain"]).expect("directions");
    controller.set("referenceVelocity", 0.5).expect("legal");
    controller.set("velocity", 0.5).expect("legal");
    controller.advance_to(0.5 * PERIOD).expect("a sample");
    let told = sensitivity(&mut controller, 0, "integral").expect_err("no slope");
    assert!(told.ends_with("it finds no lack of velocity, with the voltage beyond its range"), "{told}");
    assert_eq!(sensitivity(&mut controller, 1, "valveVoltage"), Ok(0.0), "the voltage stays at the end of its range");
}

/// The integral part comes to its limit at the third sample, just so.
#[test]
fn integral_part_just_at_its_limit_is_told() {
    let step = 0.25 * 10.0 * PERIOD;
    let changes = [("limit.integral", (step + step + step).into()), ("feedForward.source", "Input".into())];
    let mut controller = controller(&changes);
    controller.carry_sensitivities(&["referenceVelocity"]).expect("an input");
    controller.set("referenceVelocity", 0.25).expect("legal");
    controller.advance_to(1.5 * PERIOD).expect("two samples");
    let found = sensitivity(&mut controller, 0, "integral").expect("a slope");
    assert!((found - 2.0 * 10.0 * PERIOD).abs() < 1e-15, "{found}");
    controller.advance_to(2.5 * PERIOD).expect("a sample");
    let told = sensitivity(&mut controller, 0, "integral").expect_err("no slope");
    assert!(told.contains("from t = 0.002 s on, at a sample: it finds the integral part just at its limit"), "{told}");
}

/// When samples are taken is no question of little by little: they see the inputs of their communication point.
#[test]
fn sample_time_is_no_direction() {
    let told = controller(&[]).carry_sensitivities(&["sampleTime"]).expect_err("refused").to_string();
    assert!(told.starts_with("there are no sensitivities with respect to sampleTime: "), "{told}");
}

/// Values are the same bits with and without, and a host that samples between its steps gets the same slopes.
#[test]
fn run_of_many_samples_is_that_of_single_ones() {
    let run = |steps: u32, carries: bool| {
        let mut controller = controller(&[]);
        if carries {
            controller.carry_sensitivities(&["gain.integral", "position"]).expect("directions");
        }
        for (name, value) in [("referencePosition", 0.26), ("position", 0.25), ("velocity", 0.02)] {
            controller.set(name, value).expect("legal");
        }
        (1..=steps)
            .for_each(|step| controller.advance_to(f64::from(step) * 0.04 / f64::from(steps)).expect("advances"));
        let slopes = [0, 1]
            .map(|direction| carries.then(|| sensitivity(&mut controller, direction, "command").expect("a slope")));
        (controller.get("valveVoltage").expect("an output").to_bits(), slopes)
    };
    let (voltage, slopes) = run(40, true);
    assert_eq!(run(40, false).0, voltage);
    let (of_one, slopes_of_one) = run(1, true);
    assert_eq!(of_one, voltage);
    for (one, other) in slopes.into_iter().zip(slopes_of_one) {
        let [one, other] = [one, other].map(|slope| slope.expect("carried along"));
        assert!((one - other).abs() < 1e-10 * one.abs(), "{one} {other}");
    }
}
