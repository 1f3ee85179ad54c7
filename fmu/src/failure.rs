//! Failures of a call: the status that it returns and the message that it logs.

use pneumatic_servo::variables::ParameterError;

/// Status of a call, numbered alike in all versions of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// All is well.
    Ok,
    /// Unusual, but carried out.
    Warning,
    /// Not carried out to the end.
    Discard,
    /// Refused.
    Error,
    /// The instance is lost.
    Fatal,
}

/// The outcome of a call that did not succeed.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Status that the call returns.
    pub status: Status,
    /// Message that it logs.
    pub message: String,
}

impl Failure {
    /// The call cannot be carried out; it has changed nothing.
    pub fn error(message: impl Into<String>) -> Self {
        Self { status: Status::Error, message: message.into() }
    }

    /// A step could not be completed, or a status is not available.
    pub fn discard(message: impl Into<String>) -> Self {
        Self { status: Status::Discard, message: message.into() }
    }

    /// The instance is lost.
    pub fn fatal(message: impl Into<String>) -> Self {
        Self { status: Status::Fatal, message: message.into() }
    }
}

impl From<ParameterError> for Failure {
    fn from(error: ParameterError) -> Self {
        Self::error(error.to_string())
    }
}
