//! Start time, stop time and tolerance, which FMI 3.0 sets where the initialization begins; logging.

use std::ffi::{CString, c_int};
use std::ptr;

use super::STRIBECK;
use crate::common::fmi3::{Instance3, LIBRARY3, Way};
use crate::common::*;
use pneumatic_servo_fmu::guid;

fn enter(instance: &Instance3, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> c_int {
    let enter = LIBRARY3.fmi3EnterInitializationMode;
    let (has_tolerance, tolerance) = (tolerance.is_some().into(), tolerance.unwrap_or(f64::NAN));
    let (has_stop, stop) = (stop.is_some().into(), stop.unwrap_or(f64::NAN));
    // SAFETY: of the component.
    unsafe { enter(instance.component, has_tolerance, tolerance, start, has_stop, stop) }
}

#[test]
pub fn run_begins_at_the_start_and_ends_at_the_stop() {
    for way in [Way::Steps, Way::Events(true)] {
        let instance = Instance3::of(cylinder(), way);
        assert_eq!((enter(&instance, None, -2.0, Some(-1.5)), instance.exit()), (OK, OK));
        assert_eq!(instance.real("time"), -2.0);
        if way != Way::Steps {
            assert_eq!((instance.update().0, instance.enter_step_mode()), (OK, OK));
        }
        assert_eq!((instance.step(-2.0, 0.5).0, instance.step(-1.5, 1e-3).0), (OK, ERROR));
        assert!(instance.message().contains("stop time -1.5 s"));
    }
    let instance = Instance3::of(cylinder(), Way::Exchange);
    assert_eq!((enter(&instance, None, -2.0, None), instance.exit()), (OK, OK));
    assert_eq!(instance.real("time"), -2.0);
    assert_eq!((instance.set_time(-2.5), instance.set_time(-1.9)), (ERROR, OK));
}

#[test]
fn tolerance_of_the_experiment_replaces_the_default_only() {
    let run = |experiment: Option<f64>, parameter: Option<f64>| {
        let instance = Instance3::of(cylinder(), Way::Steps);
        assert_eq!(instance.set(&[vr("valveVoltage")], &[8.0]), OK);
        if let Some(parameter) = parameter {
            assert_eq!(instance.set(&[vr("solver.relativeTolerance")], &[parameter]), OK);
        }
        assert_eq!((enter(&instance, experiment, 0.0, None), instance.exit()), (OK, OK));
        assert_eq!(instance.step(0.0, 0.1).0, OK);
        instance.real("position")
    };
    assert_eq!(run(Some(1e-9), None), run(None, Some(1e-9)));
    assert_ne!(run(Some(1e-9), None), run(None, None));
    assert_eq!(run(Some(1e-3), Some(1e-9)), run(None, Some(1e-9)));
}

#[test]
fn impossible_experiments_are_refused_and_change_nothing() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    let before = instance.fingerprint();
    for (tolerance, start, stop) in [
        (None, f64::NAN, None),
        (None, 0.0, Some(-1.0)),
        (None, 0.0, Some(f64::INFINITY)),
        (Some(0.0), 0.0, None),
        (Some(f64::NAN), 0.0, None),
    ] {
        assert_eq!(enter(&instance, tolerance, start, stop), ERROR, "{tolerance:?} {start} {stop:?}");
        assert_eq!(instance.fingerprint(), before);
    }
}

/// The categories of what is logged by an initialization, and by a call that is refused.
fn heard(instance: &Instance3) -> Vec<String> {
    assert_eq!((instance.enter(), instance.exit(), instance.exit()), (OK, OK, ERROR));
    let heard = instance.messages().into_iter().map(|message| message.category).collect();
    assert_eq!(instance.reset(), OK);
    instance.messages();
    heard
}

#[test]
pub fn logging_is_switched_by_categories() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    let choose = |on: u8, category: Option<&str>| {
        let name = category.map(|category| CString::new(category).expect("no zero byte"));
        let names = [name.as_ref().map_or(ptr::null(), |name| name.as_ptr())];
        // SAFETY: of the component; the string ends with a zero byte.
        unsafe {
            let number = usize::from(category.is_some());
            (LIBRARY3.fmi3SetDebugLogging)(instance.component, on, number, names.as_ptr())
        }
    };
    assert_eq!(heard(&instance), ["logStatusError"]);
    assert_eq!(
        (choose(1, Some("logEvents")), heard(&instance)),
        (OK, vec!["logEvents".into(), "logStatusError".into()])
    );
    assert_eq!((choose(0, None), heard(&instance)), (OK, vec!["logStatusError".to_owned()]));
    assert_eq!(choose(1, Some("logNothing")), ERROR);
    assert!(instance.message().contains("logNothing"));
}

/// FMI 3.0.2 (the argument `loggingOn` of the functions that make instances) forbids every call of the logger without
/// logging; the text for 3.0.3 excepts errors and asks for them (fmi-standard issue 2072, pull request 2097).
#[test]
pub fn without_logging_nothing_but_errors_is_logged_and_without_logger_nothing() {
    let steps = Instance3::of(cylinder(), Way::Steps);
    // A supply below ambient is worth a warning, a start and a reset are events.
    assert_eq!(steps.set(&[vr("supplyPressure")], &[0.0]), OK);
    assert_eq!(steps.set_int32(&[vr("solver.maxStepsPerCommunicationStep")], &[1]), OK);
    assert_eq!((steps.enter(), steps.exit()), (OK, OK));
    assert_eq!(steps.messages(), []);
    assert_eq!(steps.step(0.0, 0.5).0, ERROR);
    let told = steps.messages().into_iter().map(|message| (message.status, message.category)).collect::<Vec<_>>();
    assert_eq!(told, [(ERROR, "logStatusError".to_owned())]);
    assert_eq!((steps.reset(), steps.messages()), (OK, vec![]));

    let (token, none) = (CString::new(guid(cylinder())).expect("no zero byte"), ptr::null());
    // SAFETY: all strings end with zero bytes, and the component is freed once.
    unsafe {
        let make = LIBRARY3.fmi3InstantiateCoSimulation;
        let quiet = make(c"a".as_ptr(), token.as_ptr(), none, 0, 1, 0, 0, ptr::null(), 0, ptr::null_mut(), None, None);
        assert_eq!((LIBRARY3.fmi3ExitInitializationMode)(quiet), ERROR);
        (LIBRARY3.fmi3FreeInstance)(quiet);
    }
}

#[test]
pub fn terminated_run_takes_no_step() {
    let instance = Instance3::cylinder(Way::Steps, STRIBECK, 6.0);
    assert_eq!((instance.step(0.0, 0.01).0, instance.terminate(), instance.step(0.01, 0.01).0), (OK, OK, ERROR));
    assert!(instance.message().contains("not allowed after termination"));
}
