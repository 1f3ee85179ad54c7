//! Warnings: accepted values that are unusual.

use std::fmt;

/// A value that is accepted, but probably a mistake of its user. The runner of the model may report it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notice {
    /// Variable with the value, or an expression of several.
    pub variable: &'static str,
    /// The value.
    pub value: f64,
    /// Consequence in the model, and remedy.
    pub remark: &'static str,
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: {}", self.variable, self.value, self.remark)
    }
}

/// The notices of a running model, each in a place of its own.
pub type Notices = [Option<Notice>; 3];
