//! Communication steps.

use std::ffi::c_int;
use std::ptr;

use crate::common::*;

#[test]
pub fn step_ends_exactly_at_point_plus_size() {
    let instance = Instance::initialized();
    let mut time = 0.0;
    for size in [1e-3, 0.0123, 1e-6, 0.1, 1e-9] {
        assert_eq!(instance.step(time, size), OK);
        time += size;
        assert_eq!(instance.real("time"), time);
        assert_eq!(instance.last_successful_time(), time);
    }
}

#[test]
fn size_that_is_not_positive_and_finite_is_an_error() {
    let instance = Instance::initialized();
    let before = instance.fingerprint();
    for size in [0.0, -1e-3, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(instance.step(0.0, size), ERROR, "{size}");
        assert!(instance.message().contains(&size.to_string()));
    }
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn wrong_communication_point_is_an_error_with_both_numbers() {
    let instance = Instance::initialized();
    assert_eq!(instance.step(0.0, 0.25), OK);
    let before = instance.fingerprint();
    for point in [0.0, 0.249, 0.251, -0.25, f64::NAN, f64::INFINITY] {
        assert_eq!(instance.step(point, 0.01), ERROR);
        let message = instance.message();
        assert!(message.contains(&format!("{point} s")) && message.contains("0.25 s"), "{message}");
    }
    assert_eq!(instance.fingerprint(), before);
}

fn started_at(start: f64) -> Instance {
    let instance = Instance::new();
    assert_eq!(instance.setup(start, None), OK);
    assert_eq!((instance.enter(), instance.exit()), (OK, OK));
    instance
}

#[test]
fn grids_of_multiplied_and_of_added_steps_always_move() {
    for (start, size) in [(0.0, 1.0 / 60.0), (256.0, 0.04), (1000.0, 1.0 / 60.0), (256.0, 1e-3)] {
        for added in [false, true] {
            let instance = started_at(start);
            let mut sum = start;
            for index in 0..30 {
                let point = if added { sum } else { start + f64::from(index) * size };
                let before = instance.real("time");
                assert_eq!(instance.step(point, size), OK, "{start} {size} {index}: {:?}", instance.messages());
                assert!(instance.real("time") > before);
                assert_eq!(instance.real("time"), point + size);
                sum += size;
            }
        }
    }
}

#[test]
fn step_size_may_vary() {
    let instance = Instance::initialized();
    let mut time = 0.0;
    for index in 0..50 {
        let size = [1e-3, 7e-5, 0.013, 1e-7][index % 4];
        assert_eq!(instance.set_real(&[vr("valveVoltage")], &[4.0 + (index % 3) as f64]), OK);
        assert_eq!(instance.step(time, size), OK);
        time += size;
    }
}

#[test]
pub fn stop_time_bounds_the_steps_up_to_rounding() {
    let instance = Instance::new();
    assert_eq!(instance.setup(0.0, Some(0.3)), OK);
    assert_eq!((instance.enter(), instance.exit()), (OK, OK));
    let mut time = 0.0;
    for _ in 0..3 {
        assert_eq!(instance.step(time, 0.1), OK);
        time += 0.1;
    }
    // 0.1 + 0.1 + 0.1 is slightly more than 0.3.
    assert!(time > 0.3);
    let before = instance.fingerprint();
    assert_eq!(instance.step(time, 1e-3), ERROR);
    assert!(instance.message().contains("stop time 0.3 s"));
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn impossible_experiments_are_refused() {
    let instance = Instance::new();
    let setup = |tolerance: Option<f64>, start: f64, stop: Option<f64>| {
        let (with_tolerance, tolerance) = (tolerance.is_some().into(), tolerance.unwrap_or(f64::NAN));
        let (with_stop, stop) = (stop.is_some().into(), stop.unwrap_or(f64::NAN));
        // SAFETY: of the component.
        unsafe { (LIBRARY.fmi2SetupExperiment)(instance.component, with_tolerance, tolerance, start, with_stop, stop) }
    };
    for tolerance in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        assert_eq!(setup(Some(tolerance), 0.0, None), ERROR);
    }
    for start in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(setup(None, start, None), ERROR);
    }
    for stop in [0.5, f64::NAN, f64::INFINITY] {
        assert_eq!(setup(None, 1.0, Some(stop)), ERROR);
    }
    assert_eq!(setup(Some(1e-4), 1.0, Some(1.0)), OK);
    assert_eq!(setup(None, -2.0, None), OK);
    assert_eq!((instance.enter(), instance.exit()), (OK, OK));
    assert_eq!(instance.real("time"), -2.0);
}

#[test]
fn tolerance_of_the_experiment_replaces_the_default_only() {
    let run = |experiment: Option<f64>, parameter: Option<f64>| {
        let instance = Instance::new();
        if let Some(parameter) = parameter {
            assert_eq!(instance.set_real(&[vr("solver.relativeTolerance")], &[parameter]), OK);
        }
        // SAFETY: of the component.
        let status = unsafe {
            let (defined, tolerance) = (experiment.is_some().into(), experiment.unwrap_or_default());
            (LIBRARY.fmi2SetupExperiment)(instance.component, defined, tolerance, 0.0, 0, 0.0)
        };
        assert_eq!((status, instance.enter(), instance.exit()), (OK, OK, OK));
        instance.swing(20)
    };
    assert_eq!(run(Some(1e-9), None)[19][..40], run(None, Some(1e-9))[19][..40]);
    assert_ne!(run(Some(1e-9), None)[19][..40], run(None, None)[19][..40]);
    assert_eq!(run(Some(1e-3), Some(1e-9))[19][..40], run(None, Some(1e-9))[19][..40]);
}

