//! Dry air as an ideal gas.

use crate::numbers::{Number, Pair, Scalar};
use crate::variables::Tunable;

/// Specific gas constant in J/(kg K).
pub const GAS_CONSTANT: f64 = 287.05;

/// Ratio of the specific heats.
pub const HEAT_RATIO: f64 = 1.4;

/// Density in kg/m3 at the reference conditions of ISO 6358 and ISO 8778.
pub const REFERENCE_DENSITY: f64 = 1.185;

/// Temperature in K of the reference conditions.
pub const REFERENCE_TEMPERATURE: f64 = 293.15;

/// Pressure in Pa below which solvers outside are led back: no run of a cylinder comes near it, nor does air stay a gas.
pub const THINNEST: f64 = 1.0;

/// Temperature in K of the same kind.
pub const COLDEST: f64 = 1.0;

/// Pressure and temperature of a gas.
#[derive(Clone, Copy, Debug)]
pub struct GasState<N> {
    /// Absolute pressure in Pa.
    pub pressure: N,
    /// Temperature in K.
    pub temperature: N,
    /// Density in kg/m3 that turns sonic conductance times pressure into the choked mass flow of this gas.
    pub sonic_density: N,
}

impl<N: Number> GasState<N> {
    /// A gas of given absolute pressure in Pa and temperature in K.
    pub fn new(pressure: N, temperature: N) -> Self {
        // rho0*sqrt(T0/T)
        const NUMERATOR: f64 = REFERENCE_DENSITY * REFERENCE_DENSITY * REFERENCE_TEMPERATURE;
        let sonic_density = (N::constant(NUMERATOR) / temperature).sqrt();
        Self { pressure, temperature, sonic_density }
    }

    /// The same in other numbers.
    #[inline(always)]
    pub fn map<M>(self, rule: impl Fn(N) -> M) -> GasState<M> {
        let Self { pressure, temperature, sonic_density } = self;
        GasState { pressure: rule(pressure), temperature: rule(temperature), sonic_density: rule(sonic_density) }
    }
}

impl<S: Scalar> GasState<Pair<S>> {
    /// One of two gases side by side.
    pub fn side(self, side: usize) -> GasState<S> {
        self.map(|Pair(both)| both[side])
    }
}

/// A reservoir of constant temperature and given pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reservoir {
    temperature: Tunable,
    sonic_density: Tunable,
}

impl Reservoir {
    /// A reservoir at a temperature in K.
    pub fn new(temperature: Tunable) -> Self {
        let GasState { sonic_density, .. } = GasState::new(Tunable::zero(), temperature);
        Self { temperature, sonic_density }
    }

    /// Its gas at an absolute pressure in Pa.
    pub fn at<N: Number>(&self, pressure: N) -> GasState<N> {
        let [temperature, sonic_density] = [self.temperature, self.sonic_density].map(N::tuned);
        GasState { pressure, temperature, sonic_density }
    }
}
