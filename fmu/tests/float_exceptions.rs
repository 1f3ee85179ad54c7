//! Floating-point exceptions: importers that trap invalid operations, divisions by zero and overflows (OpenFOAM and Delphi do by default)
//! must not be stopped by a step of an FMU.
#![cfg(all(target_os = "linux", target_env = "gnu"))]
#![allow(unsafe_code, reason = "a C interface is called, and the flags of the floating-point unit are read")]

use std::ffi::{CString, c_int, c_void};
use std::ptr;

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Role, Variable};
use pneumatic_servo_builtin::FMI2;
use pneumatic_servo_fmu::fmi2;
use pneumatic_servo_fmu::fmi2::exports::*;
use pneumatic_servo_fmu::fmi2::types::OK;

#[link(name = "m")]
unsafe extern "C" {
    fn feclearexcept(exceptions: c_int) -> c_int;
    fn fetestexcept(exceptions: c_int) -> c_int;
}

/// `FE_INVALID`, `FE_DIVBYZERO` and `FE_OVERFLOW` of the platform.
#[cfg(target_arch = "x86_64")]
const TRAPPED: c_int = 1 | 4 | 8;
#[cfg(target_arch = "aarch64")]
const TRAPPED: c_int = 1 | 2 | 4;

/// The motion that a tool imposes.
const IMPOSED: i32 = 2;

/// The exceptions that a call raises.
fn raised(call: impl FnOnce() -> c_int) -> c_int {
    // SAFETY: functions of the C library without conditions.
    unsafe { feclearexcept(TRAPPED) };
    assert_eq!(call(), OK);
    // SAFETY: as above.
    unsafe { fetestexcept(TRAPPED) }
}

/// The calls of a run that raise an exception, each with the exceptions.
fn raising(model: &Model, choices: &[(&str, i32)]) -> Vec<String> {
    let variables = model.table();
    let reference = |name: &str| variables.find(name).map(|entry| entry.variable.reference);
    let is_real_input = |it: &&Variable| it.role == Role::Input && matches!(it.kind, Kind::Real(_));
    let inputs: Vec<&Variable> = variables.iter().filter(is_real_input).collect();
    let references: Vec<u32> = inputs.iter().map(|variable| variable.reference).collect();
    let outputs: Vec<u32> =
        variables.computed().filter(|it| matches!(it.kind, Kind::Real(_))).map(|it| it.reference).collect();
    let guid = CString::new(fmi2::guid(model)).expect("no zero byte");
    let step = model.experiment.step_size.min(1e-2);
    let mut found = Vec::new();
    let mut note = |call: &str, exceptions: c_int| {
        if exceptions != 0 {
            found.push(format!("{} with {choices:?}: {call} raises {exceptions}", model.name));
        }
    };
    // SAFETY: strings end with zero bytes, the component is alive, and all arrays have the length that is passed.
    unsafe {
        feclearexcept(TRAPPED);
        let component: *mut c_void =
            (FMI2.fmi2Instantiate)(c"a".as_ptr(), 1, guid.as_ptr(), ptr::null(), ptr::null(), 0, 0);
        note("fmi2Instantiate", fetestexcept(TRAPPED));
        for (name, item) in choices {
            let reference = reference(name).expect("a variable of the model");
            assert_eq!(fmi2SetInteger(component, &reference, 1, item), OK);
        }
        note("fmi2EnterInitializationMode", raised(|| fmi2EnterInitializationMode(component)));
        note("fmi2ExitInitializationMode", raised(|| fmi2ExitInitializationMode(component)));
        let mut values = vec![0.0; outputs.len()];
        for index in 0..600 {
            let time = f64::from(index) * step;
            let swing = |variable: &&Variable| {
                let start = variable.start.unwrap_or_default();
                start + 0.4 * variable.nominal.unwrap_or(1.0) * (6.0 * f64::from(index) * 1e-2).sin()
            };
            let given: Vec<f64> = inputs.iter().map(swing).collect();
            note(
                "fmi2SetReal",
                raised(|| fmi2SetReal(component, references.as_ptr(), references.len(), given.as_ptr())),
            );
            note(&format!("fmi2DoStep at {time} s"), raised(|| fmi2DoStep(component, time, step, 1)));
            note(
                "fmi2GetReal",
                raised(|| fmi2GetReal(component, outputs.as_ptr(), outputs.len(), values.as_mut_ptr())),
            );
        }
        feclearexcept(TRAPPED);
        fmi2FreeInstance(component);
        note("fmi2FreeInstance", fetestexcept(TRAPPED));
    }
    found
}

#[test]
fn no_function_raises_an_exception_that_importers_trap() {
    let mut found = Vec::new();
    for model in models::ALL {
        let has = |name: &str| model.table().find(name).is_some();
        let laws = LAWS.items.iter().map(|(id, ..)| vec![("friction.law", *id)]).filter(|_| has("friction.law"));
        let laws: Vec<_> = laws.chain([vec![]]).collect();
        // A motion that the tool imposes begins at rest.
        let imposed = laws.iter().map(|law| [&law[..], &[("motion", IMPOSED)]].concat()).filter(|_| has("motion"));
        for choices in laws.iter().cloned().chain(imposed) {
            found.extend(raising(model, &choices).into_iter().take(3));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
