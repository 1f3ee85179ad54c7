//! Making and freeing instances.

use std::env;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use pneumatic_servo::models;
use pneumatic_servo_fmu::fmi2;

use crate::common::*;

fn instantiate(name: Option<&CStr>, fmu_type: c_int, guid: Option<&CStr>, messages: &Messages) -> *mut c_void {
    let pointer = |text: Option<&CStr>| text.map_or(ptr::null(), CStr::as_ptr);
    // SAFETY: the strings end with zero bytes.
    unsafe {
        (LIBRARY.fmi2Instantiate)(pointer(name), fmu_type, pointer(guid), ptr::null(), &callbacks(messages), 0, 0)
    }
}

fn guid() -> CString {
    CString::new(fmi2::guid(cylinder())).expect("no zero byte")
}

#[test]
pub fn every_model_is_served_under_its_own_guid() {
    for model in served() {
        let instance = Instance::of(model);
        instance.initialize();
        assert_eq!(instance.step(0.0, 1e-3), OK, "{}", model.name);
        assert_eq!(models::ALL.iter().filter(|other| fmi2::guid(other) == fmi2::guid(model)).count(), 1);
    }
}

#[test]
fn wrong_guid_name_or_type_gives_null_and_a_message() {
    let guid = guid();
    let cases = [
        (Some(c"a"), 1, Some(c"{00000000-0000-0000-0000-000000000000}"), "modelDescription.xml"),
        (Some(c"a"), 1, Some(c""), "modelDescription.xml"),
        (Some(c"a"), 1, None, "GUID"),
        (Some(c""), 1, Some(&*guid), "instance name"),
        (None, 1, Some(&*guid), "instance name"),
        (Some(c"a"), -1, Some(&*guid), "fmi2CoSimulation"),
        (Some(c"a"), 7, Some(&*guid), "fmi2CoSimulation"),
    ];
    for (name, fmu_type, guid, reason) in cases {
        let messages = Messages::default();
        assert!(instantiate(name, fmu_type, guid, &messages).is_null());
        let messages = messages.into_inner().expect("no panic while logging");
        let [message] = &messages[..] else { panic!("one message, not {messages:?}") };
        assert!(message.text.contains(reason), "{message:?}");
        assert_eq!((message.status, &*message.category), (ERROR, "logStatusError"));
        assert_eq!(message.name, name.unwrap_or_default().to_str().expect("UTF-8"));
    }
}

#[test]
fn percent_signs_in_messages_are_no_formats() {
    let messages = Messages::default();
    assert!(instantiate(Some(c"%n%s"), 1, Some(c"%s%n%d"), &messages).is_null());
    let messages = messages.into_inner().expect("no panic while logging");
    assert!(messages[0].text.contains("%s%n%d"));
    assert_eq!(messages[0].name, "%n%s");
}

#[test]
fn bytes_that_are_no_utf8_are_harmless() {
    let guid = CString::new(b"\xff\xfe{".as_slice()).expect("no zero byte");
    assert!(instantiate(Some(c"a"), 1, Some(&guid), &Messages::default()).is_null());
}

#[test]
fn missing_callbacks_are_harmless() {
    let guid = guid();
    let none = CallbackFunctions {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        environment: ptr::null_mut(),
    };
    for callbacks in [ptr::null(), &raw const none] {
        // SAFETY: all strings end with zero bytes; the component is freed once.
        unsafe {
            let refused = (LIBRARY.fmi2Instantiate)(c"a".as_ptr(), 1, ptr::null(), ptr::null(), callbacks, 0, 1);
            assert!(refused.is_null());
            let component = (LIBRARY.fmi2Instantiate)(c"a".as_ptr(), 1, guid.as_ptr(), ptr::null(), callbacks, 0, 1);
            assert!(!component.is_null());
            assert_eq!((LIBRARY.fmi2DoStep)(component, 0.0, 1.0, 0), ERROR);
            assert_eq!((LIBRARY.fmi2EnterInitializationMode)(component), OK);
            assert_eq!((LIBRARY.fmi2ExitInitializationMode)(component), OK);
            (LIBRARY.fmi2FreeInstance)(component);
        }
    }
}

