//! Data or choices that cannot be used.

use std::fmt;

use pneumatic_servo::model::SettingError;

use crate::problem::Interrupted;

/// A refusal in words for the user: which data or choice, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl From<SettingError> for Refused {
    fn from(error: SettingError) -> Self {
        Self(error.to_string())
    }
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoAnswer {
    /// Data or choices that cannot be used.
    Refused(Refused),
    /// Somebody has asked to stop.
    Interrupted,
}

impl From<Refused> for NoAnswer {
    fn from(refused: Refused) -> Self {
        Self::Refused(refused)
    }
}

impl From<Interrupted> for NoAnswer {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}
