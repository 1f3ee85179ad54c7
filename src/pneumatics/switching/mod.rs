//! Solenoid valves: two that are driven by pulses, or four that are switched one by one.

mod coils;
mod pulses;

use serde::{Deserialize, Serialize};

use super::actuation::{Actuating, Commands, Ports, STATES, SUPPLY};
use super::gas::GasState;
use super::orifice::{Inflow, edge_pieces};
use super::valve::{Edges, Port};
use crate::numbers::{Pair, Real, Scalar, Tangent, Varying};
use crate::system::{ClosedForm, Sample, Stride, references};
use crate::variables::{Fixed, ParameterError, Tunable, Variable, units};
use crate::{enumeration, outputs, parameters};

pub use self::pulses::{Armature, Driver};

enumeration! {
    /// Connections of the valves at 5 V, and between the pulses; ids are never reused.
    SwitchingCentre "SwitchingCentre": "State of a chamber that no switching valve feeds" {
        1 Vented: "Two 3/2 valves: a chamber that its valve does not feed is vented";
        2 Closed: "Two pairs of 2/2 valves: one feeds chamber A and vents chamber B, the other the other way round; between pulses both chambers are closed";
    }
}

enumeration! {
    /// The choice of the command of the coils; ids are never reused.
    SwitchingCommand "SwitchingCommand": "Command of the coils of switching valves" {
        1 OneVoltage: "valveVoltage: above 5 V it drives the valve that feeds chamber A, below 5 V the other one";
        2 EachValve: "valveVoltageA and valveVoltageB, each from 0 V, off, to 10 V, on, or a duty cycle between";
        3 EachCoil: "The Boolean inputs coil, at any time: four 2/2 valves that feed chamber A, vent chamber A, feed chamber B and vent chamber B";
    }
}

parameters! {
    /// The parameters of [`SwitchingValves`].
    Parameters {
        conductance: Fixed = Variable::parameter(1250, "switching.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 3.93e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance of an open switching valve, either way");
        critical_ratio: Fixed = Variable::parameter(1251, "switching.b", units::ONE, 0.3).range(0.0, 0.99)
            .text("Critical pressure ratio of the switching valves");
        centre: SwitchingCentre = Variable::choice(1252, "switching.centre", SwitchingCentre::Vented)
            .text("State of the valves at 5 V and between the pulses; with switching.command = EachCoil each valve is closed without current");
        frequency: Fixed = Variable::parameter(1253, "switching.frequency", units::HERTZ, 100.0).range(0.1, 1e4).plausible(1.0, 5e3)
            .text("Pulse frequency (PWM): the voltage at the beginning of a period sets its duty cycle. With switching.command = EachCoil coils are switched at any time");
        opening_delay: Fixed = Variable::parameter(1254, "switching.openingDelay", units::SECOND, 1e-3).range(0.0, 1.0).plausible(1e-6, 0.3).shown_in("ms")
            .text("Time from the beginning of a pulse, or from the switching on of a coil, until a valve begins to open; shorter pulses have no effect");
        closing_delay: Fixed = Variable::parameter(1255, "switching.closingDelay", units::SECOND, 1e-3).range(0.0, 1.0).plausible(1e-6, 0.3).shown_in("ms")
            .text("Time from the end of a pulse, or from the switching off of a coil, until a valve begins to close; shorter pauses have no effect");
        travel_time: Fixed = Variable::parameter(1256, "switching.travelTime", units::SECOND, 5e-4).range(0.0, 1.0).plausible(1e-6, 0.3).shown_in("ms")
            .text("Time in which a valve opens or closes, at a constant rate");
        command: SwitchingCommand = Variable::choice(1257, "switching.command", SwitchingCommand::OneVoltage)
            .text("Command of the coils");
    }
}

/// Value references of the states.
const OPENINGS: [u32; STATES] = [230, 231];

outputs! {
    /// The computed variables of [`SwitchingValves`].
    Outputs {
        opening_a = opening(0, "switching.openingA", "feeds chamber A");
        opening_b = opening(1, "switching.openingB", "feeds chamber B");
        rate_a = rate(0, "switching.openingA");
        rate_b = rate(1, "switching.openingB");
        duty = Variable::output(234, "switching.duty", units::ONE).local().nominal(1.0)
            .depends_on(&[]).text("Duty cycle of the present pulse: of the valve that feeds chamber A minus that of the valve that feeds chamber B; 0 with another actuator");
    }
}

fn opening(valve: usize, name: &str, what: &str) -> Variable {
    let variable = Variable::output(OPENINGS[valve], name, units::ONE).local().nominal(1.0);
    variable
        .depends_on(&[OPENINGS[valve]])
        .text(&format!("Opening of the switching valve that {what}; 0 with another actuator"))
}

fn rate(valve: usize, name: &str) -> Variable {
    let variable = Variable::output(OPENINGS[valve] + 2, &format!("der({name})"), units::PER_SECOND).local();
    variable
        .nominal(1e3)
        .derivative_of(OPENINGS[valve])
        .depends_on(&[])
        .text("Rate of the opening of a switching valve")
}

