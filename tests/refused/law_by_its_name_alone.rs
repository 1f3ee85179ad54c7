//! a `VelocityLaw` is an `OfVelocity<Drag>`

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
    /// The kind of the law is missing.
    pub mod catalogue {
        ..builtin;
        1000 Drag "drag" Drag, "Drag";
    }
}

fn main() {}
