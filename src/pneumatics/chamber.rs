//! The chambers of a cylinder: mass and energy balances of an ideal gas in two variable volumes.

use std::f64::consts::PI;

use super::gas::{Gas, GasState};
use super::orifice::Inflow;
use crate::enumeration;
use crate::numbers::{Number, Pair, Scalar, Tangent, Tangents};
use crate::variables::Tunable;

enumeration! {
    /// The choice of a thermal model; ids are never reused.
    ThermalModel "ThermalModel": "Thermal model of the chambers" {
        1 EnergyBalance: "Energy balance with heat transfer to the wall";
        2 Isothermal: "Gas always at ambient temperature";
        3 Polytropic: "Temperature follows the pressure with a polytropic exponent";
        4 PolytropicServo: "Pressure follows flow and motion with a polytropic exponent at ambient temperature: usual in servo design";
    }
}

/// Thermal model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Thermal {
    /// From the energy balance, with a heat transfer coefficient in W/(m2 K).
    EnergyBalance {
        /// Heat transfer coefficient in W/(m2 K).
        heat_transfer: Tunable,
    },
    /// From the pressure by `T = T_amb*(p/p0)^((n-1)/n)`; with `n = 1` isothermal.
    Polytropic {
        /// Polytropic exponent.
        exponent: Tangent,
        /// Pressures `p0` in Pa at which the gas has ambient temperature.
        reference_pressures: Tangents,
    },
    /// Ambient always, while the pressure answers flow and motion with a factor `n`:
    /// `dp/dt = n/V*(R*sum(T_upstream*mdot) - p*dV/dt)`. The usual model of servo design, where the exponent stands for
    /// the heat that the wall exchanges; unless `n` is 1 it keeps no account of the mass. Where `Polytropic` ties the
    /// temperature to the pressure for ever, even in a chamber that stands still, this one has forgotten it.
    PolytropicServo {
        /// Polytropic exponent.
        exponent: Tangent,
    },
}

/// Wall in m2 of a tank of a volume in m3: a closed cylinder twice as long as wide.
pub fn tank_wall(volume: Tangent) -> Tangent {
    let cube = 2.0 * volume / PI;
    let root = libm::cbrt(cube.value);
    let diameter = cube.chain(root, if root > 0.0 { 1.0 / (3.0 * root * root) } else { 0.0 });
    2.5 * PI * diameter * diameter
}

/// The chambers between the piston and the covers; their equations are the same, and evaluated side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chambers {
    /// Piston areas in m2.
    pub areas: Tangents,
    /// Bore in m, for the wall area.
    pub bore: Tangent,
    /// Volumes in m3 at length 0: dead volume, hose and tank.
    pub dead_volumes: Tangents,
    /// Wall areas in m2 at length 0: both covers, and a tank.
    pub walls: Tangents,
    /// Ambient temperature in K.
    pub ambient_temperature: Tangent,
    /// Thermal model.
    pub thermal: Thermal,
}

/// Rates of change of the gas.
#[derive(Clone, Copy, Debug)]
pub struct ChamberRates<N> {
    /// Rate of the pressure in Pa/s.
    pub pressure: N,
    /// Rate of the temperature in K/s.
    pub temperature: N,
    /// Net mass flow in kg/s into the chamber.
    pub mass_flow: N,
}

impl Chambers {
    /// Volumes in m3 at lengths in m.
    pub fn volume<S: Scalar>(&self, length: Pair<S>) -> Pair<S> {
        length * self.areas + self.dead_volumes
    }

    /// State of a gas, given the integrated pressure and temperature: an algebraic temperature replaces the state.
    #[inline(always)]
    pub fn gas<S: Scalar>(&self, gas: &Gas, pressure: Pair<S>, temperature: Pair<S>) -> GasState<Pair<S>> {
        match self.thermal {
            Thermal::EnergyBalance { .. } => gas.at(pressure, temperature),
            Thermal::PolytropicServo { .. } => gas.at(pressure, Pair::tuned(self.ambient_temperature)),
            Thermal::Polytropic { exponent, reference_pressures } => {
                let power = (exponent - 1.0) / exponent;
                let relative =
                    if power.is_used() { (pressure / reference_pressures).pow(power) } else { Pair::constant(1.0) };
                gas.at(pressure, relative * self.ambient_temperature)
            }
        }
    }

