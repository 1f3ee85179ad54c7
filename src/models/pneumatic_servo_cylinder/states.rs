//! Inputs, states, and the places of the states in a run.

use super::motion::{Imposed, Motion};
use super::parameters::Parameters;
use super::{lines, sensors};
use crate::friction::MAX_STATES;
use crate::pneumatics::actuator::Actuation::{self, *};
use crate::pneumatics::actuator::{self, COIL, Commands, STATES, SUPPLY, VOLTAGE, VOLTAGE_A, VOLTAGE_B};
use crate::pneumatics::switching::SwitchingCommand;
use crate::variables::{Condition, Variable, units};
use crate::{inputs, states};

/// Value reference of the external force.
pub const FORCE: u32 = 2;
/// Value reference of the imposed position.
pub const IMPOSED_POSITION: u32 = 4;
/// Value reference of the imposed velocity.
pub const IMPOSED_VELOCITY: u32 = 5;

/// A command that some actuators do not take, and switching valves by one of their commands alone.
fn commands(input: Variable, others: &[Actuation], switching: SwitchingCommand) -> Variable {
    let switched =
        Condition::is_not(ACTUATION, &[SwitchingValves]).or(Condition::is("switching.command", &[switching]));
    input.counts_where(Condition::is_not(ACTUATION, others)).counts_where(switched)
}

const ACTUATION: &str = "actuation";

/// The command of an actuator for one chamber.
fn voltage_of(reference: u32, chamber: &str) -> Variable {
    let voltage = Variable::input(reference, &format!("valveVoltage{chamber}"), units::VOLT, 5.0).nominal(5.0);
    let voltage = commands(voltage, &[ProportionalValve, PressureRegulator], SwitchingCommand::EachValve);
    voltage.text(&format!(
        "Command of the valve of chamber {chamber} (5 V: closed, more feeds the chamber, less vents it) or of its regulator"
    ))
}

/// The command of a valve that is switched by itself.
fn coil(place: u32, what: &str) -> Variable {
    let coil = Variable::switch(COIL + place, &format!("coil[{}]", place + 1), false);
    let others = [ProportionalValve, PressureRegulator, TwoValves, TwoRegulators];
    commands(coil, &others, SwitchingCommand::EachCoil)
        .text(&format!("True switches on the coil of the valve that {what}"))
}

/// Number of inputs that equations without options read.
pub(super) const FEW: usize = 3;
/// Number of inputs.
pub(super) const ALL: usize = Inputs::LEN;

impl<S: Copy + Default> Inputs<S> {
    /// The inputs of equations that read the first `U` of them; the others do not count.
    #[inline(always)]
    pub(super) fn of<const U: usize>(u: &[S; U]) -> Self {
        const { assert!(U == FEW || U == ALL, "equations read either few of the inputs or all") };
        Self::read(&std::array::from_fn(|place| if place < U { u[place] } else { S::default() }))
    }

    /// Values of an imposed motion.
    #[inline(always)]
    pub(super) fn imposed(&self) -> Imposed<S> {
        Imposed { position: self.imposed_position, velocity: self.imposed_velocity }
    }

    /// Command of the actuator.
    #[inline(always)]
    pub(super) fn commands(&self) -> Commands<S> {
        Commands {
            voltage: self.valve_voltage,
            voltage_a: self.voltage_a,
            voltage_b: self.voltage_b,
            coils: [self.coil_1, self.coil_2, self.coil_3, self.coil_4],
        }
    }