/// The test ends if this is ever called: no panic passes through C.
extern "C" fn logger_of_a_freed_record(
    _environment: *mut c_void,
    _name: *const c_char,
    _status: c_int,
    _category: *const c_char,
    _format: *const c_char,
) {
    unreachable!("the callbacks were copied before");
}

#[test]
fn callbacks_may_be_gone_after_instantiation() {
    let messages = Box::new(Messages::default());
    let mut given = Box::new(callbacks(&messages));
    // SAFETY: all strings end with zero bytes.
    let component = unsafe { (LIBRARY.fmi2Instantiate)(c"a".as_ptr(), 1, guid().as_ptr(), ptr::null(), &*given, 0, 0) };
    given.logger = Some(as_logger(logger_of_a_freed_record));
    drop(given);
    // SAFETY: the component lives until it is freed.
    unsafe {
        assert_eq!((LIBRARY.fmi2DoStep)(component, 0.0, 1.0, 0), ERROR);
        (LIBRARY.fmi2FreeInstance)(component);
    }
    assert_eq!(messages.lock().expect("no panic while logging").len(), 1);
}

#[test]
fn resource_location_may_have_any_form() {
    let guid = guid();
    let forms = [
        c"file:/tmp/resources",
        c"file:///tmp/resources",
        c"file://localhost/tmp/resources",
        c"file:///C:/a%20b/resources/",
        c"/tmp/resources",
        c"C:\\resources",
        c"nonsense://%",
        c"",
    ];
    for location in forms.map(CStr::as_ptr).into_iter().chain([ptr::null::<c_char>()]) {
        // SAFETY: all strings end with zero bytes; the component is freed once.
        unsafe {
            let component = (LIBRARY.fmi2Instantiate)(c"a".as_ptr(), 1, guid.as_ptr(), location, ptr::null(), 1, 0);
            assert!(!component.is_null());
            (LIBRARY.fmi2FreeInstance)(component);
        }
    }
}

#[test]
fn null_is_no_component_and_freeing_it_is_harmless() {
    let null = ptr::null_mut();
    let (references, mut real, mut integer, mut text, mut state, mut size) =
        ([0], [0.0], [0], [ptr::null()], ptr::null_mut(), 0);
    let (vr, orders) = (references.as_ptr(), [1].as_ptr());
    // SAFETY: all arrays have one element.
    let statuses = unsafe {
        (LIBRARY.fmi2FreeInstance)(null);
        [
            (LIBRARY.fmi2SetDebugLogging)(null, 1, 0, ptr::null()),
            (LIBRARY.fmi2SetupExperiment)(null, 0, 0.0, 0.0, 0, 0.0),
            (LIBRARY.fmi2EnterInitializationMode)(null),
            (LIBRARY.fmi2ExitInitializationMode)(null),
            (LIBRARY.fmi2Terminate)(null),
            (LIBRARY.fmi2Reset)(null),
            (LIBRARY.fmi2GetReal)(null, vr, 1, real.as_mut_ptr()),
            (LIBRARY.fmi2GetInteger)(null, vr, 1, integer.as_mut_ptr()),
            (LIBRARY.fmi2GetBoolean)(null, vr, 1, integer.as_mut_ptr()),
            (LIBRARY.fmi2GetString)(null, vr, 1, text.as_mut_ptr()),
            (LIBRARY.fmi2SetReal)(null, vr, 1, real.as_ptr()),
            (LIBRARY.fmi2SetInteger)(null, vr, 1, integer.as_ptr()),
            (LIBRARY.fmi2SetBoolean)(null, vr, 1, integer.as_ptr()),
            (LIBRARY.fmi2SetString)(null, vr, 1, text.as_ptr()),
            (LIBRARY.fmi2GetFMUstate)(null, &mut state),
            (LIBRARY.fmi2SetFMUstate)(null, state),
            (LIBRARY.fmi2FreeFMUstate)(null, &mut state),
            (LIBRARY.fmi2SerializedFMUstateSize)(null, state, &mut size),
            (LIBRARY.fmi2SerializeFMUstate)(null, state, ptr::null_mut(), 0),
            (LIBRARY.fmi2DeSerializeFMUstate)(null, ptr::null(), 0, &mut state),
            (LIBRARY.fmi2GetDirectionalDerivative)(null, vr, 1, vr, 1, real.as_ptr(), real.as_mut_ptr()),
            (LIBRARY.fmi2SetRealInputDerivatives)(null, vr, 1, orders, real.as_ptr()),
            (LIBRARY.fmi2GetRealOutputDerivatives)(null, vr, 1, orders, real.as_mut_ptr()),
            (LIBRARY.fmi2DoStep)(null, 0.0, 1.0, 0),
            (LIBRARY.fmi2CancelStep)(null),
            (LIBRARY.fmi2GetStatus)(null, 0, integer.as_mut_ptr()),
            (LIBRARY.fmi2GetRealStatus)(null, 2, real.as_mut_ptr()),
            (LIBRARY.fmi2GetIntegerStatus)(null, 0, integer.as_mut_ptr()),
            (LIBRARY.fmi2GetBooleanStatus)(null, 3, integer.as_mut_ptr()),
            (LIBRARY.fmi2GetStringStatus)(null, 1, text.as_mut_ptr()),
        ]
    };
    assert_eq!(statuses, [ERROR; 30]);
}

