//! The host's logger.

#![allow(unsafe_code, reason = "the logger is a C function")]

use std::ffi::{CStr, CString, c_void};

use super::types::CallbackFunctions;
use crate::instance::Sink;

/// Takes messages to the host's logger, if there is one.
pub fn sink(name: CString, functions: Option<CallbackFunctions>) -> Sink {
    let Some((logger, environment)) = functions.and_then(|it| Some((it.logger?, it.environment))) else {
        return Box::new(|_, _, _| ());
    };
    let environment = Environment(environment);
    Box::new(move |status, category, message| {
        let format = without_arguments(message);
        // SAFETY: the logger is the host's function; it takes the arguments of `fmi2CallbackLogger`, here a format
        // that asks for no argument, so that it does not matter whether it knows of variadic ones.
        unsafe { logger(environment.pointer(), name.as_ptr(), status as i32, category.as_ptr(), format.as_ptr()) }
    })
}

/// A text as a format of `printf` that prints the text: every percent sign is doubled.
fn without_arguments(text: &CStr) -> CString {
    let doubled: Vec<u8> =
        text.to_bytes().iter().flat_map(|byte| vec![*byte; 1 + usize::from(*byte == b'%')]).collect();
    CString::new(doubled).unwrap_or_default()
}

/// The host's pointer, which is only handed back to it.
struct Environment(*mut c_void);

// SAFETY: nothing here looks behind the pointer; the host may call an instance from one thread after another.
unsafe impl Send for Environment {}

impl Environment {
    fn pointer(&self) -> *mut c_void {
        self.0
    }
}