    /// The same in other numbers.
    #[inline(always)]
    pub(super) fn map<T: Copy>(self, number: impl Fn(S) -> T) -> Inputs<T> {
        let Self { valve_voltage, external_force, supply_pressure, .. } = self;
        let Self { imposed_position, imposed_velocity, voltage_a, voltage_b, .. } = self;
        let Self { coil_1, coil_2, coil_3, coil_4, .. } = self;
        Inputs {
            valve_voltage: number(valve_voltage),
            external_force: number(external_force),
            supply_pressure: number(supply_pressure),
            imposed_position: number(imposed_position),
            imposed_velocity: number(imposed_velocity),
            voltage_a: number(voltage_a),
            voltage_b: number(voltage_b),
            coil_1: number(coil_1),
            coil_2: number(coil_2),
            coil_3: number(coil_3),
            coil_4: number(coil_4),
        }
    }
}

inputs! {
    /// The inputs.
    Inputs {
        valve_voltage = commands(Variable::input(VOLTAGE, "valveVoltage", units::VOLT, 5.0), &[TwoValves, TwoRegulators], SwitchingCommand::OneVoltage).nominal(5.0)
            .text("Valve voltage: 5 V closes the valve, more feeds chamber A, less chamber B; saturates at 0 and 10 V. With a single pressure regulator, its command");
        external_force = Variable::input(FORCE, "externalForce", units::NEWTON, 0.0).nominal(10.0)
            .text("External force on the carriage towards +x");
        supply_pressure = Variable::input(SUPPLY, "supplyPressure", units::PASCAL, 5e5).plausible(5e4, 5e6).at_least(0.0).nominal(1e5).shown_in("bar")
            .text("Supply pressure of the valve or the regulator, absolute; below ambient it acts as ambient");
        imposed_position = Variable::input(IMPOSED_POSITION, "imposedPosition", units::METRE, 0.25).counts_where(Condition::is("motion", &[Motion::Imposed])).nominal(0.1).shown_in("mm")
            .text("Imposed position of the carriage, or of the far end of the coupling, also at the start. A held value is the position at the beginning of a communication step; with a derivative it is the position at each instant");
        imposed_velocity = Variable::input(IMPOSED_VELOCITY, "imposedVelocity", units::METRE_PER_SECOND, 0.0).counts_where(Condition::is("motion", &[Motion::Imposed])).nominal(0.1).shown_in("mm/s")
            .text("Imposed velocity of the carriage, or of the far end of the coupling; if it is always 0, the position is reached at the end of each communication step");
        voltage_a = voltage_of(VOLTAGE_A, "A");
        voltage_b = voltage_of(VOLTAGE_B, "B");
        coil_1 = coil(0, "feeds chamber A");
        coil_2 = coil(1, "vents chamber A");
        coil_3 = coil(2, "feeds chamber B");
        coil_4 = coil(3, "vents chamber B");
    }
}

states! {
    /// The states that follow the actuator's.
    ///
    /// Their order keeps the elimination of the implicit scheme sparse: a chain from the actuator over the chambers and
    /// the friction law to the motion.
    State of Parameters, from actuator::STATES; {
        TemperatureA: 109, |_| 300.0;
        TemperatureB: 110, |_| 300.0;
        PressureA: 107, |_| 1e5;
        PressureB: 108, |_| 1e5;
        ..friction;
        Position: 101, |_| 0.1;
        Velocity: 102, |_| 0.1;
    }
}

// In front of the friction law the places do not depend on its number of states.
pub(super) const TEMPERATURE_A: usize = State::TemperatureA.at(State::OTHERS);
pub(super) const TEMPERATURE_B: usize = State::TemperatureB.at(State::OTHERS);
/// Index of the pressure in chamber A among the states.
pub const PRESSURE_A: usize = State::PressureA.at(State::OTHERS);
/// Index of the pressure in chamber B among the states.
pub const PRESSURE_B: usize = State::PressureB.at(State::OTHERS);

/// The states of the actuator, which come first.
#[inline(always)]
pub(super) fn of_actuator<S: Copy>(x: &[S]) -> [S; STATES] {
    std::array::from_fn(|place| x[place])
}

/// States of a cylinder that has them all.
pub(super) const MOST: usize = State::OTHERS + MAX_STATES + lines::LINE_STATES + sensors::COUNT;