/// An instance that may take one solver step for a communication step.
fn short_of_steps() -> Instance {
    let instance = Instance::new();
    assert_eq!(instance.set_integer(&[vr("solver.maxStepsPerCommunicationStep")], &[1]), OK);
    instance.initialize();
    instance
}

#[test]
fn step_that_cannot_be_completed_is_discarded_and_can_be_recovered_from() {
    let instance = short_of_steps();
    let saved = instance.save();
    let before = instance.bits();
    assert_eq!(instance.set_real(&[vr("valveVoltage")], &[9.0]), OK);
    assert_eq!(instance.step(0.0, 0.5), DISCARD);
    let messages = instance.messages();
    assert_eq!((messages.len(), messages[0].status, &*messages[0].category), (1, DISCARD, "logStatusDiscard"));
    assert!(messages[0].text.contains("the limit of 1 solver steps"), "{messages:?}");

    assert_eq!(instance.step_status(), DISCARD);
    assert!(instance.wants_to_terminate());
    let reached = instance.last_successful_time();
    assert!((0.0..0.5).contains(&reached), "{reached}");
    assert_eq!(instance.real("time"), reached);
    assert_eq!(instance.real("valveVoltage"), 9.0);
    instance.bits();
    assert_eq!(instance.step(reached, 1e-3), ERROR, "the simulation is over");
    assert_eq!(instance.set_real(&[vr("valveVoltage")], &[5.0]), ERROR);

    assert_eq!(instance.restore(saved), OK);
    assert_eq!(instance.bits(), before);
    assert_eq!((instance.step_status(), instance.wants_to_terminate()), (OK, false));
    assert_eq!(instance.step(0.0, 1e-9), OK);

    assert_eq!(instance.step(1e-9, 0.5), DISCARD);
    assert_eq!(instance.reset(), OK);
    instance.initialize();
    instance.swing(3);

    let terminated = short_of_steps();
    assert_eq!((terminated.step(0.0, 0.5), terminated.terminate(), terminated.step_status()), (DISCARD, OK, DISCARD));
}

#[test]
fn absurd_inputs_are_discarded_or_computed_but_never_garbage() {
    let mut stepped = 0;
    for (voltage, force, supply) in [(1e308, 0.0, 1e5), (5.0, 1e300, 1e5), (5.0, -1e12, 1e5), (10.0, 0.0, 1e300)] {
        let instance = Instance::new();
        assert_eq!(instance.set_integer(&[vr("solver.maxStepsPerCommunicationStep")], &[2000]), OK);
        let inputs = [vr("valveVoltage"), vr("externalForce"), vr("supplyPressure")];
        assert_eq!(instance.set_real(&inputs, &[voltage, force, supply]), OK);
        assert_eq!((instance.setup(0.0, None), instance.enter()), (OK, OK));
        if instance.exit() != OK {
            assert!(instance.message().contains("not a finite number"));
            continue;
        }
        stepped += 1;
        let status = instance.step(0.0, 0.1);
        assert!([OK, DISCARD].contains(&status), "{:?}", instance.messages());
        let mut values = vec![0.0; references(is_real).len()];
        if instance.get_real(&references(is_real), &mut values) == OK {
            assert!(values.iter().all(|value| value.is_finite()));
        } else {
            assert_eq!(status, DISCARD);
        }
        assert_eq!(instance.reset(), OK);
    }
    assert!(stepped > 0, "none could be initialized");
}

#[test]
pub fn each_status_function_answers_its_kind() {
    let instance = Instance::initialized();
    assert_eq!(instance.step(0.0, 0.01), OK);
    assert_eq!((instance.step_status(), instance.wants_to_terminate()), (OK, false));
    let (component, mut real, mut integer, mut text) = (instance.component, 0.0, 0, ptr::null());
    for kind in STATUS_KINDS.into_iter().chain([-1, 4, c_int::MAX]) {
        // SAFETY: of the component.
        let statuses = unsafe {
            [
                (LIBRARY.fmi2GetStatus)(component, kind, &mut integer),
                (LIBRARY.fmi2GetRealStatus)(component, kind, &mut real),
                (LIBRARY.fmi2GetBooleanStatus)(component, kind, &mut integer),
                (LIBRARY.fmi2GetIntegerStatus)(component, kind, &mut integer),
                (LIBRARY.fmi2GetStringStatus)(component, kind, &mut text),
            ]
        };
        let expected = match kind {
            0 => [OK, DISCARD, DISCARD, DISCARD, DISCARD],
            1 => [DISCARD; 5],
            2 => [DISCARD, OK, DISCARD, DISCARD, DISCARD],
            3 => [DISCARD, DISCARD, OK, DISCARD, DISCARD],
            _ => [ERROR; 5],
        };
        assert_eq!(statuses, expected, "kind {kind}");
    }
}

#[test]
pub fn there_is_never_a_step_to_cancel() {
    let instance = Instance::initialized();
    assert_eq!(instance.step(0.0, 0.01), OK);
    let before = instance.fingerprint();
    // SAFETY: of the component.
    assert_eq!(unsafe { (LIBRARY.fmi2CancelStep)(instance.component) }, ERROR);
    assert!(instance.message().contains("no step is ever pending"));
    assert_eq!(instance.fingerprint(), before);
}

#[test]
fn reset_run_repeats_bit_for_bit() {
    for (law, name) in laws() {
        let instance = Instance::with_law(law);
        let first = instance.swing(30);
        assert_eq!(instance.reset(), OK);
        assert_eq!(instance.set_integer(&[vr("friction.law")], &[law]), OK);
        instance.initialize();
        assert_eq!(instance.swing(30), first, "{name}");
    }
}
