//! Making and freeing instances.

use std::ffi::CString;
use std::ptr;

use pneumatic_servo_fmu::guid;

use crate::common::fmi3::{Instance3, LIBRARY3, Way, instantiate, logger};
use crate::common::*;

const WAYS: [Way; 4] = [Way::Steps, Way::Events(false), Way::Events(true), Way::Exchange];

fn token(name: &str) -> CString {
    CString::new(guid(model(name))).expect("no zero byte")
}

#[test]
pub fn version_is_that_of_fmi_3() {
    // SAFETY: it returns a static string.
    let text = unsafe { (LIBRARY3.fmi3GetVersion)() };
    assert!(!text.is_null());
    // SAFETY: as above.
    assert_eq!(unsafe { std::ffi::CStr::from_ptr(text) }, c"3.0");
}

#[test]
pub fn every_model_can_be_made_in_every_way_but_one_without_states_is_not_exchanged() {
    for model in served() {
        for way in WAYS {
            let token = token(model.name);
            let (component, messages) = instantiate(way, c"a", &token);
            let is_exchanged = model.table().number_of_states() > 0;
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
            (
                c"a",
                CString::new("{token}").expect("no zero byte"),
                "the instantiation token {token} belongs to no model",
            ),
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
pub fn scheduled_execution_and_intermediate_variables_are_refused() {
    let (token, none, messages) = (token("PneumaticServoCylinder"), ptr::null(), Messages::default());
    let (name, told) = (c"a".as_ptr(), ptr::from_ref(&messages).cast_mut().cast());
    // SAFETY: all strings end with zero bytes, and the messages outlive the calls.
    let components = unsafe {
        let make = LIBRARY3.fmi3InstantiateScheduledExecution;
        let scheduled = make(name, token.as_ptr(), none, 0, 0, told, Some(logger), None, None, None);
        let (make, wanted) = (LIBRARY3.fmi3InstantiateCoSimulation, [vr("position")]);
        let updated = make(name, token.as_ptr(), none, 0, 0, 1, 1, wanted.as_ptr(), 1, told, Some(logger), None);
        [scheduled, updated]
    };
    assert_eq!(components, [ptr::null_mut(); 2]);
    let texts: Vec<_> = messages.lock().expect("no panic").iter().map(|message| message.text.clone()).collect();
    let reasons =
        ["fmi3InstantiateScheduledExecution: there is no scheduled", "fmi3InstantiateCoSimulation: 1 variable"];
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert!(texts.iter().zip(reasons).all(|(text, reason)| text.starts_with(reason)), "{texts:?}");
}

#[test]
pub fn instances_can_be_reset_in_every_way() {
    for way in WAYS {
        let instance = Instance3::of(cylinder(), way);
        let fresh = instance.fingerprint();
        assert_eq!((instance.set(&[vr("valveVoltage")], &[7.0]), instance.enter(), instance.exit()), (OK, OK, OK));
        assert_ne!(instance.fingerprint(), fresh);
        assert_eq!(instance.reset(), OK);
        assert_eq!(instance.fingerprint(), fresh, "{way:?}");
    }
}
