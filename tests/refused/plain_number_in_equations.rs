//! `f64` is no number of the equations

use pneumatic_servo::prelude::*;

parameters! {
    /// A law with a parameter that may vary.
    Damper {
        share: Tunable = Variable::parameter(0, "b", units::ONE, 0.25).range(0.0, 1.0).text("Share");
    }
}

impl VelocityLaw for Damper {
    fn force<S: Scalar>(&self, velocity: S, level: S) -> S {
        velocity * level * (1.0 - self.share)
    }
}

/// Its force in plain numbers, in which a slope would be lost.
fn plain(law: &Damper) -> f64 {
    law.force(0.1_f64, 1.0_f64)
}

fn main() {
    let _ = plain;
}
