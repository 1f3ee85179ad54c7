//! Mass and energy of the cylinder, and what enters it.
//!
//! ```text
//! mass   = m_A + m_B                      <- mass flows into both chambers
//! energy = U_A + U_B + m*v^2/2            <- enthalpy and heat into both chambers, work of all other forces
//! ```
//!
//! The pressures' work goes from the gas to the carriage and stays inside. With an algebraic temperature the heat is
//! whatever keeps it, so that the energy of the gas is left out, and the pressures' work enters the carriage.

use super::variables::{Inputs, State};
use super::{Memory, PRESSURE_A, PRESSURE_B, PneumaticServoCylinder};
use crate::hybrid::QUANTITIES;
use crate::pneumatics::actuator::FLOW;
use crate::pneumatics::chamber::Thermal;
use crate::pneumatics::gas::{GAS_CONSTANT, HEAT_RATIO};

impl PneumaticServoCylinder {
    /// Mass in kg and energy in J.
    pub(super) fn mass_and_energy<const N: usize>(&self, x: &[f64; N], memory: &Memory) -> [f64; QUANTITIES] {
        let rate = self.rate(x, memory);
        let gas = self.gas(x);
        let pressure_volume = gas.pressure * self.chambers.volume(self.lengths(x[State::Position.at(N)]));
        let mass = (pressure_volume / (gas.temperature * GAS_CONSTANT)).sum();
        let inner_energy = pressure_volume.sum() / (HEAT_RATIO - 1.0);
        let kinetic_energy = 0.5 * self.p.moving_mass * rate * rate;
        [mass, if self.has_gas_energy() { inner_energy + kinetic_energy } else { kinetic_energy }]
    }

    /// Mass flow in kg/s and power in W into the cylinder.
    pub(super) fn mass_flow_and_power<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &Inputs<f64>,
        memory: &Memory,
    ) -> [f64; QUANTITIES] {
        let rate = self.rate(x, memory);
        let gas = self.gas(x);
        // What leaks past the piston stays inside.
        let inflow = self.feed(x[FLOW], u.supply_pressure, gas);
        let mass_flow = inflow.mass.sum();
        let enthalpy_flow = inflow.carried.sum() * (GAS_CONSTANT * HEAT_RATIO / (HEAT_RATIO - 1.0));
        let heat = self.chambers.heat(gas.temperature, self.lengths(x[State::Position.at(N)])).sum();
        let work = self.outer_force(time, x, u, memory) * rate;
        [mass_flow, if self.has_gas_energy() { enthalpy_flow + heat + work } else { work }]
    }

    /// Force in N on the carriage that brings energy from outside.
    fn outer_force<const N: usize>(&self, time: f64, x: &[f64; N], u: &Inputs<f64>, memory: &Memory) -> f64 {
        let contact = self.contact(time, x, u, self.rate(x, memory));
        let friction = self.friction.force(&contact, x, &memory.friction, &mut [0.0; N]);
        let [area_a, area_b] = self.chambers.areas;
        let gas = x[PRESSURE_A] * area_a - x[PRESSURE_B] * area_b;
        contact.applied - friction - if self.has_gas_energy() { gas } else { 0.0 }
    }

    /// Whether the temperatures come from the energy balance.
    fn has_gas_energy(&self) -> bool {
        matches!(self.chambers.thermal, Thermal::EnergyBalance { .. })
    }
}
