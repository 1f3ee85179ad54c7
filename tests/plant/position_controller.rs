//! The position controller against closed forms of its control law.

use crate::bounds::{close, larger, within};
use crate::rig::{Rig, Running};
use pneumatic_servo::models::position_controller;
use pneumatic_servo::numbers::{Real, Scalar};
use pneumatic_servo::pneumatics::valve::{Opening, Spool, Valve};
use pneumatic_servo::solver::StepError;
use pneumatic_servo::variables::Tunable;

const PERIOD: f64 = 1e-3;
/// Rounding of a few operations on numbers of some volts; on lengths and velocities, a part of it.
const ROUNDING: f64 = 1e-14;

/// A controller of which every part is switched off.
fn bare() -> Rig {
    ["gain.position", "gain.velocity", "gain.integral", "feedForward.gain", "valve.deadZone", "valve.transition"]
        .into_iter()
        .fold(Rig::new("PositionController"), |rig, name| rig.set(name, 0.0))
        .choose("feedForward.source", "Input")
}

/// Takes one sample at the number of it and returns the voltage it gives.
fn voltage(controller: &mut Running, sample: u32) -> f64 {
    controller.advance(f64::from(sample + 1) * PERIOD).expect("a step");
    controller.get("valveVoltage")
}

/// The voltage that a velocity command of a size becomes.
fn voltage_of_command(rig: &Rig, command: f64) -> f64 {
    let rig = rig.clone().set("gain.velocity", 1.0).set("velocity", -command);
    voltage(&mut rig.start().expect("legal"), 0)
}

#[test]
fn voltage_is_neutral_until_the_first_sample() {
    let mut controller = Rig::new("PositionController").set("referencePosition", 0.4).start().expect("legal");
    assert_eq!(controller.get("valveVoltage"), 5.0);
    assert_eq!(controller.get("samples"), 0.0);
    assert!(voltage(&mut controller, 0) > 5.0);
    assert_eq!(controller.get("samples"), 1.0);
}

/// Samples are no events: the run that would stop at one goes on to its end, as the one that would not.
#[test]
fn run_to_the_first_event_is_a_run_to_the_end() {
    let [mut one, mut other] = [0; 2].map(|_| Rig::new("PositionController").start().expect("legal"));
    for controller in [&mut one, &mut other] {
        controller.set("referencePosition", 0.4);
    }
    one.advance(10.5 * PERIOD).expect("a step");
    assert_eq!(other.simulation().advance_to_event(10.5 * PERIOD), Ok(false));
    assert_eq!(other.simulation().time(), 10.5 * PERIOD);
    assert_eq!((one.get("samples"), other.get("samples")), (11.0, 11.0));
    assert_eq!(one.get("valveVoltage"), other.get("valveVoltage"));
}

/// On a valve and cylinder that integrate, `x' = K (V - 5)`, the error falls by `1 - Ts K k_f k_x` per sample.
#[test]
fn proportional_loop_settles_in_a_geometric_series() {
    let (gain, forward, integrator) = (20.0, 1.5, 0.5);
    let rig = bare().set("gain.position", gain).set("feedForward.gain", forward).set("position", 0.2);
    let mut controller = rig.start().expect("legal");
    let (mut position, ratio) = (0.2, 1.0 - PERIOD * integrator * forward * gain);
    for sample in 0..200u16 {
        let error = 0.05 * ratio.powi(sample.into());
        close(0.25 - position, error, 2e-4 * ROUNDING * 200.0, format_args!("sample {sample}"));
        controller.set("position", position);
        position += PERIOD * integrator * (voltage(&mut controller, sample.into()) - 5.0);
    }
}

#[test]
fn wanted_velocity_is_limited() {
    let rig = bare().set("gain.position", 10.0).set("feedForward.gain", 1.0).set("limit.velocity", 0.3);
    for (reference, wanted) in [(0.26, 0.1), (0.4, 0.3), (-0.4, -0.3)] {
        let mut controller = rig.clone().set("referencePosition", reference).start().expect("legal");
        close(voltage(&mut controller, 0) - 5.0, wanted, 0.4 * ROUNDING, "wanted velocity is limited");
        close(controller.get("wantedVelocity"), wanted, 0.4 * ROUNDING, "wanted velocity is limited");
        close(controller.get("positionError"), reference - 0.25, ROUNDING, "wanted velocity is limited");
    }
}

