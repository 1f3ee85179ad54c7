//! discriminant value `1000` assigned more than once

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
    /// An id that is taken.
    pub mod catalogue {
        ..builtin;
        1000 Drag "drag" OfVelocity<Drag>, "Drag";
        1000 OtherDrag "otherDrag" OfVelocity<Drag>, "The same";
    }
}

fn main() {}
