//! The computed variables of the cylinder.

use super::variables::{self, Inputs, Outputs, State, TABLE};
use super::{MOST, Memory, PRESSURE_A, PRESSURE_B, PneumaticServoCylinder, of_actuator};
use crate::models::equations::Equations;
use crate::numbers::{Pair, Scalar};
use crate::variables::{Notice, Notices, Table};

impl<const N: usize, const EXTENDED: bool> Equations<N, 3> for PneumaticServoCylinder<EXTENDED> {
    const RESIDUALS: usize = variables::RESIDUALS;

    fn table() -> &'static Table {
        &TABLE
    }

    fn outputs<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; 3], memory: &Memory, computed: &mut [S]) {
        self.write_outputs(time, x, &Inputs::read(u), memory, computed);
    }

    fn at_hand(&self, place: usize, x: &[f64; N], memory: &Memory) -> Option<f64> {
        const POSITION: usize = Outputs::PLACES.position;
        const VELOCITY: usize = Outputs::PLACES.velocity;
        const IN_A: usize = Outputs::PLACES.pressure_a;
        const IN_B: usize = Outputs::PLACES.pressure_b;
        match place {
            POSITION => Some(x[State::Position.at(N)]),
            VELOCITY => Some(self.rate(x, memory)),
            IN_A => Some(x[PRESSURE_A]),
            IN_B => Some(x[PRESSURE_B]),
            _ => None,
        }
    }

    fn state_at(&self, reference: u32) -> Option<usize> {
        let own = State::of(reference).map(|state| state.at(N));
        let of_lines = || self.lines.state_at(reference).map(|place| self.first_of_lines(N) + place);
        let of_sensors = || self.sensors.state_at(reference).map(|place| Self::first_of_sensors(N) + place);
        own.or_else(|| self.friction.state_at(reference))
            .or_else(|| self.actuator.state_at(reference))
            .or_else(of_lines)
            .or_else(of_sensors)
    }

    fn notices(&self, u: &[f64; 3]) -> Notices {
        let Inputs { supply_pressure: value, .. } = Inputs::read(u);
        let remark = "it acts as ambientPressure, which is higher; pressures are absolute and in Pa";
        let is_low = value < self.p.ambient_pressure && self.actuator.has_supply();
        let low = is_low.then_some(Notice { variable: "supplyPressure", value, remark });
        [self.friction.law().notice(), low]
    }
}

impl<const EXTENDED: bool> PneumaticServoCylinder<EXTENDED> {
    /// Writes the computed variables, of which the table has as many whatever the number of states.
    // Compiled once for all these numbers.
    #[inline(never)]
    fn write_outputs<S: Scalar>(&self, time: S, x: &[S], u: &Inputs<S>, memory: &Memory, computed: &mut [S]) {
        let (position, rate) = (x[State::Position.at(x.len())], self.rate(x, memory));
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
        let rest = outputs.write(computed);
        let rest = self.actuator.write(of_actuator(x), u.valve_voltage, &memory.actuator, rest);
        let rest = friction.write(rest);
        let rest = self.write_lines(x, rates, rest);
        self.write_sensors(x, self.measured(x, u, acceleration), &memory.sensors, rest);
    }
}
