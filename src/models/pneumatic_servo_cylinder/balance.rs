//! Mass and energy of the cylinder, and what enters it.
//!
//! ```text
//! mass   = m_A + m_B                      <- mass flows into both chambers
//! energy = U_A + U_B + m*v^2/2            <- enthalpy and heat into both chambers, work of all other forces
//! ```
//!
//! The pressures' work goes from the gas to the carriage and stays inside. With an algebraic temperature the heat is
//! whatever keeps it, so that the energy of the gas is left out, and the pressures' work enters the carriage.

use super::{BRISTLES, ChamberState, Memory, PRESSURE_A, PRESSURE_B, PneumaticServoCylinder, Side};
use crate::friction;
use crate::pneumatics::chamber::{Chamber, Thermal};
use crate::pneumatics::gas::{GAS_CONSTANT, HEAT_RATIO};
use crate::solver::QUANTITIES;

impl PneumaticServoCylinder {
    /// Mass in kg and energy in J.
    pub(super) fn mass_and_energy<const N: usize>(&self, x: &[f64; N], memory: &Memory) -> [f64; QUANTITIES] {
        let rate = self.rate(x, memory);
        let (mut mass, mut inner_energy) = (0.0, 0.0);
        for side in [Side::A, Side::B] {
            let ChamberState { pressure, temperature, position, .. } = Self::chamber_state(side, x, rate);
            let (chamber, length) = self.chamber(side, position);
            let gas = chamber.gas(pressure, temperature);
            let pressure_volume = gas.pressure * chamber.volume(length);
            mass += pressure_volume / (GAS_CONSTANT * gas.temperature);
            inner_energy += pressure_volume / (HEAT_RATIO - 1.0);
        }
        let kinetic_energy = 0.5 * self.p.moving_mass * rate * rate;
        [mass, if self.has_gas_energy() { inner_energy + kinetic_energy } else { kinetic_energy }]
    }

    /// Mass flow in kg/s and power in W into the cylinder.
    pub(super) fn mass_flow_and_power<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &Memory,
    ) -> [f64; QUANTITIES] {
        let rate = self.rate(x, memory);
        let (mut mass_flow, mut enthalpy_flow, mut heat) = (0.0, 0.0, 0.0);
        for side in [Side::A, Side::B] {
            let ChamberState { actuator, pressure, temperature, position, .. } = Self::chamber_state(side, x, rate);
            let (chamber, length) = self.chamber(side, position);
            let gas = chamber.gas(pressure, temperature);
            // What leaks past the piston stays inside.
            for flow in self.feed(side, actuator, u[2], gas) {
                mass_flow += flow.mass;
                enthalpy_flow += flow.mass * flow.temperature * (GAS_CONSTANT * HEAT_RATIO / (HEAT_RATIO - 1.0));
            }
            heat += chamber.heat(gas.temperature, length);
        }
        let work = self.outer_force(time, x, u, memory) * rate;
        [mass_flow, if self.has_gas_energy() { enthalpy_flow + heat + work } else { work }]
    }

    /// Force in N on the carriage that brings energy from outside.
    fn outer_force<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &Memory) -> f64 {
        let contact = self.contact(time, x, u, self.rate(x, memory));
        let mut rates = [0.0; friction::MAX_STATES];
        let bristles = &x[BRISTLES..BRISTLES + self.bristles];
        let friction = self.friction.force(&contact, bristles, &memory.friction, &mut rates[..self.bristles]);
        let gas = x[PRESSURE_A] * self.chamber_a.area - x[PRESSURE_B] * self.chamber_b.area;
        contact.applied - friction - if self.has_gas_energy() { gas } else { 0.0 }
    }

    /// A chamber and its length in m.
    fn chamber(&self, side: Side, position: f64) -> (&Chamber, f64) {
        match side {
            Side::A => (&self.chamber_a, position),
            Side::B => (&self.chamber_b, self.p.stroke - position),
        }
    }

    /// Whether the temperatures come from the energy balance.
    fn has_gas_energy(&self) -> bool {
        matches!(self.chamber_a.thermal, Thermal::EnergyBalance { .. })
    }
}
