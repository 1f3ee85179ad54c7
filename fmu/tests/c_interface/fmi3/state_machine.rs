//! Which function may be called when, in each way of running the model.

use std::ffi::c_int;
use std::ptr;

use super::{INDICATORS, STATES};
use crate::common::fmi3::{Instance3, LIBRARY3, Way};
use crate::common::*;

/// Before initialization (I), in initialization mode (M), between steps (C), after a failed step (F), in event mode (E),
/// in continuous-time mode (X), terminated (T).
fn modes(way: Way) -> &'static str {
    match way {
        Way::Steps => "IMCFT",
        Way::Events(_) => "IMCFET",
        Way::Exchange => "IMEXT",
    }
}

fn instance_in(way: Way, mode: char) -> Instance3 {
    let instance = Instance3::of(cylinder(), way);
    if mode == 'F' {
        assert_eq!(instance.set_int32(&[vr("solver.maxStepsPerCommunicationStep")], &[1]), OK);
    }
    if mode != 'I' {
        assert_eq!(instance.enter(), OK);
    }
    if !"IM".contains(mode) {
        assert_eq!(instance.exit(), OK);
    }
    if "CF".contains(mode) && way != Way::Steps {
        assert_eq!(instance.enter_step_mode(), OK);
    }
    match mode {
        'F' => assert_eq!(instance.step(0.0, 0.5).0, ERROR),
        'X' => assert_eq!(instance.integrate(), OK),
        'T' => assert_eq!(instance.terminate(), OK),
        _ => (),
    }
    instance.messages();
    instance
}

type Function = fn(&Instance3) -> c_int;

/// Each function, and the modes in which it may be called: in co-simulation without and with event mode, and in model
/// exchange.
const TABLE: [(&str, [&str; 3], Function); 36] = [
    ("fmi3EnterInitializationMode", ["I", "I", "I"], Instance3::enter),
    ("fmi3ExitInitializationMode", ["M", "M", "M"], Instance3::exit),
    ("fmi3EnterEventMode", ["", "C", "X"], Instance3::enter_event_mode),
    ("fmi3EnterStepMode", ["", "E", ""], Instance3::enter_step_mode),
    ("fmi3EnterContinuousTimeMode", ["", "", "E"], Instance3::integrate),
    ("fmi3UpdateDiscreteStates", ["", "E", "E"], |it| it.update().0),
    ("fmi3Terminate", ["CF", "CFE", "EX"], Instance3::terminate),
    ("fmi3Reset", ["IMCFT", "IMCFET", "IMEXT"], Instance3::reset),
    ("fmi3GetFloat64", ["IMCFT", "IMCFET", "IMEXT"], |it| it.get(&[vr("valveVoltage")], &mut [0.0])),
    ("fmi3GetFloat64 of a computed value", ["MCFT", "MCFET", "MEXT"], |it| it.get(&[vr("position")], &mut [0.0])),
    ("fmi3GetFloat64 of an indicator", ["MCFT", "MCFET", "MEXT"], |it| it.get(&[6_000], &mut [0.0])),
    ("fmi3GetInt32", ["MCFT", "MCFET", "MEXT"], |it| it.get_int32(&[vr("solver.events")], &mut [0])),
    ("fmi3GetInt64", ["IMCFT", "IMCFET", "IMEXT"], |it| it.get_int64(&[vr("friction.law")], &mut [0])),
    ("fmi3GetBoolean", ["MCFT", "MCFET", "MEXT"], |it| it.get_boolean(&[vr("sticking")], &mut [0])),
    ("fmi3SetFloat64 of an input", ["IMC", "IMCE", "IMEX"], |it| it.set(&[vr("valveVoltage")], &[6.0])),
    ("fmi3SetFloat64 of a fixed parameter", ["IM", "IM", "IM"], |it| it.set(&[vr("mass.moving")], &[1.0])),
    ("fmi3SetFloat64 of a tunable parameter", ["IMC", "IMCE", "IME"], |it| it.set(&[vr("wireForce")], &[1.0])),
    ("fmi3SetInt64", ["IM", "IM", "IM"], |it| it.set_int64(&[vr("friction.law")], &[2])),
    ("fmi3GetFMUState", ["IMCFT", "IMCFET", "IMEXT"], |it| c_int::from(it.save().is_null())),
    ("fmi3GetDirectionalDerivative", ["MCFT", "MCFET", "MEXT"], |it| {
        it.directional(&[vr("acceleration")], &[vr("externalForce")], &[1.0], &mut [0.0])
    }),
    ("fmi3GetAdjointDerivative", ["MCFT", "MCFET", "MEXT"], |it| {
        it.adjoint(&[vr("acceleration")], &[vr("externalForce")], &[1.0], &mut [0.0])
    }),
    ("fmi3GetOutputDerivatives", ["CFT", "CFT", ""], |it| it.output_rates(&[vr("position")], &[1], &mut [0.0])),
    ("fmi3DoStep", ["C", "C", ""], |it| it.step(0.0, 1e-3).0),
    ("fmi3CompletedIntegratorStep", ["", "", "X"], Instance3::accept_step),
    ("fmi3SetTime", ["", "", "EX"], |it| it.set_time(0.0)),
    ("fmi3SetContinuousStates", ["", "", "X"], |it| {
        let mut states = [1.0; STATES];
        it.vector(LIBRARY3.fmi3GetContinuousStates, &mut states);
        it.set_states(&states)
    }),
    ("fmi3GetContinuousStates", ["", "", "MEXT"], |it| it.vector(LIBRARY3.fmi3GetContinuousStates, &mut [0.0; STATES])),
    ("fmi3GetContinuousStateDerivatives", ["", "", "MEXT"], |it| {
        it.vector(LIBRARY3.fmi3GetContinuousStateDerivatives, &mut [0.0; STATES])
    }),
    ("fmi3GetNominalsOfContinuousStates", ["", "", "MEXT"], |it| {
        it.vector(LIBRARY3.fmi3GetNominalsOfContinuousStates, &mut [0.0; STATES])
    }),
    ("fmi3GetEventIndicators", ["", "", "MEXT"], |it| {
        it.vector(LIBRARY3.fmi3GetEventIndicators, &mut [0.0; INDICATORS])
    }),
    ("fmi3GetNumberOfEventIndicators", ["IMCFT", "IMCFET", "IMEXT"], |it| {
        c_int::from(it.number(LIBRARY3.fmi3GetNumberOfEventIndicators) != INDICATORS)
    }),
    ("fmi3GetNumberOfContinuousStates", ["IMCFT", "IMCFET", "IMEXT"], |it| {
        c_int::from(it.number(LIBRARY3.fmi3GetNumberOfContinuousStates) != STATES)
    }),
    // SAFETY, here and below: of the component; nothing is read from NULL.
    ("fmi3SetDebugLogging", ["IMCFT", "IMCFET", "IMEXT"], |it| unsafe {
        (LIBRARY3.fmi3SetDebugLogging)(it.component, 0, 0, ptr::null())
    }),
    ("fmi3EnterConfigurationMode", ["", "", ""], |it| unsafe { (LIBRARY3.fmi3EnterConfigurationMode)(it.component) }),
    ("fmi3EvaluateDiscreteStates", ["", "", ""], |it| unsafe { (LIBRARY3.fmi3EvaluateDiscreteStates)(it.component) }),
    ("fmi3ActivateModelPartition", ["", "", ""], |it| unsafe {
        (LIBRARY3.fmi3ActivateModelPartition)(it.component, 0, 0.0)
    }),
];