/// A constant velocity error adds up: `V = 5 + k_v e + n Ts k_i e` at sample `n`, up to the limit of the integral part.
#[test]
fn integral_part_grows_linearly_up_to_its_limit() {
    let rig = bare().set("gain.velocity", 2.0).set("gain.integral", 50.0).set("limit.integral", 0.4);
    let mut controller = rig.set("velocity", -0.1).start().expect("legal");
    for sample in 0..120u32 {
        let integral = (f64::from(sample) * PERIOD * 50.0 * 0.1).min(0.4);
        let expected = 5.0 + 2.0 * 0.1 + integral;
        close(voltage(&mut controller, sample), expected, 5.0 * ROUNDING, format_args!("sample {sample}"));
    }
}

/// While the voltage is at its end the integral part waits, so the first error of the other sign counts in full.
#[test]
fn integral_part_does_not_wind_up() {
    let rig = bare().set("gain.velocity", 10.0).set("gain.integral", 100.0);
    let mut controller = rig.set("velocity", -2.0).start().expect("legal");
    for sample in 0..1000 {
        assert_eq!(voltage(&mut controller, sample), 10.0);
        assert_eq!((controller.get("saturated"), controller.get("integral")), (1.0, 0.0));
    }
    controller.set("velocity", 0.1);
    close(voltage(&mut controller, 1000), 4.0, ROUNDING, "integral part does not wind up");
    assert_eq!(controller.get("saturated"), 0.0);
}

/// A charged integral part that holds the voltage at its end is discharged at once when the error turns.
#[test]
fn integral_part_leaves_the_limit() {
    let rig = bare().set("gain.velocity", 1.0).set("gain.integral", 1000.0).set("limit.integral", 100.0);
    let mut controller = rig.set("velocity", -4.0).start().expect("legal");
    (0..10).for_each(|sample| assert!(voltage(&mut controller, sample) > 5.0));
    let charged = controller.get("integral");
    assert!(charged < 5.0 && controller.get("saturated") == 1.0, "{charged}");
    controller.set("velocity", 0.1);
    voltage(&mut controller, 10);
    close(
        controller.get("integral"),
        charged - PERIOD * 1000.0 * 0.1,
        5.0 * ROUNDING,
        "integral part leaves the limit",
    );
}

/// The inverse in front of a valve with a dead zone opens it as far as the command opens one without.
#[test]
fn dead_zone_is_inverted_exactly() {
    let still = Tunable::still;
    let spool = Spool::new(still(100.0), still(0.7));
    let valve = Valve { centre: still(5.0), spool, hysteresis: still(0.0), polarity: 1.0 };
    let conductance =
        |dead_zone: f64, spool: f64| 4e-9 * Opening::linear(Tunable::still(dead_zone)).at(Real::of(spool)).0[0].value;
    let spool_at = |voltage: f64| valve.command(Real::of(voltage)).value;
    for dead_zone in [0.0, 0.08, 0.5] {
        let rig = bare().set("valve.deadZone", dead_zone);
        for command in [-6.0, -5.0, -2.0, -0.01, 0.01, 0.5, 3.0, 5.0, 8.0] {
            let spool = spool_at(voltage_of_command(&rig, command));
            let wanted = spool_at(5.0 + command);
            for (found, wanted) in [(spool, wanted), (-spool, -wanted)] {
                close(
                    conductance(dead_zone, found),
                    conductance(0.0, wanted),
                    5e-9 * ROUNDING,
                    format_args!("{dead_zone} {command}"),
                );
            }
        }
    }
}

#[test]
fn transition_joins_both_sides_of_the_dead_zone_by_a_line() {
    let rig = bare().set("valve.deadZone", 0.1).set("valve.transition", 0.2);
    let distance = |command: f64| voltage_of_command(&rig, command) - 5.0;
    assert_eq!(distance(0.0), 0.0);
    // Half of the way through the transition, half of the dead zone of 0.5 V.
    close(distance(0.1), 0.09 + 0.25, 0.4 * ROUNDING, "transition joins both sides of the dead zone by a line");
    close(distance(0.2), 0.18 + 0.5, ROUNDING, "transition joins both sides of the dead zone by a line");
    for command in [1e-6, 0.05, 0.1999, 0.2, 1.0, 7.0] {
        within(
            (distance(command) + distance(-command)).abs(),
            0.4 * ROUNDING,
            "transition joins both sides of the dead zone by a line",
        );
    }
}

