//! Numbers in a memory that say a side or a direction, and nothing else: +1, -1, or 0 where there is none.
//!
//! They change at events in jumps, so that no small change leads from one to another: a linear map of a run leaves them out. They
//! are saved as plain numbers.
//!
//! ```
//! use pneumatic_servo::system::side;
//! # use pneumatic_servo::serde;
//!
//! /// What the wheel does.
//! #[derive(serde::Serialize, serde::Deserialize)]
//! # #[serde(crate = "pneumatic_servo::serde")]
//! enum Wheel {
//!     Stands,
//!     Turns(#[serde(with = "side")] f64),
//! }
//! ```

use serde::{Deserialize, Deserializer, Serializer};

/// What such a number is called where it is saved; nothing of it is written.
pub(crate) const NAME: &str = "side of a hybrid system";

/// Saves a number.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<S: Serializer>(side: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_newtype_struct(NAME, side)
}

/// Reads it again.
///
/// # Errors
/// Those of the deserializer.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    f64::deserialize(deserializer)
}
