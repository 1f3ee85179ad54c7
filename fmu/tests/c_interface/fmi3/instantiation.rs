//! Making and freeing instances.

use std::ffi::CString;
use std::ptr;

use pneumatic_servo::models;
use pneumatic_servo_fmu::guid;

use crate::common::fmi3::{Instance3, LIBRARY3, Way, instantiate};
use crate::common::*;

const WAYS: [Way; 4] = [Way::Steps, Way::Events(false), Way::Events(true), Way::Exchange];

fn token(name: &str) -> CString {
    CString::new(guid(model(name))).expect("no zero byte")
}

#[test]
fn version_is_that_of_fmi_3() {
    // SAFETY: it returns a static string.
    assert_eq!(unsafe { std::ffi::CStr::from_ptr((LIBRARY3.fmi3GetVersion)()) }, c"3.0");
}

#[test]
fn every_model_can_be_made_in_every_way_but_one_without_states_is_not_exchanged() {
    for model in models::ALL {
        for way in WAYS {
            let token = token(model.name);
            let (component, messages) = instantiate(way, c"a", &token);
            let is_exchanged = (model.variables)().number_of_states() > 0;
            assert_eq!(component.is_null(), way == Way::Exchange && !is_exchanged, "{} {way:?}", model.name);
            if component.is_null() {
                let text = messages.lock().expect("no panic")[0].text.clone();
                assert!(text.starts_with("fmi3InstantiateModelExchange: ") && text.contains("no continuous states"));
            }
            // SAFETY: the component is NULL or freed once.
            unsafe { (LIBRARY3.fmi3FreeInstance)(component) }
        }
    }
}

#[test]
fn wrong_name_and_wrong_token_are_refused_with_the_name_of_the_function() {
    for way in WAYS {
        let function = match way {
            Way::Exchange => "fmi3InstantiateModelExchange: ",
            _ => "fmi3InstantiateCoSimulation: ",
        };
        for (name, token, reason) in [
            (c"", token("PneumaticServoCylinder"), "the instance name is missing"),
            (c"a", CString::new("{token}").expect("no zero byte"), "the instantiation token {token} is not"),
        ] {
            let (component, messages) = instantiate(way, name, &token);
            assert!(component.is_null());
            let messages = messages.lock().expect("no panic");
            assert_eq!((messages.len(), messages[0].status), (1, ERROR));
            let text = &messages[0].text;
            assert!(text.starts_with(function) && text.contains(reason), "{text}");
        }
    }
}

#[test]
fn scheduled_execution_and_intermediate_variables_are_refused() {
    let (token, none) = (token("PneumaticServoCylinder"), ptr::null());
    // SAFETY: all strings end with zero bytes; there is no logger.
    unsafe {
        let make = LIBRARY3.fmi3InstantiateScheduledExecution;
        let component = make(c"a".as_ptr(), token.as_ptr(), none, 0, 0, ptr::null_mut(), None, None, None, None);
        assert!(component.is_null());
        let (make, wanted) = (LIBRARY3.fmi3InstantiateCoSimulation, [vr("position")]);
        let component =
            make(c"a".as_ptr(), token.as_ptr(), none, 0, 0, 1, 1, wanted.as_ptr(), 1, ptr::null_mut(), None, None);
        assert!(component.is_null());
    }
}

#[test]
fn instances_can_be_reset_in_every_way() {
    for way in WAYS {
        let instance = Instance3::of(cylinder(), way);
        let fresh = instance.fingerprint();
        assert_eq!((instance.set(&[vr("valveVoltage")], &[7.0]), instance.enter(), instance.exit()), (OK, OK, OK));
        assert_ne!(instance.fingerprint(), fresh);
        assert_eq!(instance.reset(), OK);
        assert_eq!(instance.fingerprint(), fresh, "{way:?}");
    }
}
