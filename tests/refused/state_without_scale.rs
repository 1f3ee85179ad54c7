//! each state needs its magnitude: `Velocity: 11, |parameters| 1.0;`

use pneumatic_servo::prelude::*;

parameters! {
    /// None.
    Parameters {}
}

states! {
    /// One without a magnitude.
    State of Parameters {
        Position: 10, |_| 1.0;
        Velocity: 11;
    }
}

fn main() {}
