//! Messages to the host's logger.

use std::ffi::{CStr, CString};

use crate::failure::{Failure, Status};

/// A log category; the XML lists them all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogCategory {
    /// Name.
    pub name: &'static str,
    /// Description of its messages.
    pub description: &'static str,
}

const EVENTS: usize = 0;
const WARNING: usize = 1;
const DISCARD: usize = 2;
const ERROR: usize = 3;
const FATAL: usize = 4;
const ALL: usize = 5;

/// The log categories of every model of this library.
pub const LOG_CATEGORIES: [LogCategory; 6] = [
    LogCategory { name: "logEvents", description: "Initialization, reset and restored states of the instance" },
    LogCategory { name: "logStatusWarning", description: "Unusual values and settings, which are accepted" },
    LogCategory {
        name: "logStatusDiscard",
        description: "Steps that could not be completed, which are always logged, and impossible states that a solver tries",
    },
    LogCategory { name: "logStatusError", description: "Calls that were refused; always logged" },
    LogCategory { name: "logStatusFatal", description: "Internal errors; always logged" },
    LogCategory { name: "logAll", description: "All of the above" },
];

/// Takes messages to the host: status, category, text.
pub type Sink = Box<dyn Fn(Status, &CStr, &CStr) + Send>;

/// The log of an instance: failures are always logged, everything else only if the host wants it.
pub struct Log {
    sink: Sink,
    /// The function of the standard that is being carried out, as its face calls it.
    function: &'static str,
    enabled: [bool; LOG_CATEGORIES.len()],
}

impl Log {
    /// A log with all categories switched on or off.
    pub fn new(sink: Sink, on: bool) -> Self {
        Self { sink, function: "", enabled: [on; LOG_CATEGORIES.len()] }
    }

    /// Names the function that is now carried out; all messages start with it.
    pub fn enter(&mut self, function: &'static str) {
        self.function = function;
    }

    /// Switches logging on for some categories (for all, if none is named) or off.
    pub fn choose(&mut self, on: bool, names: &[&str]) -> Result<(), Failure> {
        let mut enabled = [on && names.is_empty(); LOG_CATEGORIES.len()];
        for name in names {
            let Some(category) = LOG_CATEGORIES.iter().position(|category| category.name == *name) else {
                let known = LOG_CATEGORIES.map(|category| category.name).join(", ");
                return Err(Failure::error(format!("unknown log category \"{name}\"; the categories are {known}")));
            };
            enabled[category] = on;
        }
        self.enabled = enabled;
        Ok(())
    }

    /// Logs a step in the life of the instance.
    pub fn event(&self, text: &str) {
        self.if_enabled(EVENTS, Status::Ok, text);
    }

    /// Whether warnings are logged.
    pub fn takes_warnings(&self) -> bool {
        self.enabled[WARNING] || self.enabled[ALL]
    }

    /// Logs a warning.
    pub fn warning(&self, text: &str) {
        self.if_enabled(WARNING, Status::Warning, text);
    }

    /// Logs a failure, whether or not logging is on.
    pub fn failure(&self, failure: &Failure) {
        let category = match failure.status {
            Status::Discard => DISCARD,
            Status::Fatal => FATAL,
            _ => ERROR,
        };
        self.write(category, failure.status, &failure.message);
    }

    /// Logs a discarded call, which may be tried otherwise, such as a trial step of an importer's solver.
    pub fn discarded(&self, failure: &Failure) {
        self.if_enabled(DISCARD, failure.status, &failure.message);
    }

    fn if_enabled(&self, category: usize, status: Status, text: &str) {
        if self.enabled[category] || self.enabled[ALL] {
            self.write(category, status, text);
        }
    }

    fn write(&self, category: usize, status: Status, text: &str) {
        let category = c_string(LOG_CATEGORIES[category].name);
        (self.sink)(status, &category, &c_string(&format!("{}: {text}", self.function)));
    }
}

/// A C string; zero bytes, which it cannot hold, are shown as replacement characters.
fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, channel};

    use super::*;

    fn log(on: bool) -> (Log, Receiver<(Status, String, String)>) {
        let (sender, receiver) = channel();
        let owned = |text: &CStr| text.to_str().expect("UTF-8").to_owned();
        let sink = move |status, category: &CStr, text: &CStr| {
            sender.send((status, owned(category), owned(text))).expect("the receiver lives");
        };
        (Log::new(Box::new(sink), on), receiver)
    }

    fn categories_heard(log: &Log, receiver: &Receiver<(Status, String, String)>) -> Vec<String> {
        log.event("x");
        log.warning("x");
        log.failure(&Failure::discard("x"));
        log.failure(&Failure::error("x"));
        log.failure(&Failure::fatal("x"));
        receiver.try_iter().map(|(_, category, _)| category).collect()
    }

    const FAILURES: [&str; 3] = ["logStatusDiscard", "logStatusError", "logStatusFatal"];

    #[test]
    fn failures_are_logged_even_when_logging_is_off() {
        let (log, receiver) = log(false);
        assert_eq!(categories_heard(&log, &receiver), FAILURES);
    }

    #[test]
    fn everything_is_logged_when_logging_is_on() {
        let (log, receiver) = log(true);
        let all = [&["logEvents", "logStatusWarning"], &FAILURES[..]].concat();
        assert_eq!(categories_heard(&log, &receiver), all);
    }

    #[test]
    fn chosen_categories_are_logged_besides_failures() {
        let (mut log, receiver) = log(true);
        log.choose(true, &["logEvents"]).expect("a known category");
        assert_eq!(categories_heard(&log, &receiver), [&["logEvents"], &FAILURES[..]].concat());
        log.choose(true, &["logAll"]).expect("a known category");
        assert_eq!(categories_heard(&log, &receiver).len(), 5);
        log.choose(false, &[]).expect("no category");
        assert_eq!(categories_heard(&log, &receiver), FAILURES);
    }

    #[test]
    fn unknown_category_is_refused_and_changes_nothing() {
        let (mut log, receiver) = log(false);
        let failure = log.choose(true, &["logAll", "nonsense"]).expect_err("an unknown category");
        assert!(failure.message.contains("nonsense"), "{failure:?}");
        assert_eq!(categories_heard(&log, &receiver), FAILURES);
    }

    #[test]
    fn zero_bytes_do_not_cut_a_message() {
        let (mut log, receiver) = log(true);
        log.enter("reset");
        log.event("before\0after");
        assert_eq!(receiver.try_recv().expect("a message").2, "reset: before\u{fffd}after");
    }
}
