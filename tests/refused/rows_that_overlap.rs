//! two states have the same value reference

use pneumatic_servo::prelude::*;

parameters! {
    /// None.
    Parameters {}
}

states! {
    /// A row that ends behind the begin of the next one.
    State of Parameters {
        Position[3 step 2]: 10, |_| 1.0;
        Velocity[3 step 2]: 14, |_| 1.0;
    }
}

fn main() {}