#[test]
fn polarity_mirrors_the_voltage() {
    let rig = bare().set("valve.deadZone", 0.08);
    for command in [-8.0, -0.3, 0.0, 2.0] {
        let (plus, minus) =
            (voltage_of_command(&rig, command), voltage_of_command(&rig.clone().set("valve.polarity", -1.0), command));
        close(plus - 5.0 + minus, 5.0, ROUNDING, "polarity mirrors the voltage");
    }
    let error = rig.set("valve.polarity", 0.0).start().err().expect("no polarity");
    assert_eq!(error.to_string(), "valve.polarity = 0 is refused: it must be 1 or -1");
}

/// On a ramp, differences of samples are its slope, also for several samples within one communication step.
#[test]
fn difference_of_the_reference_is_its_slope() {
    let rig = bare().choose("feedForward.source", "Difference").set("feedForward.gain", 3.0);
    let mut controller = rig.start().expect("legal");
    controller.ramp("referencePosition", 0.25, 0.2);
    controller.advance(0.1).expect("a hundred samples");
    assert_eq!(controller.get("samples"), 100.0);
    // The difference of two positions is exact to their last place, over a millisecond.
    close(controller.get("valveVoltage"), 5.6, 3.0 * 1e3 * 1e-16, "difference of the reference is its slope");
}

/// The wanted velocity is the reference's plus a correction of the error, and the feed-forward adds its voltage.
#[test]
fn velocity_of_the_reference_is_fed_forward_with_its_sign() {
    for (slope, error) in [(0.2, 0.0), (-0.2, 0.0), (0.3, 0.01), (-0.1, 0.02)] {
        let rig = bare().set("feedForward.gain", 3.0).set("gain.position", 10.0);
        let rig = rig.set("referenceVelocity", slope).set("referencePosition", 0.25 + error).set("position", 0.25);
        let mut controller = rig.start().expect("legal");
        let wanted = slope + 10.0 * error;
        close(voltage(&mut controller, 0), 5.0 + 3.0 * wanted, ROUNDING, "V");
        close(controller.get("wantedVelocity"), wanted, 0.4 * ROUNDING, "m/s");
        // Differences of samples, which the input takes the place of, would be 0.
        controller.set("referenceVelocity", -slope);
        close(voltage(&mut controller, 1), 5.0 + 3.0 * (wanted - 2.0 * slope), ROUNDING, "V at the next sample");
    }
}

/// Hosts that add up steps, multiply them, or count nanoseconds arrive a little early or late; all get the same.
#[test]
fn samples_see_the_inputs_of_their_communication_point() {
    let times: [fn(f64, u32) -> f64; 3] = [
        |time, _| time + PERIOD,
        |_, index| f64::from(index + 1) * PERIOD,
        |_, index| f64::from(index + 1) * 1_000_000.0 / 1e9,
    ];
    let run = |next: fn(f64, u32) -> f64| {
        let mut controller = Rig::new("PositionController").start().expect("legal");
        let (mut time, mut voltages) = (0.0, Vec::new());
        for index in 0..5000 {
            controller.set("referencePosition", 0.25 + 0.1 * f64::from(index % 7));
            time = next(time, index);
            controller.advance(time).expect("a step");
            voltages.push(controller.get("valveVoltage").to_bits());
        }
        assert_eq!(controller.get("samples"), 5000.0);
        voltages
    };
    let [sums, products, nanoseconds] = times.map(run);
    assert!(sums == products && products == nanoseconds);
}

#[test]
fn voltage_is_held_between_samples() {
    let mut controller = bare().set("gain.velocity", 1.0).set("velocity", -1.0).start().expect("legal");
    assert_eq!(voltage(&mut controller, 0), 6.0);
    controller.set("velocity", -2.0);
    for part in [0.3, 0.9, 1.0] {
        controller.advance(PERIOD * (1.0 + part)).expect("a part of a step");
        assert_eq!(controller.get("valveVoltage"), 7.0);
        controller.set("velocity", -3.0);
    }
    controller.advance(2.01 * PERIOD).expect("a part of a step");
    assert_eq!(controller.get("valveVoltage"), 8.0);
}

