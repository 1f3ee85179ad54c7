//! Dry air as an ideal gas.

use crate::scalar::Scalar;

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
    /// Density in kg/m3 that turns sonic conductance times pressure into the choked mass flow of this gas.
    pub sonic_density: S,
}

impl<S: Scalar> GasState<S> {
    /// A gas of given absolute pressure in Pa and temperature in K.
    pub fn new(pressure: S, temperature: S) -> Self {
        let sonic_density = (S::constant(REFERENCE_TEMPERATURE) / temperature).sqrt() * REFERENCE_DENSITY;
        Self { pressure, temperature, sonic_density }
    }
}

/// A reservoir of constant temperature and given pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reservoir {
    temperature: f64,
    sonic_density: f64,
}

impl Reservoir {
    /// A reservoir at a temperature in K.
    pub fn new(temperature: f64) -> Self {
        let GasState { sonic_density, .. } = GasState::new(0.0, temperature);
        Self { temperature, sonic_density }
    }

    /// Its gas at an absolute pressure in Pa.
    pub fn at<S: Scalar>(&self, pressure: S) -> GasState<S> {
        let [temperature, sonic_density] = [self.temperature, self.sonic_density].map(S::constant);
        GasState { pressure, temperature, sonic_density }
    }
}
