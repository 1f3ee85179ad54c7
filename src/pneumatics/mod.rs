//! Compressed air: gas properties, orifices, the proportional valve, the pressure regulator, switching valves, hoses and the
//! chambers.

mod actuating;
pub mod actuator;
#[doc(hidden)]
pub mod chamber;
pub mod gas;
#[doc(hidden)]
pub mod hose;
pub mod orifice;
#[doc(hidden)]
pub mod regulator;
#[doc(hidden)]
pub mod switching;
#[doc(hidden)]
pub mod valve;
