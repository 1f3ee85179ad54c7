//! Compressed air: gas properties, orifices, the proportional valve, the pressure regulator, switching valves, hoses and the
//! chambers.

pub mod actuator;
pub mod chamber;
pub mod gas;
pub mod hose;
pub mod orifice;
pub mod regulator;
pub mod switching;
pub mod valve;
