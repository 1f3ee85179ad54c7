//! the name `LuGre` is defined multiple times

use pneumatic_servo::prelude::*;

laws! {
    /// A name that is taken.
    pub mod catalogue {
        ..builtin;
        1000 LuGre "mine" OfVelocity<builtin::none::NoFriction>, "Another one";
    }
}

fn main() {}
