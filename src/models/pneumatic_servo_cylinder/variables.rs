//! The variable table of the cylinder.

use std::f64::consts::PI;

use super::lines::{self, Lines};
use super::options::Options;
use super::sensors::Sensors;
use crate::friction::{Law, Laws, states};
use crate::pneumatics::actuator::{self, Actuators};
use crate::pneumatics::chamber::ThermalModel;
use crate::system::{Tables, references};
use crate::variables::{Choice, ParameterError, ParameterSet, Tunable, Variable, units};
use crate::{inputs, outputs, parameters, states};

/// Conserved quantities: mass and energy.
pub const RESIDUALS: usize = 2;

/// Every variable of the cylinder.
pub fn tables<L: Laws, A: Actuators>() -> Tables {
    let feeds = [A::feeds(0), A::feeds(1)];
    let at_ports = [[depends::P_A, depends::T_A, depends::X], [depends::P_B, depends::T_B, depends::X]];
    let measured = [&[depends::X][..], &[depends::P_A], &[depends::P_B], &depends::motion()];
    let outputs = Outputs::<f64>::table().into_iter().map(|variable| depends::on_feeds(variable, &feeds));
    Tables {
        inputs: Inputs::table(),
        computed: [
            outputs.collect(),
            A::computed(),
            states::table("friction", references::CONTACT, depends::SLIDING),
            Lines::computed([&feeds[0], &feeds[1]], at_ports),
            Sensors::computed(measured, [&[], &[], &[], &[depends::FORCE]]),
            residuals_table().to_vec(),
        ]
        .concat(),
        parameters: [
            Parameters::table(),
            Options::table(),
            Sensors::table(),
            A::parameters(1032),
            L::table("friction", references::FRICTION, Law::Stribeck.id()),
        ]
        .concat(),
    }
}

inputs! {
    /// The inputs.
    Inputs {
        valve_voltage = Variable::input(depends::VOLTAGE, "valveVoltage", units::VOLT, 5.0).nominal(5.0)
            .text("Valve voltage: 5 V closes the valve, more feeds chamber A, less chamber B; saturates at 0 and 10 V. Commands the regulator on the second rig");
        external_force = Variable::input(depends::FORCE, "externalForce", units::NEWTON, 0.0).nominal(10.0)
            .text("External force on the carriage towards +x");
        supply_pressure = Variable::input(depends::SUPPLY, "supplyPressure", units::PASCAL, 5e5).at_least(0.0).nominal(1e5).shown_in("bar")
            .text("Supply pressure of the valve or the regulator, absolute; below ambient it acts as ambient");
    }
}

