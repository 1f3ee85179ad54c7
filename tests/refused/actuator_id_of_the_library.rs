//! the id 4 of Other is the library's: your own begin at 1000

use pneumatic_servo::prelude::*;

actuators! {
    /// An id that a later version of the library may take.
    pub mod catalogue {
        ..builtin;
        4 Other valve::ProportionalValve, "The same valve";
    }
}

fn main() {}
