//! The host's logger.

#![allow(unsafe_code, reason = "the logger is a C function")]

use super::types::{InstanceEnvironment, LogMessage};
use crate::instance::Sink;

/// Takes messages to the host's logger, if there is one.
pub fn sink(logger: Option<LogMessage>, environment: InstanceEnvironment) -> Sink {
    let Some(logger) = logger else {
        return Box::new(|_, _, _| ());
    };
    let environment = Environment(environment);
    Box::new(move |status, category, message| {
        // SAFETY: the logger is the host's function; it takes the arguments of `fmi3LogMessageCallback`.
        unsafe { logger(environment.pointer(), status as i32, category.as_ptr(), message.as_ptr()) }
    })
}

/// The host's pointer, which is only handed back to it.
struct Environment(InstanceEnvironment);

// SAFETY: nothing here looks behind the pointer; the host may call an instance from one thread after another.
unsafe impl Send for Environment {}

impl Environment {
    fn pointer(&self) -> InstanceEnvironment {
        self.0
    }
}
