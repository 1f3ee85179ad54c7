//! Which function may be called when.

use std::ffi::{c_int, c_void};
use std::ptr;

use crate::common::*;

/// Instances in each state: before initialization (I), in initialization mode (M), after a complete step (C), after a
/// failed one (F), terminated (T).
const STATES: [char; 5] = ['I', 'M', 'C', 'F', 'T'];

fn instance_in(state: char) -> Instance {
    let instance = Instance::new();
    if state == 'F' {
        assert_eq!(instance.set_integer(&[vr("solver.maxStepsPerCommunicationStep")], &[1]), OK);
    }
    if state != 'I' {
        assert_eq!((instance.setup(0.0, None), instance.enter()), (OK, OK));
    }
    match state {
        'C' | 'F' | 'T' => assert_eq!(instance.exit(), OK),
        _ => (),
    }
    match state {
        'C' => assert_eq!(instance.step(0.0, 1e-3), OK),
        'F' => assert_eq!(instance.step(0.0, 0.5), DISCARD),
        'T' => assert_eq!(instance.terminate(), OK),
        _ => (),
    }
    instance.messages();
    instance
}

/// Arguments of the calls.
struct Arguments {
    time: f64,
    state: *mut c_void,
    bytes: Vec<u8>,
}

type Function = fn(&Instance, &mut Arguments) -> c_int;

fn set_debug_logging(instance: &Instance) -> c_int {
    // SAFETY: of the component, as everywhere below.
    unsafe { (LIBRARY.fmi2SetDebugLogging)(instance.component, 0, 0, ptr::null()) }
}

fn strings(instance: &Instance, set: bool) -> c_int {
    let component = instance.component;
    // SAFETY: as above; no string is passed.
    unsafe {
        if set {
            (LIBRARY.fmi2SetString)(component, ptr::null(), 0, ptr::null())
        } else {
            (LIBRARY.fmi2GetString)(component, ptr::null(), 0, ptr::null_mut())
        }
    }
}

fn status(
    instance: &Instance,
    function: unsafe extern "C" fn(*mut c_void, c_int, *mut c_int) -> c_int,
    kind: c_int,
) -> c_int {
    let mut value = 0;
    // SAFETY: as above.
    unsafe { function(instance.component, kind, &mut value) }
}

/// Each function, the states in which it may be called, a call that is otherwise right, and what it returns then.
const TABLE: [(&str, &str, Function, c_int); 31] = [
    ("fmi2SetDebugLogging", "IMCFT", |it, _| set_debug_logging(it), OK),
    ("fmi2SetupExperiment", "I", |it, _| it.setup(0.0, None), OK),
    ("fmi2EnterInitializationMode", "I", |it, _| it.enter(), OK),
    ("fmi2ExitInitializationMode", "M", |it, _| it.exit(), OK),
    ("fmi2Terminate", "CF", |it, _| it.terminate(), OK),
    ("fmi2Reset", "IMCFT", |it, _| it.reset(), OK),
    ("fmi2GetReal", "IMCFT", |it, _| it.get_real(&[vr("valveVoltage")], &mut [0.0]), OK),
    ("fmi2GetReal of a computed value", "MCFT", |it, _| it.get_real(&[vr("position")], &mut [0.0]), OK),
    ("fmi2GetInteger", "IMCFT", |it, _| it.get_integer(&[vr("friction.law")], &mut [0]), OK),
    ("fmi2GetBoolean", "MCFT", |it, _| it.get_boolean(&[vr("sticking")], &mut [0]), OK),
    ("fmi2GetString", "IMCFT", |it, _| strings(it, false), OK),
    ("fmi2SetReal of an input", "IMC", |it, _| it.set_real(&[vr("valveVoltage")], &[6.0]), OK),
    ("fmi2SetReal of a fixed parameter", "IM", |it, _| it.set_real(&[vr("mass.moving")], &[1.0]), OK),
    ("fmi2SetReal of a tunable parameter", "IMC", |it, _| it.set_real(&[vr("wireForce")], &[1.0]), OK),
    ("fmi2SetInteger", "IM", |it, _| it.set_integer(&[vr("friction.law")], &[2]), OK),
    ("fmi2SetBoolean", "IMC", |it, _| it.set_boolean(&[], &[]), OK),
    ("fmi2SetString", "IMC", |it, _| strings(it, true), OK),
    (
        "fmi2GetFMUstate",
        "IMCFT",
        |it, with| {
            let mut state = with.state;
            // SAFETY: as above.
            unsafe { (LIBRARY.fmi2GetFMUstate)(it.component, &mut state) }
        },
        OK,
    ),
    ("fmi2SetFMUstate", "IMCFT", |it, with| it.restore(with.state), OK),
    ("fmi2FreeFMUstate", "IMCFT", |it, with| it.forget(&mut with.state), OK),
    (
        "fmi2SerializedFMUstateSize and fmi2SerializeFMUstate",
        "IMCFT",
        |it, with| {
            let serialized = it.serialize(with.state);
            c_int::from(serialized != with.bytes)
        },
        OK,
    ),
    ("fmi2DeSerializeFMUstate", "IMCFT", |it, with| it.deserialize(&with.bytes).0, OK),
    (
        "fmi2GetDirectionalDerivative",
        "MCFT",
        |it, _| it.directional(&[vr("acceleration")], &[vr("externalForce")], &[1.0], &mut [0.0]),
        OK,
    ),
    ("fmi2SetRealInputDerivatives", "IMC", |it, _| it.set_slopes(&[vr("valveVoltage")], &[1.0]), OK),
    ("fmi2GetRealOutputDerivatives", "CFT", |it, _| it.output_derivatives(&[vr("position")], &[1], &mut [0.0]), OK),
    ("fmi2DoStep", "C", |it, with| it.step(with.time, 1e-3), OK),
    (
        "fmi2CancelStep",
        "",
        // SAFETY: as above.
        |it, _| unsafe { (LIBRARY.fmi2CancelStep)(it.component) },
        OK,
    ),
    ("fmi2GetStatus", "CFT", |it, _| status(it, LIBRARY.fmi2GetStatus, 0), OK),
    (
        "fmi2GetRealStatus",
        "CFT",
        |it, _| {
            let mut value = 0.0;
            // SAFETY: as above.
            unsafe { (LIBRARY.fmi2GetRealStatus)(it.component, 2, &mut value) }
        },
        OK,
    ),
    ("fmi2GetIntegerStatus", "CFT", |it, _| status(it, LIBRARY.fmi2GetIntegerStatus, 1), DISCARD),
    ("fmi2GetBooleanStatus", "CFT", |it, _| status(it, LIBRARY.fmi2GetBooleanStatus, 3), OK),
];

