//! The computed variables of the cylinder.

use super::cylinder::{MemoryOf, PneumaticServoCylinder};
use super::lines::Lines;
use super::places::{MOST, PRESSURE_A, PRESSURE_B, of_actuator};
use super::sensors::Sensors;
use super::states::{Inputs, State};
use super::variables::{ByPart, Outputs};
use crate::friction::{FrictionLaw, states};
use crate::numbers::{Pair, Scalar};
use crate::pneumatics::actuator::Actuating;

impl<L: FrictionLaw, A: Actuating, const EXTENDED: bool> PneumaticServoCylinder<L, A, EXTENDED> {
    /// Writes the computed variables, of which the table has as many whatever the number of states.
    // Compiled once for all these numbers.
    #[inline(never)]
    pub(super) fn write_outputs<S: Scalar>(
        &self,
        time: S,
        x: &[S],
        u: &Inputs<S>,
        memory: &MemoryOf<L, A>,
        computed: &mut [S],
    ) {
        let (position, rate) = (State::Position.get(x), self.rate(x, memory));
        let contact = self.contact(time, x, u, rate);
        let friction = self.friction.observe(&contact, x, &memory.friction);
        let acceleration = friction.unless_held((contact.applied - friction.force) * self.per_mass);
        let gas = self.gas(x);
        let Pair([temperature_a, temperature_b]) = gas.temperature;
        let rates = &mut [S::zero(); MOST][..x.len()];
        let inflow = self.flows(x, u.supply_pressure, gas, rates);
        let gas = self.gas_rates(gas, position, rate, inflow);
        let Pair([mass_flow_a, mass_flow_b]) = gas.mass_flow;
        let Pair([pressure_rate_a, pressure_rate_b]) = gas.pressure;
        let Pair([temperature_rate_a, temperature_rate_b]) = gas.temperature;
        let outputs = Outputs {
            position,
            velocity: rate,
            acceleration,
            rod_force: self.rod_force(acceleration, position, u.external_force),
            pressure_force: self.pressure_force(x),
            friction_force: friction.force,
            pressure_a: x[PRESSURE_A],
            pressure_b: x[PRESSURE_B],
            temperature_a,
            temperature_b,
            mass_flow_a,
            mass_flow_b,
            sticking: friction.sticking,
            pressure_rate_a,
            temperature_rate_a,
            pressure_rate_b,
            temperature_rate_b,
            stop_force: self.applied_force(x, u, rate).1,
            load_level: contact.level,
        };
        let lengths = ByPart {
            outputs: Outputs::<S>::LEN,
            actuator: A::COMPUTED,
            friction: states::COMPUTED,
            lines: Lines::COMPUTED,
            sensors: Sensors::COMPUTED,
        };
        let slots = ByPart::new(computed, &lengths);
        outputs.write(slots.outputs);
        self.actuator.write(of_actuator(x), u.valve_voltage, &memory.actuator, slots.actuator);
        friction.write(slots.friction);
        self.write_lines(x, rates, slots.lines);
        self.write_sensors(x, self.measured(x, u, acceleration), &memory.sensors, slots.sensors);
    }
}
