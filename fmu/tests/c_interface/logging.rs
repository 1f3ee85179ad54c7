//! Messages to the host's logger.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use pneumatic_servo_fmu::fmi2::LOG_CATEGORIES;
use pneumatic_servo_fmu::fmi2::types::EventInfo;

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
pub fn errors_are_always_logged_and_everything_else_only_with_logging_on() {
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

#[test]
fn what_is_discarded_without_an_end_of_the_run_is_logged_for_those_who_ask() {
    for (asked, expected) in [("logStatusDiscard", 1), ("logStatusError", 0)] {
        let instance = Instance::with_logging(cylinder(), true);
        assert_eq!(choose(&instance, 1, &[asked]), OK);
        instance.initialize();
        assert_eq!(instance.step(0.0, 0.01), OK);
        instance.messages();
        let mut value = 0;
        // SAFETY: the component lives, and the number takes the answer.
        assert_eq!(unsafe { (LIBRARY.fmi2GetIntegerStatus)(instance.component, 1, &raw mut value) }, DISCARD);
        let messages = instance.messages();
        assert_eq!(messages.len(), expected, "{asked}");
        let is_told = |it: &Message| it.category == "logStatusDiscard" && it.text.starts_with("fmi2GetIntegerStatus: ");
        assert!(messages.iter().all(is_told));
        assert_eq!(instance.step(0.01, 0.01), OK);
    }
}

/// The warnings since the last call of this.
fn warnings(instance: &Instance) -> Vec<String> {
    let messages = instance.messages().into_iter();
    messages.filter(|message| message.category == "logStatusWarning").map(|message| message.text).collect()
}

#[test]
fn supply_below_ambient_is_warned_of_once_per_fall() {
    let instance = Instance::with_logging(cylinder(), true);
    let supply = [vr("supplyPressure")];
    assert_eq!(instance.set_real(&supply, &[0.0]), OK);
    instance.initialize();
    let expected = "supplyPressure = 0: it acts as ambientPressure";
    assert!(matches!(&warnings(&instance)[..], [text] if text.contains(expected)), "initialized at 0 Pa");
    let mut time = 0.0;
    let mut step = |pressure: f64| {
        assert_eq!(instance.set_real(&supply, &[pressure]), OK);
        assert_eq!(instance.step(time, 0.01), OK);
        time += 0.01;
        warnings(&instance).len()
    };
    assert_eq!([0.0, 5.0, 5e5, 5e5, 5.0, 5.0].map(&mut step), [0, 0, 0, 0, 1, 0]);
    assert_eq!(step(5e5), 0);
    // 5 bar fall to 1 bar within the step.
    assert_eq!(instance.set_slopes(&supply, &[-4e7]), OK);
    assert_eq!(instance.step(0.07, 0.01), OK);
    assert!(matches!(&warnings(&instance)[..], [text] if text.contains("supplyPressure = ")), "fallen below");
}

#[test]
fn solver_outside_is_warned_of_a_supply_below_ambient_too() {
    let instance = Instance::for_exchange(cylinder());
    assert_eq!(choose(&instance, 1, &["logStatusWarning"]), OK);
    instance.initialize();
    assert!(warnings(&instance).is_empty());
    assert_eq!(instance.set_real(&[vr("supplyPressure")], &[5.0]), OK);
    let mut info = EventInfo::default();
    for expected in [1, 0] {
        // SAFETY: the component lives, and the record takes the answer.
        assert_eq!(unsafe { (LIBRARY.fmi2NewDiscreteStates)(instance.component, &raw mut info) }, OK);
        assert_eq!(warnings(&instance).len(), expected);
    }
}

#[test]
fn shares_that_do_not_add_up_to_1_are_warned_of_at_the_start() {
    let instance = Instance::with_logging(cylinder(), true);
    assert_eq!(instance.set_integer(&[vr("friction.law")], &[16]), OK);
    assert_eq!(instance.set_real(&[vr("friction.gms.alpha[1]")], &[0.5]), OK);
    instance.initialize();
    let expected = "sum of friction.gms.alpha = 1.25: ";
    assert!(matches!(&warnings(&instance)[..], [text] if text.contains(expected)));
    assert_eq!(instance.step(0.0, 0.01), OK);
    assert!(warnings(&instance).is_empty());
}

#[test]
fn start_values_without_effect_or_in_a_forgotten_unit_are_warned_of() {
    let instance = Instance::with_logging(cylinder(), true);
    let changed = ["friction.lugre.Fs", "supply.C", "valve.bandwidth"].map(vr);
    assert_eq!(instance.set_real(&changed, &[40.0, 2e-8, 0.12]), OK);
    instance.initialize();
    let told = warnings(&instance);
    assert_eq!(told.len(), 3, "{told:?}");
    let expected = [
        "supply.C has no effect: it counts only with supply.volume above 0",
        "friction.lugre.Fs has no effect: it counts only with friction.law = LuGre, and here it is Stribeck",
        "did you mean 0.12 kHz, which is 120 Hz?",
    ];
    assert!(expected.iter().all(|end| told.iter().any(|text| text.ends_with(end))), "{told:?}");
    assert_eq!(instance.step(0.0, 0.01), OK);
    assert!(warnings(&instance).is_empty());
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
    assert!(format.starts_with("fmi2Instantiate: the GUID 100 %%s belongs to no model"), "{format}");
}

#[test]
fn message_carries_name_status_category_and_function() {
    let instance = Instance::new();
    assert_eq!(instance.step(0.0, 1.0), ERROR);
    let text = "fmi2DoStep: not allowed before initialization; it is allowed between communication steps".to_owned();
    let (name, category) = ("test".to_owned(), "logStatusError".to_owned());
    assert_eq!(instance.messages(), [Message { name, status: ERROR, category, text }]);
}
