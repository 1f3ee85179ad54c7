//! A cylinder chamber: mass and energy balance of an ideal gas in a variable volume.

use super::gas::{GAS_CONSTANT, GasState, HEAT_RATIO};
use super::orifice::Flow;
use crate::scalar::Scalar;
use crate::variables::Enumeration;

/// The choice of a thermal model; ids are never reused.
pub static THERMAL_MODELS: Enumeration = Enumeration {
    name: "ThermalModel",
    description: "Thermal model of the chambers",
    items: &[
        (1, "EnergyBalance", "Energy balance with heat transfer to the wall"),
        (2, "Isothermal", "Gas always at ambient temperature"),
        (3, "Polytropic", "Temperature follows the pressure with a polytropic exponent"),
    ],
};

/// How temperature follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Thermal {
    /// From the energy balance, with a heat transfer coefficient in W/(m2 K).
    EnergyBalance {
        /// Heat transfer coefficient in W/(m2 K).
        heat_transfer: f64,
    },
    /// From the pressure by `T = T_amb*(p/p0)^((n-1)/n)`; with `n = 1` isothermal.
    Polytropic {
        /// Polytropic exponent.
        exponent: f64,
        /// Pressure `p0` in Pa at which the gas has ambient temperature.
        reference_pressure: f64,
    },
}

/// A chamber between the piston and a cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chamber {
    /// Piston area in m2.
    pub area: f64,
    /// Bore in m, for the wall area.
    pub bore: f64,
    /// Volume in m3 at length 0: dead volume, hose and tank.
    pub dead_volume: f64,
    /// Ambient temperature in K.
    pub ambient_temperature: f64,
    /// How temperature follows.
    pub thermal: Thermal,
}

/// Rates of change of a chamber's gas.
#[derive(Clone, Copy, Debug)]
pub struct ChamberRates<S> {
    /// Rate of the pressure in Pa/s.
    pub pressure: S,
    /// Rate of the temperature in K/s.
    pub temperature: S,
    /// Net mass flow in kg/s into the chamber.
    pub mass_flow: S,
}

impl Chamber {
    /// Volume in m3 at a length in m.
    pub fn volume<S: Scalar>(&self, length: S) -> S {
        length * self.area + self.dead_volume
    }

    /// Pressure and temperature, given the integrated ones: an algebraic temperature replaces the state.
    #[inline(always)]
    pub fn gas<S: Scalar>(&self, pressure: S, temperature: S) -> GasState<S> {
        match self.thermal {
            Thermal::EnergyBalance { .. } => GasState::new(pressure, temperature),
            Thermal::Polytropic { exponent, reference_pressure } => {
                let power = (exponent - 1.0) / exponent;
                let relative =
                    if power == 0.0 { S::constant(1.0) } else { (pressure / reference_pressure).powf(power) };
                GasState::new(pressure, relative * self.ambient_temperature)
            }
        }
    }

    /// Heat in W from the wall into a gas of a temperature in K, at a length in m; 0 if the temperature is algebraic.
    pub fn heat(&self, temperature: f64, length: f64) -> f64 {
        match self.thermal {
            Thermal::EnergyBalance { heat_transfer } => self.heat_flow(temperature, length, heat_transfer),
            Thermal::Polytropic { .. } => 0.0,
        }
    }

    #[inline(always)]
    fn heat_flow<S: Scalar>(&self, temperature: S, length: S, heat_transfer: f64) -> S {
        let wall = length.max(S::zero()) * (std::f64::consts::PI * self.bore) + 2.0 * self.area;
        (-temperature + self.ambient_temperature) * wall * heat_transfer
    }

    /// Rates of the gas for a length in m that changes at a rate in m/s, and flows into the chamber.
    ///
    /// ```text
    /// dm/dt = sum(mdot),   m = p*V/(R*T)
    /// d(m*c_v*T)/dt = sum(mdot*c_p*T_upstream) + h*A_w*(T_amb - T) - p*dV/dt
    /// A_w = 2*A + pi*bore*max(length, 0)
    /// ```
    #[inline(always)]
    pub fn rates<S: Scalar, const F: usize>(
        &self,
        gas: GasState<S>,
        length: S,
        length_rate: S,
        inflows: [Flow<S>; F],
    ) -> ChamberRates<S> {
        let GasState { pressure: p, temperature: t, .. } = gas;
        let (per_volume, volume_rate) = (S::constant(1.0) / self.volume(length), length_rate * self.area);
        let mut mass_flow = S::zero();
        let mut carried = S::zero(); // sum of mass flow times upstream temperature
        for flow in inflows {
            mass_flow += flow.mass;
            carried += flow.mass * flow.temperature;
        }
        match self.thermal {
            Thermal::EnergyBalance { heat_transfer } => {
                let heat = self.heat_flow(t, length, heat_transfer);
                let work = p * volume_rate;
                let energy = carried * (HEAT_RATIO * GAS_CONSTANT) + heat * (HEAT_RATIO - 1.0) - work * HEAT_RATIO;
                let pressure = energy * per_volume;
                let density_growth = (mass_flow * t * GAS_CONSTANT - work) * per_volume;
                ChamberRates { pressure, temperature: t * (pressure - density_growth) / p, mass_flow }
            }
            Thermal::Polytropic { exponent, .. } => {
                let pressure = (mass_flow * t * GAS_CONSTANT - p * volume_rate) * exponent * per_volume;
                let temperature = t * pressure / p * ((exponent - 1.0) / exponent);
                ChamberRates { pressure, temperature, mass_flow }
            }
        }
    }
}
