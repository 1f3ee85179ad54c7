//! Dry air as an ideal gas.

/// Specific gas constant in J/(kg K).
pub const GAS_CONSTANT: f64 = 287.05;

/// Ratio of the specific heats.
pub const HEAT_RATIO: f64 = 1.4;

/// Density in kg/m3 at the reference conditions of ISO 6358 and ISO 8778.
pub const REFERENCE_DENSITY: f64 = 1.185;

/// Temperature in K of the reference conditions.
pub const REFERENCE_TEMPERATURE: f64 = 293.15;

/// Pressure and temperature of a gas.
#[derive(Clone, Copy, Debug)]
pub struct GasState<S> {
    /// Absolute pressure in Pa.
    pub pressure: S,
    /// Temperature in K.
    pub temperature: S,
}