states! {
    /// The states behind those of the actuator.
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

/// Inputs and states that the computed variables depend on.
mod depends {
    use super::{State, lines, references, states};
    pub use crate::pneumatics::actuator::{SUPPLY, VOLTAGE};
    use crate::variables::Variable;

    pub const FORCE: u32 = 2;
    pub const X: u32 = State::Position.reference();
    pub const V: u32 = State::Velocity.reference();
    pub const P_A: u32 = State::PressureA.reference();
    pub const P_B: u32 = State::PressureB.reference();
    pub const T_A: u32 = State::TemperatureA.reference();
    pub const T_B: u32 = State::TemperatureB.reference();

    /// What the mass flow into a chamber depends on; the laminar leakage past the piston, on both pressures, a cushion on
    /// the position.
    pub fn flow(chamber: usize) -> Vec<u32> {
        let lines = lines::feeds(chamber).to_vec();
        [vec![FEED[chamber]], vec![P_A, P_B, [T_A, T_B][chamber], X], lines].concat()
    }

    /// Stands for what the inflow of a chamber depends on, which is a matter of the actuators.
    const FEED: [u32; 2] = [u32::MAX - 1, u32::MAX];

    /// A variable that depends on what the actuators say where it depends on an inflow.
    pub fn on_feeds(variable: Variable, feeds: &[Vec<u32>; 2]) -> Variable {
        let real = |reference: &u32| match FEED.iter().position(|feed| feed == reference) {
            Some(chamber) => feeds[chamber].clone(),
            None => vec![*reference],
        };
        let known: Vec<u32> = variable.depends_on.iter().flat_map(real).collect();
        variable.depends_on(&known)
    }

    /// What the rates of a chamber depend on; what leaks past the piston brings the temperature upstream along.
    pub fn gas(chamber: usize) -> Vec<u32> {
        [flow(chamber), vec![[T_B, T_A][chamber], V]].concat()
    }

    /// What decides whether a law without states of its own holds the mass.
    pub const LOAD: &[u32] = &[references::TIME, FORCE, X, V, P_A, P_B];

    /// What velocity and load level depend on.
    pub const SLIDING: &[u32] = &[X, V, P_A, P_B];

    /// What friction and acceleration depend on.
    pub fn motion() -> Vec<u32> {
        [LOAD.to_vec(), states::references(references::CONTACT)].concat()
    }
}

outputs! {
    /// The computed variables.
    Outputs {
        position = Variable::output(depends::X, "position", units::METRE).nominal(0.1).shown_in("mm")
            .depends_on(&[depends::X])
            .text("Position of the carriage, 0 at the end of the instroke, stroke at the end of the outstroke");
        velocity = Variable::output(depends::V, "velocity", units::METRE_PER_SECOND).nominal(0.1).shown_in("mm/s").derivative_of(depends::X)
            .depends_on(&[depends::V])
            .text("Velocity of the carriage; exactly 0 while it sticks");
        acceleration = Variable::output(103, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0).derivative_of(depends::V)
            .depends_on(&depends::motion())
            .text("Acceleration of the carriage");
        rod_force = Variable::output(104, "rodForce", units::NEWTON).nominal(10.0)
            .depends_on(&depends::motion())
            .text("Force of the rod on the carriage, positive when pushing: what a load cell between them reads");
        pressure_force = Variable::output(105, "pressureForce", units::NEWTON).nominal(10.0)
            .depends_on(&[depends::P_A, depends::P_B])
            .text("Force of the chambers and of the atmosphere on the rod");
        friction_force = Variable::output(106, "frictionForce", units::NEWTON).nominal(10.0)
            .depends_on(&depends::motion())
            .text("Friction force on the moving mass, positive when it opposes motion towards +x");
        pressure_a = Variable::output(depends::P_A, "chamberA.pressure", units::PASCAL).nominal(1e5).shown_in("bar")
            .depends_on(&[depends::P_A])
            .text("Absolute pressure in chamber A");
        pressure_b = Variable::output(depends::P_B, "chamberB.pressure", units::PASCAL).nominal(1e5).shown_in("bar")
            .depends_on(&[depends::P_B])
            .text("Absolute pressure in chamber B");
        temperature_a = Variable::output(depends::T_A, "chamberA.temperature", units::KELVIN).nominal(300.0).shown_in("degC")
            .depends_on(&[depends::P_A, depends::T_A])
            .text("Gas temperature in chamber A");
        temperature_b = Variable::output(depends::T_B, "chamberB.temperature", units::KELVIN).nominal(300.0).shown_in("degC")
            .depends_on(&[depends::P_B, depends::T_B])
            .text("Gas temperature in chamber B");
        mass_flow_a = Variable::output(111, "chamberA.massFlow", units::KILOGRAM_PER_SECOND).nominal(1e-3).shown_in("l/min(ANR)")
            .depends_on(&depends::flow(0))
            .text("Net mass flow into chamber A, leakage included");
        mass_flow_b = Variable::output(112, "chamberB.massFlow", units::KILOGRAM_PER_SECOND).nominal(1e-3).shown_in("l/min(ANR)")
            .depends_on(&[depends::flow(1), vec![depends::V]].concat())
            .text("Net mass flow into chamber B, leakage included; what an open chamber breathes");
        sticking = Variable::flag(114, "sticking")
            .depends_on(depends::LOAD)
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the carriage");
        pressure_rate_a = Variable::output(207, "der(chamberA.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(depends::P_A)
            .depends_on(&depends::gas(0))
            .text("Rate of the pressure in chamber A");
        temperature_rate_a = Variable::output(209, "der(chamberA.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(depends::T_A)
            .depends_on(&depends::gas(0))
            .text("Rate of the temperature in chamber A");
        pressure_rate_b = Variable::output(208, "der(chamberB.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(depends::P_B)
            .depends_on(&depends::gas(1))
            .text("Rate of the pressure in chamber B");
        temperature_rate_b = Variable::output(210, "der(chamberB.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(depends::T_B)
            .depends_on(&depends::gas(1))
            .text("Rate of the temperature in chamber B");
        stop_force = Variable::output(211, "cylinder.stopForce", units::NEWTON).local().nominal(100.0)
            .depends_on(&[depends::X, depends::V])
            .text("Force of the end stops on the carriage towards +x");
        load_level = Variable::output(212, "friction.level", units::ONE).local().nominal(1.0)
            .depends_on(&[depends::X, depends::P_A, depends::P_B])
            .text("Load level lambda that multiplies the forces of the friction law");
    }
}

/// Residuals of the balances, in the order of the conserved quantities.
fn residuals_table() -> [Variable; RESIDUALS] {
    [
        Variable::output(213, "balance.massResidual", units::KILOGRAM).local().nominal(1e-3).shown_in("g")
            .text("Mass of the gas in chambers, hoses and vessel beyond what was there at the start and has flowed in since: the error of the integration, and with thermal.model = PolytropicServo what that model takes from or adds to the mass; 0 unless balance.enabled"),
        Variable::output(214, "balance.energyResidual", units::JOULE).local().nominal(1.0)
            .text("Energy of gas and carriage beyond what was there at the start and has flowed in since as enthalpy, heat and work; of the carriage alone unless thermal.model = EnergyBalance; 0 unless balance.enabled"),
    ]
}

parameters! {
    /// The parameters of the rig; those of the friction law and of the solver follow in the table.
    Parameters {
        bore: f64 = Variable::parameter(1001, "cylinder.bore", units::METRE, 0.016).range(1e-3, 1.0).shown_in("mm")
            .text("Bore diameter");
        rod: f64 = Variable::parameter(1002, "cylinder.rod", units::METRE, 0.006).range(0.0, 1.0).shown_in("mm")
            .text("Rod diameter, smaller than the bore");
        stroke: f64 = Variable::parameter(1003, "cylinder.stroke", units::METRE, 0.5).range(1e-3, 10.0).shown_in("mm")
            .text("Stroke");
        stop_stiffness: f64 = Variable::parameter(1004, "cylinder.stopStiffness", units::NEWTON_PER_METRE, 1e6).range(1e3, 1e10)
            .text("Contact stiffness of the end stops");
        stop_damping: f64 = Variable::parameter(1005, "cylinder.stopDamping", units::SECOND_PER_METRE, 0.75).range(0.0, 1e3)
            .text("Dissipation coefficient of the end stops (Hunt-Crossley)");
        dead_volume_a: f64 = Variable::parameter(1006, "chamberA.deadVolume", units::CUBIC_METRE, 5e-6).range(1e-8, 1.0).shown_in("cm3")
            .text("Dead volume of chamber A, hose included");
        dead_volume_b: f64 = Variable::parameter(1007, "chamberB.deadVolume", units::CUBIC_METRE, 5e-6).range(1e-8, 1.0).shown_in("cm3")
            .text("Dead volume of chamber B, hose included");
        pressure0_a: f64 = Variable::parameter(1008, "chamberA.pressure0", units::PASCAL, 101_325.0).range(1e3, 1e8).shown_in("bar")
            .text("Initial absolute pressure in chamber A");
        pressure0_b: f64 = Variable::parameter(1009, "chamberB.pressure0", units::PASCAL, 101_325.0).range(1e3, 1e8).shown_in("bar")
            .text("Initial absolute pressure in chamber B");
        tank_volume: f64 = Variable::parameter(1010, "chamberB.tankVolume", units::CUBIC_METRE, 0.0).range(0.0, 1.0).shown_in("cm3")
            .text("Volume of a tank connected to chamber B, a cylinder twice as long as wide");
        moving_mass: f64 = Variable::parameter(1011, "mass.moving", units::KILOGRAM, 0.88).range(1e-3, 1e4)
            .text("Moving mass: piston, rod, load cell and carriage");
        carriage_mass: f64 = Variable::parameter(1012, "mass.carriage", units::KILOGRAM, 0.75).range(0.0, 1e4)
            .text("Part of the moving mass beyond the load cell");
        position0: f64 = Variable::parameter(1013, "position0", units::METRE, 0.25).range(0.0, 10.0).shown_in("mm")
            .text("Initial position, within the stroke");
        velocity0: f64 = Variable::parameter(1014, "velocity0", units::METRE_PER_SECOND, 0.0).range(-100.0, 100.0).shown_in("mm/s")
            .text("Initial velocity");
        ambient_pressure: f64 = Variable::parameter(1015, "ambientPressure", units::PASCAL, 101_325.0).range(1e3, 1e7).shown_in("bar")
            .text("Absolute ambient pressure, also behind the exhaust");
        ambient_temperature: f64 = Variable::parameter(1016, "ambientTemperature", units::KELVIN, 293.15).range(100.0, 1000.0).shown_in("degC")
            .text("Ambient and initial gas temperature");
        supply_temperature: Tunable = Variable::parameter(1017, "supplyTemperature", units::KELVIN, 293.15).range(100.0, 1000.0).shown_in("degC")
            .text("Temperature of the supplied air");
        heat_transfer: Tunable = Variable::parameter(1018, "thermal.heatTransfer", units::WATT_PER_SQUARE_METRE_KELVIN, 60.0).range(0.0, 1e5)
            .text("Heat transfer coefficient between gas and wall, which is at ambient temperature");
        thermal_model: ThermalModel = Variable::choice(1019, "thermal.model", ThermalModel::EnergyBalance)
            .text("How the gas temperature follows");
        exponent: f64 = Variable::parameter(1020, "thermal.exponent", units::ONE, 1.2).range(1.0, 2.0)
            .text("Polytropic exponent of the models Polytropic and PolytropicServo");
        incline: f64 = Variable::parameter(1021, "incline", units::RADIAN, 0.0).range(-PI / 2.0, PI / 2.0).shown_in("deg")
            .text("Inclination of the axis; positive: outstroke is uphill");
        wire_force: Tunable = Variable::parameter(1022, "wireForce", units::NEWTON, 0.0).range(-1e4, 1e4)
            .text("Retracting force of the position transducer's wire, towards -x");
        piston_leakage: f64 = Variable::parameter(1023, "piston.leakage", units::KILOGRAM_PER_SECOND_SQUARE_PASCAL, 0.0).range(0.0, 1e-10)
            .text("Laminar leakage coefficient between the chambers");
        kappa_a: Tunable = Variable::parameter(1038, "friction.kappaA", units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).shown_in("1/bar")
            .text("Growth of the load level with the pressure in chamber A above ambient");
        kappa_b: Tunable = Variable::parameter(1039, "friction.kappaB", units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).shown_in("1/bar")
            .text("Growth of the load level with the pressure in chamber B above ambient");
        keeps_balance: bool = Variable::option(1040, "balance.enabled", false)
            .text("Keep account of mass and energy, for balance.massResidual and balance.energyResidual; makes steps a fifth slower");
    }
}

impl Parameters {
    /// Refuses combinations without a meaning.
    pub fn check(&self) -> Result<(), ParameterError> {
        let refuse = |name: &str, value: f64, reason: String| Err(ParameterError::new(name, value, &reason));
        if self.rod >= self.bore {
            return refuse("cylinder.rod", self.rod, format!("it must be smaller than cylinder.bore = {}", self.bore));
        }
        if self.position0 > self.stroke {
            let reason = format!("it must not exceed cylinder.stroke = {}", self.stroke);
            return refuse("position0", self.position0, reason);
        }
        if self.carriage_mass > self.moving_mass {
            let reason = format!("it must not exceed mass.moving = {}", self.moving_mass);
            return refuse("mass.carriage", self.carriage_mass, reason);
        }
        Ok(())
    }
}
