//! the id 999 of Drag is the library's: your own begin at 1000

use pneumatic_servo::prelude::*;

parameters! {
    /// Friction in proportion to velocity.
    Drag {
        damping: Tunable = Variable::parameter(0, "d", units::NEWTON_SECOND_PER_METRE, 5.0).text("Damping");
    }
}

impl VelocityLaw for Drag {
    fn force<S: Scalar>(&self, v: S, level: S) -> S {
        v * level * self.damping
    }
}

laws! {
    /// An id that a later version of the library may take.
    pub mod catalogue {
        ..builtin;
        999 Drag "drag" OfVelocity<Drag>, "Drag";
    }
}

fn main() {}
