//! Errors of refused values.

use std::fmt;

/// A parameter or input that cannot be accepted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ParameterError {
    /// Name of the variable.
    pub variable: String,
    /// The refused value.
    pub value: f64,
    /// Requirement that is not met.
    pub reason: String,
}

impl ParameterError {
    /// An error for a variable of a group; [`ParameterError::within`] completes its name.
    pub fn new(variable: &str, value: f64, reason: &str) -> Self {
        Self { variable: variable.to_owned(), value, reason: reason.to_owned() }
    }

    /// Puts the name of the variable into its group.
    pub fn within(self, group: &str) -> Self {
        Self { variable: format!("{group}.{}", self.variable), ..self }
    }
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {} is refused: {}", self.variable, self.value, self.reason)
    }
}

impl std::error::Error for ParameterError {}
