//! expected `f64`, found `Tangent`

use pneumatic_servo::prelude::*;

parameters! {
    /// A law with a parameter that may vary.
    Damper {
        share: Tunable = Variable::parameter(0, "b", units::ONE, 0.25).range(0.0, 1.0).text("Share");
    }
}

impl VelocityLaw for Damper {
    fn force<S: Scalar>(&self, velocity: S, level: S) -> S {
        velocity * level * S::constant(1.0 - self.share)
    }
}

fn main() {}
