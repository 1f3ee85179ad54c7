//! Compressed air: gas properties, orifices, proportional valves, pressure regulators, switching valves, hoses and the chambers.

mod actuation;
pub mod actuator;
pub(crate) mod chamber;
pub mod gas;
pub(crate) mod hose;
mod lag;
pub mod orifice;
#[doc(hidden)]
pub mod regulator;
#[doc(hidden)]
pub mod switching;
#[doc(hidden)]
pub mod two_regulators;
#[doc(hidden)]
pub mod two_valves;
#[doc(hidden)]
pub mod valve;
