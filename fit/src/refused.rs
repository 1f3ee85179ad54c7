//! Data or choices that cannot be used.

use std::fmt;

use pneumatic_servo::model::SettingError;

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