#[test]
fn every_function_is_allowed_exactly_in_its_states() {
    for (name, allowed, function, result) in TABLE {
        for state in STATES {
            let instance = instance_in(state);
            let saved = instance.save();
            let time = instance.real("time");
            let mut arguments = Arguments { time, state: saved, bytes: instance.serialize(saved) };
            let before = instance.fingerprint();
            let actual = function(&instance, &mut arguments);
            let messages = instance.messages();
            if allowed.contains(state) {
                assert_eq!(actual, result, "{name} in {state}: {messages:?}");
            } else {
                assert_eq!(actual, ERROR, "{name} in {state}");
                assert_eq!(instance.fingerprint(), before, "{name} in {state}");
                assert_eq!(messages.len(), 1, "{name} in {state}: {messages:?}");
            }
        }
    }
}

#[test]
pub fn string_status_is_asked_for_between_initialization_and_the_end() {
    for state in STATES {
        let (instance, mut value) = (instance_in(state), ptr::null());
        // SAFETY: as above.
        let actual = unsafe { (LIBRARY.fmi2GetStringStatus)(instance.component, 1, &mut value) };
        assert_eq!(actual, if "CFT".contains(state) { DISCARD } else { ERROR });
        assert!(value.is_null());
    }
}

#[test]
fn reset_leads_back_to_the_start_from_everywhere() {
    let fresh = Instance::new().fingerprint();
    for state in STATES {
        let instance = instance_in(state);
        assert_eq!(instance.set_real(&[vr("valveVoltage")], &[7.0]), if "IMC".contains(state) { OK } else { ERROR });
        assert_eq!(instance.reset(), OK);
        assert_eq!(instance.fingerprint(), fresh, "{state}");
        instance.messages();
        instance.initialize();
        assert_eq!(instance.step(0.0, 1e-3), OK);
    }
}

#[test]
pub fn terminated_run_takes_no_step_and_can_still_be_read() {
    let instance = instance_in('C');
    let values = instance.bits();
    assert_eq!(instance.terminate(), OK);
    assert_eq!(instance.step(1e-3, 1e-3), ERROR);
    assert!(instance.message().contains("not allowed after termination"));
    assert_eq!(instance.bits(), values);
}

#[test]
fn instance_is_freed_in_every_state() {
    for state in STATES {
        drop(instance_in(state));
    }
}

#[test]
pub fn missing_experiment_means_start_at_zero() {
    let instance = Instance::new();
    assert_eq!((instance.enter(), instance.exit()), (OK, OK));
    assert_eq!(instance.real("time"), 0.0);
    assert_eq!(instance.step(0.0, 1e-3), OK);
}
