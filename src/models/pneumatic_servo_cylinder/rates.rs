//! How the states change: air, friction, motion and sensors, driven by the actuator.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::places::{PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B, of_actuator};
use super::sensors;
use super::states::{Inputs, State};
use crate::friction::FrictionLaw;
use crate::numbers::{Pair, Scalar};
use crate::pneumatics::actuator::{Actuating, STATES};

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Writes the rates of all states; those of states that rest are left as they are.
    // Compiled once for all numbers of states, which make no difference to the equations.
    #[inline(never)]
    pub(super) fn write_rates<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &[S; 3],
        memory: &MemoryOf<L, A>,
        rates: &mut [S],
    ) {
        let u = &Inputs::read(u);
        self.driven_rates(time, x, u, memory, rates);
        rates[..STATES].copy_from_slice(&self.actuator.rates(of_actuator(x), u.valve_voltage, &memory.actuator));
    }

    /// Writes the rates of all states but those of the actuator.
    #[inline(always)]
    pub(super) fn driven_rates<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A>,
        rates: &mut [S],
    ) {
        let bristles = self.friction.states();
        let [rate, acceleration] = self.motion_rates(time, x, u, memory, &x[bristles.clone()], &mut rates[bristles]);
        let gas = self.gas(x);
        let inflow = self.flows(x, u.supply_pressure, gas, rates);
        let gas = self.gas_rates(gas, State::Position.get(x), rate, inflow);
        Pair([rates[TEMPERATURE_A], rates[TEMPERATURE_B]]) = gas.temperature;
        Pair([rates[PRESSURE_A], rates[PRESSURE_B]]) = gas.pressure;
        State::Position.set(rates, rate);
        State::Velocity.set(rates, acceleration);
        if EXTENDED && self.sensors.states() > 0 {
            let quantities = self.measured(x, u, self.friction.rate(acceleration, &memory.friction));
            let own = self.sensors.rates(quantities, self.lagged(x));
            rates[Self::first_of_sensors(x.len())..][..sensors::COUNT].copy_from_slice(&own);
        }
    }
}
