//! What the host's logger is told.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use pneumatic_servo_fmu::fmi2::LOG_CATEGORIES;

use crate::common::*;

fn choose(instance: &Instance, on: c_int, names: &[&str]) -> c_int {
    let names: Vec<_> = names.iter().map(|name| CString::new(*name).expect("no zero byte")).collect();
    let pointers: Vec<*const c_char> = names.iter().map(|name| name.as_ptr()).collect();
    // SAFETY: the strings end with zero bytes.
    unsafe { (LIBRARY.fmi2SetDebugLogging)(instance.component, on, pointers.len(), pointers.as_ptr()) }
}

/// The categories of what is logged during initialization without experiment, and by a refused call.
fn heard(instance: &Instance) -> Vec<String> {
    assert_eq!(instance.enter(), OK);
    assert_eq!(instance.exit(), OK);
    assert_eq!(instance.exit(), ERROR);
    let heard = instance.messages().into_iter().map(|message| message.category).collect();
    assert_eq!(instance.reset(), OK);
    instance.messages();
    heard
}

#[test]
fn errors_are_always_logged_and_everything_else_only_with_logging_on() {
    assert_eq!(heard(&Instance::new()), ["logStatusError"]);
    let talkative = Instance::with_logging(cylinder(), true);
    let all = ["logStatusWarning", "logEvents", "logStatusError"];
    assert_eq!(heard(&talkative), all);
    assert_eq!(choose(&talkative, 0, &[]), OK);
    assert_eq!(heard(&talkative), ["logStatusError"]);
    assert_eq!(choose(&talkative, 1, &[]), OK);
    assert_eq!(heard(&talkative), all);
}

#[test]
fn categories_are_honoured() {
    let instance = Instance::with_logging(cylinder(), true);
    assert_eq!(choose(&instance, 1, &["logEvents"]), OK);
    assert_eq!(heard(&instance), ["logEvents", "logStatusError"]);
    assert_eq!(choose(&instance, 1, &["logStatusWarning", "logStatusError"]), OK);
    assert_eq!(heard(&instance), ["logStatusWarning", "logStatusError"]);
    assert_eq!(choose(&instance, 1, &["logAll"]), OK);
    assert_eq!(heard(&instance).len(), 3);
    assert_eq!(choose(&instance, 0, &["logEvents"]), OK);
    assert_eq!(heard(&instance), ["logStatusError"]);
    for category in LOG_CATEGORIES {
        assert_eq!(choose(&instance, 1, &[category.name]), OK);
    }
}

#[test]
fn unknown_and_missing_categories_are_refused_and_change_nothing() {
    let instance = Instance::new();
    assert_eq!(choose(&instance, 1, &["logEvents", "logNothing"]), ERROR);
    assert!(instance.message().contains("logNothing"));
    // SAFETY: NULL is allowed to be passed.
    unsafe {
        assert_eq!((LIBRARY.fmi2SetDebugLogging)(instance.component, 1, 1, ptr::null()), ERROR);
        assert_eq!((LIBRARY.fmi2SetDebugLogging)(instance.component, 1, 1, &ptr::null()), ERROR);
    }
    instance.messages();
    assert_eq!(heard(&instance), ["logStatusError"]);
}

/// `printf` prints a message as it was meant, whether or not the host's logger knows of variadic arguments.
#[test]
fn percent_signs_are_doubled_and_nothing_asks_for_an_argument() {
    extern "C" fn raw(environment: *mut c_void, _: *const c_char, _: c_int, _: *const c_char, format: *const c_char) {
        // SAFETY: the environment is the text below, and the format is a string.
        unsafe { *environment.cast::<String>() = CStr::from_ptr(format).to_str().expect("UTF-8").to_owned() };
    }
    let mut format = String::new();
    let callbacks = CallbackFunctions { logger: Some(as_logger(raw)), ..callbacks(&Messages::default()) };
    let callbacks = CallbackFunctions { environment: (&raw mut format).cast(), ..callbacks };
    // SAFETY: the strings end with zero bytes, and the text outlives the call.
    unsafe {
        let guid = c"100 %s".as_ptr();
        assert!((LIBRARY.fmi2Instantiate)(c"a".as_ptr(), 1, guid, ptr::null(), &callbacks, 0, 0).is_null());
    }
    let format = std::hint::black_box(format);
    assert!(format.starts_with("fmi2Instantiate: the GUID 100 %%s is not that of a model"), "{format}");
}

#[test]
fn message_carries_name_status_category_and_function() {
    let instance = Instance::new();
    assert_eq!(instance.step(0.0, 1.0), ERROR);
    let text = "fmi2DoStep: not allowed before initialization; it is allowed between communication steps".to_owned();
    let (name, category) = ("test".to_owned(), "logStatusError".to_owned());
    assert_eq!(instance.messages(), [Message { name, status: ERROR, category, text }]);
}