#[test]
fn every_function_is_allowed_exactly_in_its_modes() {
    for (column, way) in [(0, Way::Steps), (1, Way::Events(false)), (1, Way::Events(true)), (2, Way::Exchange)] {
        for (name, allowed, function) in &TABLE {
            for mode in modes(way).chars() {
                let allowed = allowed[column].contains(mode);
                let instance = instance_in(way, mode);
                let before = instance.fingerprint();
                let status = function(&instance);
                if allowed {
                    assert_eq!(status, OK, "{name} in {mode} ({way:?}): {:?}", instance.messages());
                } else {
                    assert_eq!(status, ERROR, "{name} in {mode} ({way:?})");
                    assert_eq!(instance.fingerprint(), before, "{name} in {mode} ({way:?})");
                    let messages = instance.messages();
                    let function = name.split(' ').next().expect("a word");
                    let text = &messages.last().expect("a reason").text;
                    assert!(text.starts_with(&format!("{function}: ")), "{text}");
                }
            }
        }
    }
}

#[test]
pub fn what_is_not_offered_is_refused_with_a_reason() {
    let instance = Instance3::of(cylinder(), Way::Steps);
    // SAFETY: of the component.
    let statuses = unsafe {
        [
            (LIBRARY3.fmi3EnterConfigurationMode)(instance.component),
            (LIBRARY3.fmi3ExitConfigurationMode)(instance.component),
            (LIBRARY3.fmi3EvaluateDiscreteStates)(instance.component),
            (LIBRARY3.fmi3ActivateModelPartition)(instance.component, 1, 0.0),
        ]
    };
    assert_eq!(statuses, [ERROR; 4]);
    let texts: Vec<_> = instance.messages().into_iter().map(|message| message.text).collect();
    for (text, reason) in texts.iter().zip(["structural", "structural", "update", "no clocks"]) {
        assert!(text.contains(reason), "{text}");
    }
}

#[test]
fn components_that_are_null_are_refused() {
    // SAFETY: NULL is allowed to be passed.
    unsafe {
        assert_eq!((LIBRARY3.fmi3Reset)(ptr::null_mut()), ERROR);
        assert_eq!((LIBRARY3.fmi3GetFloat64)(ptr::null_mut(), ptr::null(), 0, ptr::null_mut(), 0), ERROR);
        (LIBRARY3.fmi3FreeInstance)(ptr::null_mut());
    }
}
