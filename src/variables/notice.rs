//! Warnings: accepted values that are unusual.

use std::fmt;

/// A value that is accepted, but hardly means what its user thinks. Whoever runs the model may pass it on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notice {
    /// What has the value: a variable, or what is made of some.
    pub variable: &'static str,
    /// The value.
    pub value: f64,
    /// What the model makes of it, and what to do.
    pub remark: &'static str,
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: {}", self.variable, self.value, self.remark)
    }
}

/// The notices of a running model, each in a place of its own.
pub type Notices = [Option<Notice>; 2];
