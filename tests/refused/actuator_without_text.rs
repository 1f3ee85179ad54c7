//! each line of `actuators!` has an id, a name, the type and one sentence

use pneumatic_servo::prelude::*;

actuators! {
    /// The sentence is missing.
    pub mod catalogue {
        ..builtin;
        1000 Other valve::ProportionalValve;
    }
}

fn main() {}
