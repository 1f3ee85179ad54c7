//! Compressed air: gas properties, orifices, the proportional valve, the pressure regulator and the chambers.

pub mod actuator;
pub mod chamber;
pub mod gas;
pub mod orifice;
pub mod regulator;
pub mod valve;