/// Two solenoid valves driven by pulses, or four that are switched one by one. States: how far the valves that feed the chambers are
/// open.
///
/// ```text
/// u   = clamp((V - 5)/5, -1, 1)    duty cycle, taken at the beginning of each period (see Driver)
/// C_A = C*y_A from the supply,     C*(1 - y_A) to the exhaust if vented,  C*y_B if closed
/// C_B = C*y_B from the supply,     C*(1 - y_B) to the exhaust if vented,  C*y_A if closed
/// ```
///
/// `u > 0` drives the valve A with the opening `y_A`, `u < 0` the valve B; with a command for each `V_A/10` drives the one, `V_B/10` the
/// other. With a coil for each, four 2/2 valves are closed without current, and `coil[1]` to `coil[4]` open them at any time:
///
/// ```text
/// C_A = C*y_1 from the supply,     C*y_2 to the exhaust
/// C_B = C*y_3 from the supply,     C*y_4 to the exhaust
/// ```
///
/// Both valves of a chamber may be open: air then flows from the supply to the exhaust. Each beginning and end of a pulse, of a motion
/// and of a period is a point in time that the solver meets exactly.
///
/// # Validity
/// The effective areas grow linearly with the time of opening. Without delays and travel the mean flow of fast pulses equals
/// the flow of a proportional valve of the opening `|u|`; a delay and a travel that are the same both ways shift the pulses
/// and keep their mean, as long as the pulses are longer than both.
#[derive(Clone, Debug)]
pub struct SwitchingValves {
    driver: Driver,
    centre: SwitchingCentre,
    command: SwitchingCommand,
    edges: Edges,
}

/// Discrete state of the valves, by what commands them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Memory<S> {
    /// Position in the period, and motion of two armatures.
    Pulses(pulses::Memory<S>),
    /// Motion of four armatures.
    Coils(coils::Memory<S>),
}

impl SwitchingValves {
    /// Openings of the valves that vent the chambers.
    fn venting<S: Scalar>(&self, time: S, openings: [S; STATES], memory: &Memory<S::Held>) -> Pair<S> {
        match memory {
            Memory::Pulses(_) => self.venting_beside(openings),
            Memory::Coils(coils) => Pair(coils.venting(&self.driver.armature, time)),
        }
    }

    /// The same of valves that vent a chamber by the way in which they feed one.
    fn venting_beside<S: Scalar>(&self, openings: [S; STATES]) -> Pair<S> {
        match self.centre {
            SwitchingCentre::Vented => -Pair(openings) + 1.0,
            SwitchingCentre::Closed => Pair(openings).swapped(),
        }
    }

    /// Flow into the chambers through the valves that feed them, and through those that vent them.
    fn flow<S: Scalar>(
        &self,
        [feeding, venting]: [Pair<S>; 2],
        ports: &Ports<S>,
        gas: GasState<Pair<S>>,
    ) -> Inflow<Pair<S>> {
        let supply = ports.supply.at(Pair([ports.supply_pressure; 2]));
        let exhaust = ports.exhaust.at(Pair([S::along(ports.exhaust_pressure); 2]));
        Inflow::from(self.edges.flow(feeding, supply, gas)) + Inflow::from(self.edges.flow(venting, exhaust, gas))
    }

    /// Rates of the openings of the valves that feed the chambers.
    fn rates_in<S: Varying>(&self, memory: &Memory<S>) -> [Tangent; STATES] {
        match memory {
            Memory::Pulses(pulses) => self.driver.rates(pulses),
            Memory::Coils(coils) => coils.rates(&self.driver.armature),
        }
    }
}

impl Actuating for SwitchingValves {
    type Memory<S: Varying> = Memory<S>;
    type Parameters = Parameters;