#[test]
fn instances_do_not_know_each_other() {
    let alone = Instance::initialized().swing(20);
    let (one, other) = (Instance::initialized(), Instance::initialized());
    assert_eq!(other.set_real(&[vr("valveVoltage")], &[10.0]), OK);
    let mixed = (0..20).flat_map(|index| {
        assert_eq!(other.step(f64::from(index) * 1e-3, 1e-3), OK);
        one.swing(1)
    });
    assert!(mixed.eq(alone));
}

/// The numeric locale that C code in this process sees.
#[cfg(unix)]
fn locale() -> String {
    let this = libloading::os::unix::Library::this();
    // SAFETY: `setlocale(LC_ALL, NULL)` only asks.
    unsafe {
        let setlocale: libloading::os::unix::Symbol<unsafe extern "C" fn(c_int, *const c_char) -> *const c_char> =
            this.get(b"setlocale\0").expect("the C library");
        CStr::from_ptr(setlocale(6, ptr::null())).to_string_lossy().into_owned()
    }
}

#[cfg(not(unix))]
fn locale() -> String {
    String::new()
}

#[test]
fn working_directory_and_locale_stay_as_they_are() {
    let before = (env::current_dir().expect("a directory"), locale());
    Instance::initialized().swing(5);
    assert_eq!((env::current_dir().expect("a directory"), locale()), before);
}

/// A call back into the instance whose message is being logged.
extern "C" fn reentrant_logger(
    environment: *mut c_void,
    _name: *const c_char,
    _status: c_int,
    _category: *const c_char,
    _format: *const c_char,
) {
    // SAFETY: the environment is the array below: the component, and room for the answers.
    let shared = unsafe { &mut *environment.cast::<[usize; 3]>() };
    let component = ptr::with_exposed_provenance_mut(shared[0]);
    // SAFETY: the component is live.
    unsafe {
        shared[1] = (LIBRARY.fmi2Reset)(component) as usize;
        (LIBRARY.fmi2FreeInstance)(component);
    }
    shared[2] += 1;
}

#[test]
fn logger_that_calls_back_is_refused() {
    let mut shared = [0usize; 3];
    let callbacks = CallbackFunctions {
        logger: Some(as_logger(reentrant_logger)),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        environment: (&raw mut shared).cast(),
    };
    // SAFETY: the strings end with zero bytes, and `shared` outlives the instance.
    unsafe {
        let component = (LIBRARY.fmi2Instantiate)(c"a".as_ptr(), 1, guid().as_ptr(), ptr::null(), &callbacks, 0, 0);
        (&raw mut shared[0]).write(component.expose_provenance());
        assert_eq!((LIBRARY.fmi2EnterInitializationMode)(component), OK);
        assert_eq!((LIBRARY.fmi2DoStep)(component, 0.0, 1.0, 0), ERROR);
        assert_eq!((LIBRARY.fmi2ExitInitializationMode)(component), OK);
        (LIBRARY.fmi2FreeInstance)(component);
        assert_eq!((&raw const shared).read()[1..], [ERROR as usize, 1]);
    }
}