    /// Heat in W from the wall into gases of temperatures in K, at lengths in m; 0 if the temperature is algebraic.
    pub fn heat<S: Scalar>(&self, temperature: Pair<S>, length: Pair<S>) -> Pair<S> {
        match self.thermal {
            Thermal::EnergyBalance { heat_transfer } => self.heat_flow(temperature, length, heat_transfer),
            Thermal::Polytropic { .. } | Thermal::PolytropicServo { .. } => Pair::zero(),
        }
    }

    #[inline(always)]
    fn heat_flow<S: Scalar>(&self, temperature: Pair<S>, length: Pair<S>, heat_transfer: Tunable) -> Pair<S> {
        // At length 0, where a piston starts at its stop, the derivative is the one towards a growing length.
        let wall = length.max(Pair::zero()) * (PI * self.bore) + self.walls;
        (-temperature + self.ambient_temperature) * wall * heat_transfer
    }

    /// Rates of the gas for lengths in m that change at rates in m/s, and the flow into the chambers.
    ///
    /// ```text
    /// dm/dt = sum(mdot),   m = p*V/(R*T)
    /// d(m*c_v*T)/dt = sum(mdot*c_p*T_upstream) + h*A_w*(T_amb - T) - p*dV/dt
    /// A_w = 2*A + A_tank + pi*bore*max(length, 0)
    /// ```
    #[inline(always)]
    pub fn rates<S: Scalar>(
        &self,
        &Gas { constant, heat_ratio, .. }: &Gas,
        gas: GasState<Pair<S>>,
        length: Pair<S>,
        length_rate: Pair<S>,
        inflow: Inflow<Pair<S>>,
    ) -> ChamberRates<Pair<S>> {
        let GasState { pressure: p, temperature: t, .. } = gas;
        let Inflow { mass: mass_flow, carried } = inflow;
        let (per_volume, volume_rate) = (Pair::constant(1.0) / self.volume(length), length_rate * self.areas);
        match self.thermal {
            Thermal::EnergyBalance { heat_transfer } => {
                let heat = self.heat_flow(t, length, heat_transfer);
                let work = p * volume_rate;
                let energy = carried * (heat_ratio * constant) + heat * (heat_ratio - 1.0) - work * heat_ratio;
                let pressure = energy * per_volume;
                let density_growth = (mass_flow * t * constant - work) * per_volume;
                ChamberRates { pressure, temperature: (pressure - density_growth) * (t / p), mass_flow }
            }
            Thermal::Polytropic { exponent, .. } => {
                let pressure = (mass_flow * t * constant - p * volume_rate) * exponent * per_volume;
                let temperature = pressure * (t / p) * ((exponent - 1.0) / exponent);
                ChamberRates { pressure, temperature, mass_flow }
            }
            Thermal::PolytropicServo { exponent } => {
                let pressure = (carried * constant - p * volume_rate) * exponent * per_volume;
                ChamberRates { pressure, temperature: Pair::zero(), mass_flow }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    /// A litre in a cylinder of 86 mm by 172 mm has a wall of 581 cm2, through which it takes up heat at any length.
    #[test]
    fn tank_has_a_wall() {
        let diameter: f64 = 0.086_025_4;
        assert!((PI / 4.0 * diameter * diameter * 2.0 * diameter - 1e-3).abs() < 1e-8);
        let wall = PI * diameter * 2.0 * diameter + 2.0 * PI / 4.0 * diameter * diameter;
        let tank = tank_wall(Tangent::still(1e-3)).value;
        assert!((tank - wall).abs() < 1e-6 * wall, "{tank} m2");
        assert_eq!(tank_wall(Tangent::still(0.0)), 0.0);
        let chambers = Chambers {
            areas: [2e-4; 2].map(Tangent::still).into(),
            bore: Tangent::still(0.016),
            dead_volumes: [5e-6, 5e-6 + 1e-3].map(Tangent::still).into(),
            walls: [4e-4, 4e-4 + tank].map(Tangent::still).into(),
            ambient_temperature: Tangent::still(293.15),
            thermal: Thermal::EnergyBalance { heat_transfer: Tunable::still(60.0) },
        };
        let Pair([without, with]) = chambers.heat(Pair([Real::of(283.15); 2]), Pair([Real::of(0.1); 2]));
        let [with, without] = [with, without].map(Real::value);
        assert!((with - without - 60.0 * wall * 10.0).abs() < 1e-4, "{with} W and {without} W");
    }
}
