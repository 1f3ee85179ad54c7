//! Co-simulation with event mode: steps that end at events, and inputs that jump.

use pneumatic_servo::model_exchange::HYSTERESIS;

use super::{COULOMB, STRIBECK};
use crate::common::fmi3::{Instance3, Step, Way};
use crate::common::*;

/// A cylinder between steps at 0 s.
fn stepping(way: Way, law: i64, voltage: f64) -> Instance3 {
    let instance = Instance3::cylinder(way, law, voltage);
    if way != Way::Steps {
        assert_eq!((instance.update().0, instance.enter_step_mode()), (OK, OK));
    }
    instance
}

/// Lets an event happen, and goes on to take steps.
fn handle_event(instance: &Instance3) {
    assert_eq!(instance.enter_event_mode(), OK);
    let (status, info) = instance.update();
    assert_eq!(status, OK, "{:?}", instance.messages());
    assert_eq!((info.again, info.terminate, info.nominals, info.values, info.is_defined), (0, 0, 0, 0, 0));
    assert_eq!(instance.enter_step_mode(), OK);
}

/// Steps to a time, and to all events on the way; their times.
fn steps_to(instance: &Instance3, end: f64) -> Vec<f64> {
    let mut events = Vec::new();
    loop {
        let time = instance.real("time");
        if time == end {
            return events;
        }
        let (status, step) = instance.step(time, end - time);
        assert_eq!((status, step.terminate), (OK, 0), "{:?}", instance.messages());
        assert_eq!((step.time, step.early), (instance.real("time"), u8::from(step.time < end)));
        if step.event == 1 {
            events.push(step.time);
            handle_event(instance);
        }
    }
}

/// Makes the error of a run, which ends at other communication points, smaller than the error of an event.
const TIGHT: f64 = 1e-10;

/// When the carriage breaks away at a constant voltage, by halving the interval with steps of co-simulation of FMI 2.0.
fn break_away_by_bisection(law: i32, voltage: f64, guess: f64) -> f64 {
    let instance = Instance::new();
    assert_eq!(instance.set_integer(&[vr("friction.law")], &[law]), OK);
    assert_eq!(instance.set_real(&[vr("valveVoltage"), vr("solver.relativeTolerance")], &[voltage, TIGHT]), OK);
    instance.initialize();
    let start = instance.save();
    let (mut low, mut high) = (guess - 1e-4, guess + 1e-4);
    while high - low > 1e-11 {
        let middle = 0.5 * (low + high);
        assert_eq!((instance.restore(start), instance.step(0.0, middle)), (OK, OK));
        let mut sticks = [7];
        assert_eq!(instance.get_boolean(&[vr("sticking")], &mut sticks), OK);
        *(if sticks == [1] { &mut low } else { &mut high }) = middle;
    }
    high
}

#[test]
pub fn step_ends_at_break_away_as_the_solver_has_located_it() {
    for (law, voltage) in [(STRIBECK, 6.0), (STRIBECK, 5.6), (COULOMB, 7.0)] {
        let instance = Instance3::of(cylinder(), Way::Events(true));
        let settings = [vr("valveVoltage"), vr("solver.relativeTolerance")];
        assert_eq!(
            (instance.set_int64(&[vr("friction.law")], &[law]), instance.set(&settings, &[voltage, TIGHT])),
            (OK, OK)
        );
        assert_eq!((instance.enter(), instance.exit(), instance.enter_step_mode()), (OK, OK, OK));
        let (status, step) = instance.step(0.0, 0.5);
        assert_eq!((status, step.event, step.early, step.terminate), (OK, 1, 1, 0));
        let expected = break_away_by_bisection(law as i32, voltage, step.time);
        assert!((step.time - expected).abs() < 1e-9, "{} s, not {expected} s", step.time);
        assert_eq!(instance.real("time"), step.time);
        // The event has not happened yet, and does with the update.
        assert!(instance.sticks() && instance.real("velocity") == 0.0);
        assert_eq!(instance.enter_event_mode(), OK);
        assert!(instance.sticks());
        assert_eq!(instance.update().0, OK);
        assert!(!instance.sticks());
    }
}

/// The default tolerance moves the path by more, but the step ends where the path as it is breaks away.
#[test]
fn step_ends_where_its_own_path_breaks_away_at_the_default_tolerance() {
    let indicator = indicators().find(|(name, ..)| name == "friction.breakAway");
    let (_, reference, nominal) = indicator.expect("an indicator of break-away");
    for (law, voltage) in [(STRIBECK, 6.0), (STRIBECK, 5.6), (COULOMB, 7.0)] {
        let instance = stepping(Way::Events(true), law, voltage);
        let (status, step) = instance.step(0.0, 0.5);
        assert_eq!((status, step.event, instance.sticks()), (OK, 1, true));
        let (mut seen, mut rate) = ([f64::NAN], [f64::NAN]);
        assert_eq!(instance.get(&[reference], &mut seen), OK);
        assert_eq!(instance.output_rates(&[vr("pressureForce")], &[1], &mut rate), OK);
        // The excess of the force over break-away, as a time. Events are located to a thousandth of the tolerance of a
        // step, which is no longer than 0.1 s here.
        let late = (HYSTERESIS - seen[0]) * nominal / rate[0].abs();
        assert!((0.0..1e-10).contains(&late), "{late} s after the event");
    }
}