#[test]
fn saved_state_goes_on_bit_for_bit() {
    let rig = Rig::new("PositionController").set("velocity", 0.05);
    let mut controller = rig.start().expect("legal");
    controller.set("referencePosition", 0.3);
    controller.advance(0.0375).expect("a step");
    let snapshot = controller.simulation().save();
    let go_on = |controller: &mut Running| {
        let names = ["valveVoltage", "positionError", "integral", "command", "wantedVelocity", "saturated", "samples"];
        (38..60)
            .map(|sample| {
                voltage(controller, sample);
                names.map(|name| controller.get(name).to_bits())
            })
            .collect::<Vec<_>>()
    };
    let expected = go_on(&mut controller);
    controller.simulation().restore(&snapshot).expect("its own");
    assert_eq!(go_on(&mut controller), expected);
    let mut other = rig.start().expect("legal");
    other.set("referencePosition", 0.3);
    other.simulation().restore(&snapshot).expect("of the same model");
    assert_eq!(go_on(&mut other), expected);
}

#[test]
fn snapshots_of_others_are_refused() {
    let mut controller = Rig::new("PositionController").start().expect("legal");
    let mut snapshot = Rig::cylinder("Stribeck").start().expect("legal").simulation().save();
    assert!(controller.simulation().restore(&snapshot).is_err());
    snapshot = controller.simulation().save();
    snapshot.memory.truncate(5);
    assert!(controller.simulation().restore(&snapshot).is_err());
    assert_eq!(controller.simulation().time(), 0.0);
}

/// The carriage of the default experiment moves as fast as it says, to the error of a difference over 0.1 ms.
#[test]
fn velocity_of_the_experiment_is_that_of_its_position() {
    let course = |input| position_controller::MODEL.experiment.signal(input).expect(input).course;
    for step in 0..100 {
        let (time, half) = (0.04 * f64::from(step), 5e-5);
        let difference = course("position").at(time + half) - course("position").at(time - half);
        let velocity = course("velocity").at(time);
        close(difference / (2.0 * half), velocity, 1e-8, format_args!("m/s at {time} s"));
    }
}

/// The controller computes at samples only: nothing is integrated, and no host has anything to solve.
#[test]
fn controller_has_no_continuous_states() {
    let mut controller = Rig::new("PositionController").start().expect("legal");
    assert_eq!(controller.simulation().state_index(0), None);
    assert!(controller.simulation().exchange(position_controller::MODEL.indicators()).is_none());
}

#[test]
fn too_many_samples_end_the_step_where_they_end() {
    let rig = Rig::new("PositionController").set("maxSamplesPerCommunicationStep", 10.0);
    let mut controller = rig.start().expect("legal");
    controller.advance(0.01).expect("ten samples");
    let error = controller.advance(1.0).expect_err("990 samples");
    assert!(matches!(error, StepError::TooManySamples { limit: 10, .. }), "{error:?}");
    assert_eq!(controller.simulation().time(), 0.019);
    controller.advance(0.02).expect("the next sample");
}

/// The loop around the default cylinder follows 0.5 Hz, 200 mm peak to peak, to a few millimetres and stops there.
#[test]
fn default_gains_close_the_loop_around_the_default_cylinder() {
    let mut plant = Rig::cylinder("Stribeck").set("supplyPressure", 6e5).start().expect("legal");
    let mut controller = Rig::new("PositionController").start().expect("legal");
    let mut worst = 0.0f64;
    for index in 0..5000u32 {
        let time = f64::from(index) * PERIOD;
        let reference = 0.25 + 0.1 * (std::f64::consts::PI * time.min(4.0)).sin();
        let (position, velocity) = (plant.get("position"), plant.get("velocity"));
        if time > 1.0 {
            worst = larger(worst, (reference - position).abs());
        }
        for (name, value) in [("referencePosition", reference), ("position", position), ("velocity", velocity)] {
            controller.set(name, value);
        }
        plant.set("valveVoltage", controller.get("valveVoltage"));
        plant.advance(time + PERIOD).expect("a step");
        controller.advance(time + PERIOD).expect("a step");
    }
    let rest = (plant.get("position") - 0.25).abs();
    within(worst, 8e-3, "m of tracking");
    within(rest, 1e-3, "m at rest");
}
