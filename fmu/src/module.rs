//! Services of a module for sources in C besides the functions of FMI: room for the host's arrays, its logger, the message of a
//! panic, and the one model that the module serves.

#![allow(unsafe_code, reason = "this is an interface to C")]

use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr;

use crate::fmi2::types::{CallbackFunctions, Logger};

thread_local! {
    /// Where the host's arrays are during a call; 64-bit words, so that all types are aligned.
    static ROOM: RefCell<Vec<u64>> = const { RefCell::new(Vec::new()) };
    /// Callbacks of the host for an instance of FMI 2.0.
    static CALLBACKS: RefCell<CallbackFunctions> = RefCell::new(callbacks());
}

// Named as a module's import: linkers refuse a function that is merely declared.
#[link(wasm_import_module = "env")]
unsafe extern "C" {
    /// Takes a message to the host, which knows the name of the instance.
    fn host_log(status: c_int, category: *const c_char, text: *const c_char);
    /// Takes the message of a panic, after which the module is never entered again.
    fn host_panic(text: *const c_char);
}

/// Tells the host of panics, before they trap.
#[unsafe(no_mangle)]
pub extern "C" fn plant_begin() {
    std::panic::set_hook(Box::new(|panic| {
        let text = CString::new(panic.payload_as_str().unwrap_or("a panic without message")).unwrap_or_default();
        // The text stays, and with it the module ends.
        // SAFETY: the host only reads.
        unsafe { host_panic(text.into_raw()) }
    }));
}

/// Room that is always there, in 64-bit words: for the arguments of all calls whose arrays have a fixed size.
const LEAST_ROOM: usize = 64;

/// Room for arrays of the host's, as many bytes as it asks for at least; NULL if there is no memory for it. What was there
/// before may be gone.
#[unsafe(no_mangle)]
pub extern "C" fn plant_room(bytes: usize) -> *mut u64 {
    ROOM.with_borrow_mut(|room| {
        let words = bytes.div_ceil(size_of::<u64>()).max(LEAST_ROOM);
        if words > room.len() {
            room.clear();
            if room.try_reserve_exact(words).is_err() {
                return ptr::null_mut();
            }
            room.resize(words, 0);
        }
        room.as_mut_ptr()
    })
}

/// The callbacks of an instance of FMI 2.0 whose host has a logger.
#[unsafe(no_mangle)]
pub extern "C" fn plant_callbacks() -> *const CallbackFunctions {
    CALLBACKS.with(|callbacks| callbacks.as_ptr().cast_const())
}

fn callbacks() -> CallbackFunctions {
    // SAFETY: in WebAssembly a variadic function takes, after the arguments that it names, the address of the others, of
    // which there are none.
    let logger = unsafe { std::mem::transmute::<*const (), Logger>(log_of_fmi2 as *const ()) };
    CallbackFunctions {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        environment: ptr::null_mut(),
    }
}

unsafe extern "C" fn log_of_fmi2(
    _environment: *mut c_void,
    _name: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    _arguments: *const c_void,
) {
    // SAFETY: the host only reads.
    unsafe { host_log(status, category, format) }
}

/// The logger of an instance of FMI 3.0 whose host has one.
#[unsafe(no_mangle)]
pub extern "C" fn plant_logger() -> unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char) {
    log_of_fmi3
}

unsafe extern "C" fn log_of_fmi3(
    _environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    text: *const c_char,
) {
    // SAFETY: the host only reads.
    unsafe { host_log(status, category, text) }
}
