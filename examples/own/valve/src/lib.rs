//! An actuator of your own: a pair of 3/2 proportional valves, one for each chamber. In one line it joins the actuators of
//! the library, and the cylinder has it.

mod pair;

use pneumatic_servo::friction::Friction;
use pneumatic_servo::models::pneumatic_servo_cylinder;
use pneumatic_servo::prelude::*;

actuators! {
    /// The actuators of the library and a pair of valves.
    pub mod catalogue {
        ..builtin;
        1000 ValvePair pair::ValvePair, "Two 3/2 proportional valves, one for each chamber, on one voltage";
    }
}

/// The cylinder with all these actuators.
pub const CYLINDER: Model = pneumatic_servo_cylinder::model::<Friction, catalogue::Actuator>();
