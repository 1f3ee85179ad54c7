//! How the states change: air, friction, motion and sensors, driven by the actuator.

use super::variables::{Inputs, State};
use super::{Memory, PRESSURE_A, PRESSURE_B, PneumaticServoCylinder, TEMPERATURE_A, TEMPERATURE_B, sensors};
use crate::numbers::{Pair, Scalar};

impl<const EXTENDED: bool> PneumaticServoCylinder<EXTENDED> {
    /// Rates of all states but those of the actuator, which are left at 0.
    #[inline(always)]
    pub(super) fn driven_rates<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &Inputs<S>,
        memory: &Memory,
    ) -> [S; N] {
        let mut rates = [S::zero(); N];
        let bristles = self.friction.states();
        let [rate, acceleration] = self.motion_rates(time, x, u, memory, &x[bristles.clone()], &mut rates[bristles]);
        let gas = self.gas(x);
        let inflow = self.flows(x, u.supply_pressure, gas, &mut rates);
        let gas = self.gas_rates(gas, x[State::Position.at(N)], rate, inflow);
        Pair([rates[TEMPERATURE_A], rates[TEMPERATURE_B]]) = gas.temperature;
        Pair([rates[PRESSURE_A], rates[PRESSURE_B]]) = gas.pressure;
        rates[State::Position.at(N)] = rate;
        rates[State::Velocity.at(N)] = acceleration;
        if EXTENDED && self.sensors.states() > 0 {
            let quantities = self.measured(x, u, self.friction.rate(acceleration, &memory.friction));
            let own = self.sensors.rates(quantities, self.lagged(x));
            rates[Self::first_of_sensors(N)..][..sensors::COUNT].copy_from_slice(&own);
        }
        rates
    }
}
