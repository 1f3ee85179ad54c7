//! Mass and energy of the cylinder, and what enters it.
//!
//! ```text
//! mass   = m_A + m_B                      <- mass flows into both chambers
//! energy = U_A + U_B + m*v^2/2            <- enthalpy and heat into both chambers, work of all other forces
//! ```
//!
//! The pressures' work goes from the gas to the carriage and stays inside. With an algebraic temperature the heat is
//! whatever keeps it, so that the energy of the gas is left out, and the pressures' work enters the carriage. The gas of a
//! chamber that is open to the surroundings is not counted; its pressure is one of the outer forces.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::places::{MOST, PRESSURE_A, PRESSURE_B, of_actuator};
use super::states::{Inputs, State};
use crate::friction::FrictionLaw;
use crate::numbers::{Number, Pair, Real, Scalar};
use crate::pneumatics::actuator::Actuating;
use crate::pneumatics::chamber::Thermal;
use crate::pneumatics::gas::{GAS_CONSTANT, HEAT_RATIO};
use crate::system::QUANTITIES;

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Mass in kg and energy in J.
    pub(super) fn mass_and_energy<const N: usize>(&self, x: &[f64; N], memory: &MemoryOf<L, A>) -> [f64; QUANTITIES] {
        let x = &Real::all(x);
        let rate = self.rate(x, memory);
        let gas = self.gas(x);
        let pressure_volume = gas.pressure * self.chambers.volume(self.lengths(State::Position.get(x)));
        let mass = self.closed(pressure_volume / (gas.temperature * GAS_CONSTANT));
        let mass = if self.has_lines() { mass + self.lines.mass(&self.of_lines(x).map(Real::value)) } else { mass };
        let inner_energy = self.closed(pressure_volume) / (HEAT_RATIO - 1.0);
        let kinetic_energy = 0.5 * self.p.moving_mass * rate * rate;
        [mass, if self.has_gas_energy() { inner_energy + kinetic_energy } else { kinetic_energy }].map(Real::value)
    }

    /// Mass flow in kg/s and power in W into the cylinder.
    pub(super) fn mass_flow_and_power<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; 3],
        memory: &MemoryOf<L, A>,
    ) -> [f64; QUANTITIES] {
        let (x, u) = (&Real::all(x), &Inputs::read(&Real::all(u)));
        let rate = self.rate(x, memory);
        let gas = self.gas(x);
        // What leaks past the piston stays inside, or leaves an open chamber B.
        let (inflow, mass_flow) = if self.has_lines() {
            let flows = self.through_lines(x, u.supply_pressure, gas);
            (flows.into, flows.received)
        } else {
            let inflow = self.inflow(of_actuator(x), u.supply_pressure, gas);
            (inflow, self.closed(inflow.mass))
        };
        let enthalpy_flow = self.closed(inflow.carried) * (GAS_CONSTANT * HEAT_RATIO / (HEAT_RATIO - 1.0));
        let heat = self.closed(self.chambers.heat(gas.temperature, self.lengths(State::Position.get(x))));
        let work = self.outer_force(Real::of(time), x, u, memory) * rate;
        [mass_flow, if self.has_gas_energy() { enthalpy_flow + heat + work } else { work }].map(Real::value)
    }

    /// Force in N on the carriage that brings energy from outside.
    fn outer_force(&self, time: Real, x: &[Real], u: &Inputs<Real>, memory: &MemoryOf<L, A>) -> Real {
        let contact = self.contact(time, x, u, self.rate(x, memory));
        let friction = self.friction.force(&contact, x, &memory.friction, &mut [Real::zero(); MOST]);
        let [area_a, area_b] = self.chambers.areas;
        let gas = self.closed(Pair([x[PRESSURE_A] * area_a, -x[PRESSURE_B] * area_b]));
        contact.applied - friction - if self.has_gas_energy() { gas } else { Real::zero() }
    }

    /// Whether there are hoses or a vessel, whose mass counts, but not their energy: they exchange heat at will.
    fn has_lines(&self) -> bool {
        EXTENDED && self.lines.are_used()
    }

    /// Whether the temperatures come from the energy balance.
    fn has_gas_energy(&self) -> bool {
        matches!(self.chambers.thermal, Thermal::EnergyBalance { .. })
    }
}