    const COMPUTED: usize = Outputs::<f64>::LEN;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        let Parameters { opening_delay, closing_delay, travel_time: travel, .. } = p;
        let armature = Armature { opening_delay, closing_delay, travel };
        let port = Port { conductance: p.conductance, critical_ratio: p.critical_ratio };
        let driver = Driver { frequency: p.frequency, armature };
        Ok(Self { driver, centre: p.centre, command: p.command, edges: Edges::new([port; 2], Tunable::still(0.0)) })
    }

    fn computed() -> Vec<Variable> {
        Outputs::<f64>::table()
    }

    fn feeds(_chamber: usize) -> Vec<u32> {
        vec![references::TIME, SUPPLY, OPENINGS[0], OPENINGS[1]]
    }

    fn variables(&self) -> [Option<u32>; STATES] {
        [Some(OPENINGS[0]), Some(OPENINGS[1])]
    }

    #[inline(always)]
    fn is_sampled(&self) -> bool {
        true
    }

    fn takes_commands_of_chambers(&self) -> bool {
        self.command == SwitchingCommand::EachValve
    }

    fn has_closed_form(&self) -> bool {
        true
    }

    fn depends_on_time(&self) -> bool {
        self.command == SwitchingCommand::EachCoil
    }

    fn scales(&self) -> [f64; STATES] {
        [1.0; STATES]
    }

    fn start<S: Varying>(&self, _commands: Commands<S>) -> ([S; STATES], Memory<S>) {
        let memory = match self.command {
            SwitchingCommand::EachCoil => Memory::Coils(coils::Memory::default()),
            SwitchingCommand::OneVoltage | SwitchingCommand::EachValve => Memory::Pulses(pulses::Memory::default()),
        };
        ([S::zero(); STATES], memory)
    }

    fn rates<S: Scalar>(
        &self,
        _openings: [S; STATES],
        _commands: Commands<S>,
        memory: &Memory<S::Held>,
    ) -> [S; STATES] {
        self.rates_in(memory).map(S::along)
    }

    /// Between its happenings each armature rests or moves at a constant speed.
    fn later<S: Varying>(
        &self,
        openings: [S; STATES],
        _commands: Commands<S>,
        memory: &Memory<S>,
        stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        let rates = self.rates_in(memory);
        let after = |time: f64| [0, 1].map(|valve| openings[valve] + S::along(rates[valve] * time));
        ClosedForm { middle: after(0.5 * stride.size), end: after(stride.size), defect: [S::zero(); STATES] }
    }

    fn smooth_region(&self, _openings: [f64; STATES], ports: &Ports<Real>, pressures: Pair<Real>) -> Pair<Real> {
        edge_pieces([ports.supply_pressure, Real::along(ports.exhaust_pressure)], pressures)
    }

    fn is_fast<S: Varying>(&self, memory: &Memory<S>) -> bool {
        match memory {
            Memory::Pulses(pulses) => pulses.is_moving(),
            Memory::Coils(coils) => coils.is_moving(),
        }
    }

    fn next_sample<S: Varying>(&self, memory: &Memory<S>) -> Sample<S> {
        match memory {
            Memory::Pulses(pulses) => self.driver.next(pulses),
            Memory::Coils(coils) => coils.next(),
        }
    }

    fn sample<S: Varying>(&self, openings: &mut [S; STATES], commands: Commands<S>, memory: &mut Memory<S>) {
        let pulses = match memory {
            Memory::Pulses(pulses) => pulses,
            Memory::Coils(coils) => return coils.happen(&self.driver.armature, openings),
        };
        let [none, all] = [S::zero(), S::of(1.0)];
        let duties = if self.takes_commands_of_chambers() {
            commands.of_chambers().map(|voltage| (voltage / 10.0).clamp(none, all))
        } else {
            let duty = (commands.voltage - 5.0) / 5.0;
            [duty, -duty].map(|duty| duty.clamp(none, all))
        };
        self.driver.happen(openings, duties, pulses);
    }

    fn command<S: Varying>(&self, time: S, commands: Commands<S>, memory: &mut Memory<S>) {
        if let Memory::Coils(coils) = memory {
            coils.command(&self.driver.armature, time, commands.coils.map(|coil| coil.value() > 0.5));
        }
    }

    #[inline(never)]
    fn feed<S: Scalar>(&self, openings: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        self.flow([Pair(openings), self.venting_beside(openings)], ports, gas)
    }

    fn feed_at<S: Scalar>(
        &self,
        time: S,
        openings: [S; STATES],
        memory: &Memory<S::Held>,
        ports: &Ports<S>,
        gas: GasState<Pair<S>>,
    ) -> Inflow<Pair<S>> {
        self.flow([Pair(openings), self.venting(time, openings, memory)], ports, gas)
    }

    fn drawn<S: Scalar>(&self, openings: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
        let supply = ports.supply.at(Pair([ports.supply_pressure; 2]));
        self.edges.flow(Pair(openings), supply, gas).mass
    }

    fn write<S: Scalar>(
        &self,
        openings: [S; STATES],
        commands: Commands<S>,
        memory: &Memory<S::Held>,
        slots: &mut [S],
    ) {
        let ([opening_a, opening_b], [rate_a, rate_b]) = (openings, self.rates(openings, commands, memory));
        let [duty_a, duty_b] = match memory {
            Memory::Pulses(pulses) => pulses.duties().map(S::held),
            Memory::Coils(_) => [S::zero(); 2],
        };
        Outputs { opening_a, opening_b, rate_a, rate_b, duty: duty_a - duty_b }.write(slots);
    }

    fn fits<S: Varying>(&self, memory: &Memory<S>) -> bool {
        match memory {
            Memory::Pulses(pulses) => self.command != SwitchingCommand::EachCoil && pulses.is_sound(),
            Memory::Coils(coils) => self.command == SwitchingCommand::EachCoil && coils.is_sound(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::ParameterSet;

    #[test]
    fn memory_of_a_voltage_that_is_no_number_fits_no_valves() {
        let starts: Vec<_> = Parameters::table().iter().filter_map(|it| it.start).map(Tunable::still).collect();
        let valves = SwitchingValves::new(Parameters::read(&starts).expect("legal")).expect("legal");
        for (voltage, fits) in [(7.0, true), (f64::NAN, false)] {
            let mut memory = Memory::Pulses(pulses::Memory::default());
            let commands = Commands::all(Real::of(voltage));
            valves.sample(&mut [Real::of(0.0); STATES], commands, &mut memory);
            assert_eq!(valves.fits(&memory), fits, "{voltage} V");
        }
    }
}
