//! Refusals of calls of the page.

use std::fmt;

use pneumatic_servo::model::SettingError;
use pneumatic_servo::solver::StepError;
use pneumatic_servo::variables::ParameterError;

/// A call that is refused.
#[derive(Clone, Debug, PartialEq)]
pub enum CallError {
    /// There is nothing of that number.
    NoSuch {
        /// Requested thing.
        what: &'static str,
        /// Its number.
        number: f64,
    },
    /// More numbers than the buffer has.
    TooMany {
        /// Their number.
        count: usize,
    },
    /// Bytes that are no text.
    NoText,
    /// A step that ends at no time, or in the past.
    Time {
        /// The end asked for.
        end: f64,
    },
    /// The plant refuses a value.
    Setting(SettingError),
    /// The solver cannot reach the end of a step.
    Step(StepError),
}

impl fmt::Display for CallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuch { what, number } => write!(f, "there is no {what} {number}"),
            Self::TooMany { count } => write!(f, "{count} numbers are more than the buffer has"),
            Self::NoText => write!(f, "the texts are not UTF-8"),
            Self::Time { end } => write!(f, "a step cannot end at t = {end} s: it must be a time that is not past"),
            Self::Setting(error) => error.fmt(f),
            Self::Step(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for CallError {}

impl From<SettingError> for CallError {
    fn from(error: SettingError) -> Self {
        Self::Setting(error)
    }
}

impl From<ParameterError> for CallError {
    fn from(error: ParameterError) -> Self {
        Self::Setting(error.into())
    }
}

impl From<StepError> for CallError {
    fn from(error: StepError) -> Self {
        Self::Step(error)
    }
}