/// A communication step that ends where the carriage breaks away is complete, and still tells of the event.
#[test]
fn event_at_the_very_end_of_a_step_is_told_without_early_return() {
    let instance = stepping(Way::Events(true), STRIBECK, 6.0);
    let start = instance.save();
    let to = |end: f64| {
        assert_eq!(instance.restore(start), OK);
        let (status, step) = instance.step(0.0, end);
        assert_eq!(status, OK);
        step
    };
    let guess = to(0.5).time;
    let (mut low, mut high) = (guess - 1e-9, guess + 1e-9);
    assert_eq!((to(low).event, to(high).event), (0, 1));
    while low.next_up() < high {
        let middle = 0.5 * (low + high);
        *(if to(middle).event == 1 { &mut high } else { &mut low }) = middle;
    }
    // Events are located to some last places: of the ends just behind, one is the instant of its event.
    let mut ends = (0..64).map(|places| f64::from_bits(high.to_bits() + places));
    let is_at_the_end = |end: &f64| {
        let step = to(*end);
        assert_eq!((step.event, step.early), (1, u8::from(step.time < *end)));
        step.time == *end
    };
    let end = ends.find(is_at_the_end).expect("an event at the end of a step");
    assert_eq!(to(end), Step { event: 1, terminate: 0, early: 0, time: end });
    // The event happens with the update, as one within a step would.
    assert!(instance.sticks());
    handle_event(&instance);
    assert!(!instance.sticks());
    let before = Step { event: 0, terminate: 0, early: 0, time: low };
    assert_eq!(to(low), before);
}

/// Names, value references and nominal values of the cylinder's event indicators.
fn indicators() -> impl Iterator<Item = (String, u32, f64)> {
    let variables = cylinder().indicator_variables().into_iter();
    variables
        .zip(cylinder().indicators())
        .map(|(variable, indicator)| (variable.name, variable.reference, indicator.nominal))
}

#[test]
fn run_that_returns_at_events_has_the_bits_of_one_that_does_not() {
    for (law, name) in laws() {
        let plain = stepping(Way::Steps, law.into(), 5.8);
        let (status, step) = plain.step(0.0, 0.25);
        assert_eq!((status, step), (OK, Step { event: 0, terminate: 0, early: 0, time: 0.25 }), "{name}");
        let hybrid = stepping(Way::Events(true), law.into(), 5.8);
        steps_to(&hybrid, 0.25);
        assert_eq!(hybrid.bits(), plain.bits(), "{name}");
    }
}

#[test]
fn every_switch_is_told() {
    let instance = stepping(Way::Events(true), STRIBECK, 6.0);
    let mut told = 0;
    for (end, voltage) in [(0.2, 5.0), (0.4, 4.0), (0.7, 6.5), (0.9, 5.0)] {
        told += steps_to(&instance, end).len();
        assert_eq!(instance.enter_event_mode(), OK);
        assert_eq!(instance.set(&[vr("valveVoltage")], &[voltage]), OK);
        assert_eq!((instance.update().0, instance.enter_step_mode()), (OK, OK));
    }
    let mut counted = [0];
    assert_eq!(instance.get_int32(&[vr("solver.events")], &mut counted), OK);
    assert!(told >= 4 && counted == [told as i32], "told of {told}, counted {counted:?}");
}

#[test]
fn without_early_return_events_are_handled_inside() {
    let instance = stepping(Way::Events(false), STRIBECK, 6.0);
    let (status, step) = instance.step(0.0, 0.5);
    assert_eq!((status, step), (OK, Step { event: 0, terminate: 0, early: 0, time: 0.5 }));
    let mut events = [0];
    assert_eq!(instance.get_int32(&[vr("solver.events")], &mut events), OK);
    assert!(events[0] > 0);
}

#[test]
pub fn jump_of_an_input_is_handled_by_the_update() {
    let instance = stepping(Way::Events(true), STRIBECK, 5.0);
    assert_eq!(instance.step(0.0, 0.1).0, OK);
    assert!(instance.sticks());
    assert_eq!(instance.enter_event_mode(), OK);
    assert_eq!(instance.set(&[vr("externalForce")], &[200.0]), OK);
    assert_eq!((instance.update().0, instance.enter_step_mode()), (OK, OK));
    assert!(!instance.sticks());
    let (status, step) = instance.step(0.1, 1e-3);
    assert_eq!((status, step.event, step.time), (OK, 0, 0.101));
    assert!(instance.real("velocity") > 0.0);
}

/// FMI 3.0 discards only what leaves no trace; here the instance has moved.
#[test]
fn step_that_cannot_be_completed_is_an_error_with_the_time_it_has_reached() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    assert_eq!(instance.set_int32(&[vr("solver.maxStepsPerCommunicationStep")], &[3]), OK);
    assert_eq!((instance.enter(), instance.exit()), (OK, OK));
    let (status, step) = instance.step(0.0, 0.5);
    assert_eq!((status, step.event, step.terminate, step.early), (ERROR, 0, 1, 0));
    assert!(step.time > 0.0 && step.time < 0.5 && step.time == instance.real("time"));
    let (status, untouched) = instance.step(step.time, 0.1);
    assert_eq!((status, untouched.event, untouched.terminate), (ERROR, 7, 7));
}
