//! the actuators of the library join by the line `..builtin;`, not by `..builtins`

use pneumatic_servo::prelude::*;

actuators! {
    /// The name of the catalogue has a letter too many.
    pub mod catalogue {
        ..builtins;
    }
}

fn main() {}
