//! Friction laws of your own, one of each kind. In one line each they join the laws of the library, and the cylinder and the
//! friction bench have them all.

mod hyperbolic_stribeck;
mod lagged_bristle;
mod loaded_dahl;
mod rate_and_state;
mod rooted_coulomb;
mod two_bristles;
mod warm_bristle;

use pneumatic_servo::models::{friction_bench, pneumatic_servo_cylinder};
use pneumatic_servo::pneumatics::actuator::Actuator;
use pneumatic_servo::prelude::*;

laws! {
    /// The laws of the library and seven more.
    pub mod catalogue {
        ..builtin;
        1000 HyperbolicStribeck "hyperbolicStribeck" StickSlip<hyperbolic_stribeck::HyperbolicStribeck>,
            "Hyperbolic Stribeck curve with true stiction";
        1001 LoadedDahl "loadedDahl" OneBristle<loaded_dahl::LoadedDahl>,
            "Dahl's bristle with a stiffness in proportion to the load";
        1002 RootedCoulomb "rootedCoulomb" OfVelocity<rooted_coulomb::RootedCoulomb>,
            "Coulomb friction smoothed by a root (creeps)";
        1003 TwoBristles "twoBristles" two_bristles::TwoBristles, "Two of Dahl's bristles side by side";
        1004 LaggedBristle "laggedBristle" lagged_bristle::LaggedBristle, "Dahl's bristle behind a film that lags";
        1005 RateAndState "rateAndState" rate_and_state::RateAndState, "Rate-and-state friction with the ageing law";
        1006 WarmBristle "warmBristle" warm_bristle::WarmBristle, "Dahl's bristle that softens as it warms";
    }
}

/// The cylinder with all these laws.
pub const CYLINDER: Model = pneumatic_servo_cylinder::model::<catalogue::Friction, Actuator>();

/// The friction bench with all these laws.
pub const BENCH: Model = friction_bench::model::<catalogue::Friction>();

#[cfg(feature = "python")]
pneumatic_servo_python::python_module!(own_law, &[&CYLINDER, &BENCH]);
