//! A cylinder with one friction law and one actuator, which fits into a microcontroller.

use pneumatic_servo::models::pneumatic_servo_cylinder::{self, PneumaticServoCylinder};
use pneumatic_servo::pneumatics::valve::ProportionalValve;
use pneumatic_servo::prelude::*;

#[cfg(not(any(feature = "gms", feature = "stribeck")))]
laws! {
    /// LuGre alone.
    pub mod law {
        1000 LuGre "lugre" OneBristle<builtin::lugre::LuGre>, "Bristle with presliding, Stribeck effect and frictional lag";
    }
}

#[cfg(feature = "stribeck")]
laws! {
    /// Stribeck alone.
    pub mod law {
        1000 Stribeck "stribeck" builtin::stribeck_law::Stribeck, "Stribeck curve with true stiction";
    }
}

#[cfg(feature = "gms")]
laws! {
    /// GMS alone.
    pub mod law {
        1000 GMS "gms" builtin::gms::Gms, "Maxwell-slip elements with Stribeck effect, frictional lag and non-local memory";
    }
}

actuators! {
    /// The proportional valve alone.
    pub mod actuator {
        1000 ProportionalValve ProportionalValve, "5/3 proportional valve between supply and both chambers";
    }
}

/// The cylinder without hoses, sensors and other options, which are refused.
pub type Cylinder = PneumaticServoCylinder<law::Friction, actuator::Actuator>;

/// Its variables.
pub const CYLINDER: Model = pneumatic_servo_cylinder::model::<law::Friction, actuator::Actuator>();

/// States of the friction law: bristles, or elements.
const OF_FRICTION: usize = if cfg!(feature = "stribeck") {
    0
} else if cfg!(feature = "gms") {
    10
} else {
    1
};

/// States of the spool (2), temperatures and pressures (4), position and velocity (2), and of the friction law.
pub const STATES: usize = 8 + OF_FRICTION;

pneumatic_servo_loop::export_loop!(pneumatic_servo_loop::begin::<Cylinder, STATES, 3>);
