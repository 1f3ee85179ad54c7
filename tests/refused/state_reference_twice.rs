//! two states have the same value reference

use pneumatic_servo::prelude::*;

parameters! {
    /// None.
    Parameters {}
}

states! {
    /// Two states with one value reference.
    State of Parameters {
        Position: 10, |_| 1.0;
        Velocity: 10, |_| 1.0;
    }
}

fn main() {}
