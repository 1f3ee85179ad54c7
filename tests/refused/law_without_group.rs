//! each line of `laws!` has an id, a name, the group of the parameters, the type and one sentence

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
    /// The group of the parameters is missing.
    pub mod catalogue {
        ..builtin;
        1000 Drag OfVelocity<Drag>, "Drag";
    }
}

fn main() {}
