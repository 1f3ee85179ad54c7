//! A double-acting pneumatic cylinder with a friction-loaded carriage, fed by a 5/3 proportional valve or, on a second
//! rig, by a pressure regulator with the other chamber plugged.
//!
//! Chamber A (cap side, full bore) pushes the carriage to +x; chamber B is the rod side. The equations are those of
//! the rooms [`pneumatics`](crate::pneumatics), [`mechanics`](crate::mechanics) and [`friction`](crate::friction);
//! this file joins them:
//!
//! ```text
//! F_app = p_A*A_A - p_B*A_B - p_atm*A_r + F_ext - F_wire - m*g*sin(incline) + F_stop
//! m*dv/dt = F_app - F_f,   dx/dt = v
//! ```

use std::f64::consts::PI;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::equations::Equations;
use super::simulator::{Simulator, counters_table};
use crate::friction::{self, Contact, Drive, Friction, Indicators};
use crate::mechanics::{EndStops, GRAVITY};
use crate::pneumatics::chamber::{Chamber, ChamberRates, THERMAL_MODELS, Thermal};
use crate::pneumatics::gas::GasState;
use crate::pneumatics::orifice::{Flow, Orifice};
use crate::pneumatics::regulator::Regulator;
use crate::pneumatics::valve::Valve;
use crate::scalar::Scalar;
use crate::simulation::{Experiment, Model, Simulation, Start};
use crate::solver::{HybridSystem, Settings, Tuning};
use crate::variables::{Enumeration, ParameterError, ParameterSet, Role, Variable, units};
use crate::{outputs, parameters};

/// The model as the library offers it.
pub const MODEL: Model = Model {
    name: "PneumaticServoCylinder",
    description: "Friction-loaded pneumatic servo cylinder with 5/3 proportional valve",
    variables: || &TABLE,
    start,
    experiment: Experiment { stop_time: 3.0, step_size: 1e-3 },
};

/// Value reference of the first variable of the friction law.
const FRICTION_BASE: u32 = 10_000;
/// Value reference of the first parameter of the solver.
const SOLVER_BASE: u32 = 5_000;
/// Value reference of the first counter of the solver.
const COUNTERS_BASE: u32 = 5_100;
/// Value reference of the first bristle state; its derivatives follow.
const BRISTLE_BASE: u32 = 400;

static TABLE: LazyLock<Vec<Variable>> = LazyLock::new(|| {
    let time = Variable::output(0, "time", units::SECOND).text("Time");
    let mut table = vec![Variable { role: Role::Time, ..time }];
    table.extend(Inputs::table());
    table.extend(Outputs::<f64>::table());
    table.extend(bristle_table());
    table.extend(counters_table(COUNTERS_BASE));
    table.extend(Parameters::table());
    table.extend(Friction::table("friction", FRICTION_BASE, 7));
    table.extend(Tuning::grouped(SOLVER_BASE));
    table
});

parameters! {
    /// The inputs.
    Inputs {
        valve_voltage: f64 = Variable::input(1, "valveVoltage", units::VOLT, 5.0).nominal(5.0)
            .text("Valve voltage: 5 V closes the valve, more feeds chamber A, less chamber B; saturates at 0 and 10 V. Commands the regulator on the second rig");
        external_force: f64 = Variable::input(2, "externalForce", units::NEWTON, 0.0).nominal(10.0)
            .text("External force on the carriage towards +x");
        supply_pressure: f64 = Variable::input(3, "supplyPressure", units::PASCAL, 5e5).at_least(0.0).nominal(1e5).shown_in("bar")
            .text("Supply pressure of the valve, absolute");
    }
}

/// Inputs and states that the computed variables depend on.
mod depends {
    pub const FORCE: u32 = 2;
    pub const SUPPLY: u32 = 3;
    pub const VOLTAGE: u32 = 1;
    pub const X: u32 = 101;
    pub const V: u32 = 102;
    pub const P_A: u32 = 107;
    pub const P_B: u32 = 108;
    pub const T_A: u32 = 109;
    pub const T_B: u32 = 110;
    pub const SPOOL: u32 = 113;
    pub const SPOOL_RATE: u32 = 202;
    pub const REGULATOR: u32 = 203;
    pub const Z: [u32; 10] = [400, 401, 402, 403, 404, 405, 406, 407, 408, 409];
    /// What friction and acceleration depend on.
    pub const MOTION: &[u32] = &[FORCE, X, V, P_A, P_B, Z[0], Z[1], Z[2], Z[3], Z[4], Z[5], Z[6], Z[7], Z[8], Z[9]];
    /// What flows in chamber A depend on.
    pub const GAS_A: &[u32] = &[SUPPLY, P_A, T_A, SPOOL, REGULATOR];
    /// What flows in chamber B depend on.
    pub const GAS_B: &[u32] = &[SUPPLY, P_B, T_B, SPOOL];
}

outputs! {
    /// The computed variables.
    Outputs {
        position = Variable::output(101, "position", units::METRE).nominal(0.1).shown_in("mm")
            .depends_on(&[depends::X])
            .text("Position of the carriage, 0 at the end of the instroke, stroke at the end of the outstroke");
        velocity = Variable::output(102, "velocity", units::METRE_PER_SECOND).nominal(0.1).shown_in("mm/s").derivative_of(101)
            .depends_on(&[depends::V])
            .text("Velocity of the carriage; exactly 0 while it sticks");
        acceleration = Variable::output(103, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0).derivative_of(102)
            .depends_on(depends::MOTION)
            .text("Acceleration of the carriage");
        rod_force = Variable::output(104, "rodForce", units::NEWTON).nominal(10.0)
            .depends_on(depends::MOTION)
            .text("Force of the rod on the carriage, positive when pushing: what a load cell between them reads");
        pressure_force = Variable::output(105, "pressureForce", units::NEWTON).nominal(10.0)
            .depends_on(&[depends::P_A, depends::P_B])
            .text("Force of the chambers and of the atmosphere on the rod");
        friction_force = Variable::output(106, "frictionForce", units::NEWTON).nominal(10.0)
            .depends_on(depends::MOTION)
            .text("Friction force on the moving mass, positive when it opposes motion towards +x");
        pressure_a = Variable::output(107, "chamberA.pressure", units::PASCAL).nominal(1e5).shown_in("bar")
            .depends_on(&[depends::P_A])
            .text("Absolute pressure in chamber A");
        pressure_b = Variable::output(108, "chamberB.pressure", units::PASCAL).nominal(1e5).shown_in("bar")
            .depends_on(&[depends::P_B])
            .text("Absolute pressure in chamber B");
        temperature_a = Variable::output(109, "chamberA.temperature", units::KELVIN).nominal(300.0).shown_in("degC")
            .depends_on(&[depends::P_A, depends::T_A])
            .text("Gas temperature in chamber A");
        temperature_b = Variable::output(110, "chamberB.temperature", units::KELVIN).nominal(300.0).shown_in("degC")
            .depends_on(&[depends::P_B, depends::T_B])
            .text("Gas temperature in chamber B");
        mass_flow_a = Variable::output(111, "chamberA.massFlow", units::KILOGRAM_PER_SECOND).nominal(1e-3).shown_in("l/min(ANR)")
            .depends_on(&[depends::SUPPLY, depends::P_A, depends::P_B, depends::T_A, depends::SPOOL, depends::REGULATOR])
            .text("Net mass flow into chamber A, leakage included");
        mass_flow_b = Variable::output(112, "chamberB.massFlow", units::KILOGRAM_PER_SECOND).nominal(1e-3).shown_in("l/min(ANR)")
            .depends_on(&[depends::SUPPLY, depends::P_A, depends::P_B, depends::T_B, depends::SPOOL])
            .text("Net mass flow into chamber B, leakage included");
        spool = Variable::output(113, "valve.spool", units::ONE).nominal(1.0)
            .depends_on(&[depends::SPOOL])
            .text("Spool position as a fraction of its travel, positive feeds chamber A; 0 on the rig with a regulator");
        sticking = Variable::flag(114, "sticking")
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the carriage");
        pressure_rate_a = Variable::output(207, "der(chamberA.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(107)
            .depends_on(&[depends::X, depends::V, depends::P_B])
            .text("Rate of the pressure in chamber A");
        temperature_rate_a = Variable::output(209, "der(chamberA.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(109)
            .depends_on(&[depends::X, depends::V, depends::P_B])
            .text("Rate of the temperature in chamber A");
        pressure_rate_b = Variable::output(208, "der(chamberB.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(108)
            .depends_on(&[depends::X, depends::V, depends::P_A])
            .text("Rate of the pressure in chamber B");
        temperature_rate_b = Variable::output(210, "der(chamberB.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(110)
            .depends_on(&[depends::X, depends::V, depends::P_A])
            .text("Rate of the temperature in chamber B");
        spool_velocity = Variable::output(202, "valve.spoolVelocity", units::PER_SECOND).local().nominal(100.0).derivative_of(113)
            .depends_on(&[depends::SPOOL_RATE])
            .text("Velocity of the spool");
        spool_acceleration = Variable::output(204, "der(valve.spoolVelocity)", units::PER_SECOND_SQUARED).local().nominal(1e5).derivative_of(202)
            .depends_on(&[depends::VOLTAGE, depends::SPOOL, depends::SPOOL_RATE])
            .text("Acceleration of the spool");
        regulator_pressure = Variable::output(203, "regulator.pressure", units::PASCAL).local().nominal(1e5).shown_in("bar")
            .depends_on(&[depends::REGULATOR])
            .text("Absolute pressure behind the regulator; 0 on the rig with a valve");
        regulator_rate = Variable::output(205, "der(regulator.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(203)
            .depends_on(&[depends::VOLTAGE, depends::REGULATOR])
            .text("Rate of the pressure behind the regulator");
        valve_command = Variable::output(206, "valve.command", units::ONE).local().nominal(1.0)
            .depends_on(&[depends::VOLTAGE])
            .text("Set point of the spool after the hysteresis");
        stop_force = Variable::output(211, "cylinder.stopForce", units::NEWTON).local().nominal(100.0)
            .depends_on(&[depends::X, depends::V])
            .text("Force of the end stops on the carriage towards +x");
        load_level = Variable::output(212, "friction.level", units::ONE).local().nominal(1.0)
            .depends_on(&[depends::P_A, depends::P_B])
            .text("Load level lambda that multiplies the force levels of the friction law");
    }
}

/// The bristle states of the friction law and their derivatives.
fn bristle_table() -> Vec<Variable> {
    let count = friction::MAX_STATES as u32;
    let states = (0..count).map(|i| {
        Variable::output(BRISTLE_BASE + i, &format!("friction.state[{}]", i + 1), units::ONE)
            .local()
            .depends_on(&[BRISTLE_BASE + i])
            .text("Continuous state of the friction law (deflection in m, or force in N for GMS and Bliman-Sorine); 0 if unused")
    });
    let rates = (0..count).map(|i| {
        Variable::output(BRISTLE_BASE + count + i, &format!("der(friction.state[{}])", i + 1), units::ONE)
            .local()
            .derivative_of(BRISTLE_BASE + i)
            .depends_on(depends::MOTION)
            .text("Rate per second of a continuous state of the friction law")
    });
    states.chain(rates).collect()
}

/// The choice of the rig; ids are never reused.
pub static ACTUATIONS: Enumeration = Enumeration {
    name: "Actuation",
    description: "What moves the cylinder",
    items: &[
        (1, "ProportionalValve", "5/3 proportional valve between supply and both chambers"),
        (2, "PressureRegulator", "Pressure regulator feeding chamber A, chamber B plugged"),
    ],
};

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
            .text("Volume of a tank connected to chamber B");
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
        supply_temperature: f64 = Variable::parameter(1017, "supplyTemperature", units::KELVIN, 293.15).range(100.0, 1000.0).shown_in("degC").tunable()
            .text("Temperature of the supplied air");
        heat_transfer: f64 = Variable::parameter(1018, "thermal.heatTransfer", units::WATT_PER_SQUARE_METRE_KELVIN, 60.0).range(0.0, 1e5).tunable()
            .text("Heat transfer coefficient between gas and wall, which is at ambient temperature");
        thermal_model: f64 = Variable::choice(1019, "thermal.model", &THERMAL_MODELS, 1)
            .text("How the gas temperature follows");
        exponent: f64 = Variable::parameter(1020, "thermal.exponent", units::ONE, 1.2).range(1.0, 2.0)
            .text("Polytropic exponent of the model Polytropic");
        incline: f64 = Variable::parameter(1021, "incline", units::RADIAN, 0.0).range(-PI / 2.0, PI / 2.0).shown_in("deg")
            .text("Inclination of the axis; positive: outstroke is uphill");
        wire_force: f64 = Variable::parameter(1022, "wireForce", units::NEWTON, 0.0).range(-1e4, 1e4).tunable()
            .text("Retracting force of the position transducer's wire, towards -x");
        piston_leakage: f64 = Variable::parameter(1023, "piston.leakage", units::KILOGRAM_PER_SECOND_SQUARE_PASCAL, 0.0).range(0.0, 1e-10)
            .text("Laminar leakage coefficient between the chambers");
        valve_conductance: f64 = Variable::parameter(1024, "valve.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 3.93e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)").tunable()
            .text("Sonic conductance of a fully open metering edge");
        valve_ratio: f64 = Variable::parameter(1025, "valve.b", units::ONE, 0.3).range(0.0, 0.99).tunable()
            .text("Critical pressure ratio of the metering edges");
        dead_zone: f64 = Variable::parameter(1026, "valve.deadZone", units::ONE, 0.08).range(0.0, 0.9).tunable()
            .text("Dead zone (overlap) of the metering edges as a fraction of the spool travel");
        leakage: f64 = Variable::parameter(1027, "valve.leakage", units::ONE, 0.002).range(0.0, 1.0).tunable()
            .text("Opening of a closed metering edge as a fraction of the full opening");
        bandwidth: f64 = Variable::parameter(1028, "valve.bandwidth", units::HERTZ, 115.0).range(0.1, 1e4)
            .text("Natural frequency of the spool");
        damping: f64 = Variable::parameter(1029, "valve.damping", units::ONE, std::f64::consts::FRAC_1_SQRT_2).range(0.01, 100.0)
            .text("Damping ratio of the spool");
        hysteresis: f64 = Variable::parameter(1030, "valve.hysteresis", units::ONE, 0.004).range(0.0, 1.0)
            .text("Half width of the play between command and spool set point");
        polarity: f64 = Variable::count(1031, "valve.polarity", 1).range(-1.0, 1.0)
            .text("1: more than 5 V feeds chamber A; -1: chamber B");
        actuation: f64 = Variable::choice(1032, "actuation", &ACTUATIONS, 1)
            .text("What moves the cylinder");
        regulator_min: f64 = Variable::parameter(1033, "regulator.pMin", units::PASCAL, 1.5e5).range(1e3, 1e8).shown_in("bar")
            .text("Absolute pressure of the regulator at 0 V");
        regulator_max: f64 = Variable::parameter(1034, "regulator.pMax", units::PASCAL, 10e5).range(1e3, 1e8).shown_in("bar")
            .text("Absolute pressure of the regulator at 10 V");
        regulator_lag: f64 = Variable::parameter(1035, "regulator.tau", units::SECOND, 0.02).range(1e-5, 100.0).shown_in("ms")
            .text("Time constant of the regulator");
        regulator_conductance: f64 = Variable::parameter(1036, "regulator.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 4e-9).range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance between regulator and chamber A");
        regulator_ratio: f64 = Variable::parameter(1037, "regulator.b", units::ONE, 0.3).range(0.0, 0.99)
            .text("Critical pressure ratio between regulator and chamber A");
        kappa_a: f64 = Variable::parameter(1038, "friction.kappaA", units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).shown_in("1/bar").tunable()
            .text("Growth of the friction levels with the pressure in chamber A above ambient");
        kappa_b: f64 = Variable::parameter(1039, "friction.kappaB", units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).shown_in("1/bar").tunable()
            .text("Growth of the friction levels with the pressure in chamber B above ambient");
    }
}

impl Parameters {
    /// Refuses combinations without a meaning.
    fn check(&self) -> Result<(), ParameterError> {
        let refuse = |name: &str, value: f64, reason: String| Err(ParameterError::new(name, value, &reason));
        if self.rod >= self.bore {
            return refuse("cylinder.rod", self.rod, format!("it must be smaller than cylinder.bore = {}", self.bore));
        }
        if self.position0 > self.stroke {
            return refuse("position0", self.position0, format!("it must not exceed cylinder.stroke = {}", self.stroke));
        }
        if self.carriage_mass > self.moving_mass {
            let reason = format!("it must not exceed mass.moving = {}", self.moving_mass);
            return refuse("mass.carriage", self.carriage_mass, reason);
        }
        if self.polarity == 0.0 {
            return refuse("valve.polarity", self.polarity, "it must be 1 or -1".to_owned());
        }
        if self.regulator_max < self.regulator_min {
            let reason = format!("it must not be below regulator.pMin = {}", self.regulator_min);
            return refuse("regulator.pMax", self.regulator_max, reason);
        }
        Ok(())
    }
}

/// What feeds the chambers; both rigs use the first two states.
#[derive(Clone, Copy, Debug)]
enum Actuator {
    /// States: spool velocity and spool.
    Valve(Valve, Orifice),
    /// States: unused, and pressure behind the regulator.
    Regulator(Regulator, Orifice),
}

/// The equations of the cylinder for given parameters.
#[derive(Clone, Debug)]
pub struct PneumaticServoCylinder {
    p: Parameters,
    actuator: Actuator,
    chamber_a: Chamber,
    chamber_b: Chamber,
    rod_area: f64,
    stops: EndStops,
    friction: Friction,
    /// Constant part of the applied force in N: wire and weight.
    dead_load: f64,
    /// Weight of the carriage along the axis in N.
    carriage_weight: f64,
}

/// Modes and memories of the cylinder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Set point of the spool: the state of the valve's hysteresis.
    set_point: f64,
    friction: friction::Memory,
}

// The order of the states keeps the elimination of the implicit scheme sparse: a chain from the spool over the
// chambers and the bristles to the motion.
const ACTUATOR_RATE: usize = 0;
const ACTUATOR: usize = 1;
const TEMPERATURE_A: usize = 2;
const PRESSURE_A: usize = 3;
const TEMPERATURE_B: usize = 4;
const PRESSURE_B: usize = 5;
const BRISTLES: usize = 6;
/// Position and velocity come last.
const fn position(n: usize) -> usize {
    n - 2
}
const fn velocity(n: usize) -> usize {
    n - 1
}
const STATES_WITHOUT_BRISTLES: usize = 8;

/// Starts a run with as many states as the friction law needs.
fn start(start: &Start) -> Result<Box<dyn Simulation>, ParameterError> {
    let (equations, _) = build(start)?;
    match STATES_WITHOUT_BRISTLES + equations.friction.states() {
        ..=8 => Ok(Box::new(equations.run::<8>(start)?)),
        9 => Ok(Box::new(equations.run::<9>(start)?)),
        10 => Ok(Box::new(equations.run::<10>(start)?)),
        ..=12 => Ok(Box::new(equations.run::<12>(start)?)),
        _ => Ok(Box::new(equations.run::<18>(start)?)),
    }
}

fn build(start: &Start) -> Result<(PneumaticServoCylinder, Settings), ParameterError> {
    let (own, rest) = start.parameters.split_at(Parameters::LEN);
    let (friction, tuning) = rest.split_at(rest.len() - Tuning::LEN);
    let settings = Settings::new(&Tuning::read(tuning), start.tolerance);
    let parameters = Parameters::read(own);
    parameters.check()?;
    Ok((PneumaticServoCylinder::new(parameters, Friction::new(friction, "friction")?), settings))
}

impl PneumaticServoCylinder {
    fn new(p: Parameters, friction: Friction) -> Self {
        let area = |diameter: f64| PI * diameter * diameter / 4.0;
        let chamber = |area: f64, dead_volume: f64, pressure0: f64| Chamber {
            area,
            bore: p.bore,
            dead_volume,
            ambient_temperature: p.ambient_temperature,
            thermal: match p.thermal_model as i32 {
                2 => Thermal::Polytropic { exponent: 1.0, reference_pressure: pressure0 },
                3 => Thermal::Polytropic { exponent: p.exponent, reference_pressure: pressure0 },
                _ => Thermal::EnergyBalance { heat_transfer: p.heat_transfer },
            },
        };
        let actuator = if p.actuation == 2.0 {
            let regulator = Regulator {
                min_pressure: p.regulator_min,
                max_pressure: p.regulator_max,
                time_constant: p.regulator_lag,
                conductance: p.regulator_conductance,
            };
            Actuator::Regulator(regulator, Orifice::new(p.regulator_ratio))
        } else {
            let valve = Valve {
                conductance: p.valve_conductance,
                dead_zone: p.dead_zone,
                leakage: p.leakage,
                bandwidth: p.bandwidth,
                damping: p.damping,
                hysteresis: p.hysteresis,
                polarity: p.polarity,
            };
            Actuator::Valve(valve, Orifice::new(p.valve_ratio))
        };
        let slope = GRAVITY * libm::sin(p.incline);
        Self {
            actuator,
            chamber_a: chamber(area(p.bore), p.dead_volume_a, p.pressure0_a),
            chamber_b: chamber(area(p.bore) - area(p.rod), p.dead_volume_b + p.tank_volume, p.pressure0_b),
            rod_area: area(p.rod),
            stops: EndStops { stroke: p.stroke, stiffness: p.stop_stiffness, damping: p.stop_damping },
            friction,
            dead_load: p.wire_force + p.moving_mass * slope,
            carriage_weight: p.carriage_mass * slope,
            p,
        }
    }

    fn run<const N: usize>(&self, start: &Start) -> Result<Simulator<Self, N, 3>, ParameterError> {
        let u: [f64; 3] = std::array::from_fn(|i| start.inputs[i]);
        let mut x = [0.0; N];
        x[position(N)] = self.p.position0;
        x[velocity(N)] = self.p.velocity0;
        (x[PRESSURE_A], x[PRESSURE_B]) = (self.p.pressure0_a, self.p.pressure0_b);
        (x[TEMPERATURE_A], x[TEMPERATURE_B]) = (self.p.ambient_temperature, self.p.ambient_temperature);
        let set_point = match self.actuator {
            Actuator::Valve(valve, _) => valve.initial_play(valve.command(u[0])),
            Actuator::Regulator(regulator, _) => {
                x[ACTUATOR] = regulator.command(u[0]);
                0.0
            }
        };
        let contact = self.contact(start.time, &x, &u, x[velocity(N)]);
        let mut bristles = [0.0; friction::MAX_STATES];
        let friction = self.friction.start(&contact, &mut bristles);
        let count = self.friction.states();
        x[BRISTLES..BRISTLES + count].copy_from_slice(&bristles[..count]);
        Simulator::new(build, start, x, Memory { set_point, friction })
    }

    /// Force on the moving mass other than friction in N, and the stops' part of it.
    fn applied_force<S: Scalar, const N: usize>(&self, x: &[S; N], u: &[S; 3], rate: S) -> (S, S) {
        let stop = self.stops.force(x[position(N)], rate);
        (self.pressure_force(x) + u[1] - self.dead_load + stop, stop)
    }

    fn pressure_force<S: Scalar, const N: usize>(&self, x: &[S; N]) -> S {
        x[PRESSURE_A] * self.chamber_a.area
            - x[PRESSURE_B] * self.chamber_b.area
            - self.p.ambient_pressure * self.rod_area
    }

    /// The factor `lambda` of the friction levels.
    fn load_level<S: Scalar, const N: usize>(&self, x: &[S; N]) -> S {
        let excess = |pressure: S, kappa: f64| (pressure - self.p.ambient_pressure) * kappa;
        let level = excess(x[PRESSURE_A], self.p.kappa_a) + excess(x[PRESSURE_B], self.p.kappa_b) + 1.0;
        level.max(S::zero())
    }

    /// The contact as the friction law sees it, for a velocity of the carriage.
    fn contact<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], u: &[S; 3], rate: S) -> Contact<S> {
        Contact {
            time,
            position: x[position(N)],
            velocity: x[velocity(N)],
            applied: self.applied_force(x, u, rate).0,
            level: self.load_level(x),
            drive: Drive::Force,
        }
    }

    /// Velocity of the carriage: the state, unless the friction law holds the position.
    fn rate<S: Scalar, const N: usize>(&self, x: &[S; N], memory: &Memory) -> S {
        if self.friction.holds_position(&memory.friction) { S::zero() } else { x[velocity(N)] }
    }

    /// Set point of the spool under the present command.
    fn set_point<S: Scalar>(valve: &Valve, u: &[S; 3], memory: &Memory) -> S {
        valve.play(memory.set_point, valve.command(u[0]))
    }

    /// Rates of the gas in both chambers at a velocity of the carriage.
    fn gas_rates<S: Scalar, const N: usize>(&self, x: &[S; N], u: &[S; 3], rate: S) -> [ChamberRates<S>; 2] {
        let gas_a = self.chamber_a.gas(x[PRESSURE_A], x[TEMPERATURE_A]);
        let gas_b = self.chamber_b.gas(x[PRESSURE_B], x[TEMPERATURE_B]);
        let still = Flow { mass: S::zero(), temperature: S::constant(self.p.ambient_temperature) };
        let (length_a, length_b) = (x[position(N)], -x[position(N)] + self.p.stroke);
        let supply_temperature = S::constant(self.p.supply_temperature);
        let flows_a;
        let flows_b;
        match &self.actuator {
            Actuator::Valve(valve, orifice) => {
                let supply = GasState { pressure: u[2], temperature: supply_temperature };
                let exhaust = GasState {
                    pressure: S::constant(self.p.ambient_pressure),
                    temperature: S::constant(self.p.ambient_temperature),
                };
                let (extending, retracting) = (valve.edge(x[ACTUATOR]), valve.edge(-x[ACTUATOR]));
                flows_a = [orifice.flow(extending, supply, gas_a), orifice.flow(retracting, exhaust, gas_a)];
                flows_b = [orifice.flow(retracting, supply, gas_b), orifice.flow(extending, exhaust, gas_b)];
            }
            Actuator::Regulator(regulator, orifice) => {
                let reservoir = GasState { pressure: x[ACTUATOR], temperature: supply_temperature };
                let conductance = S::constant(regulator.conductance);
                flows_a = [orifice.flow(conductance, reservoir, gas_a), still];
                flows_b = [still, still];
            }
        }
        let across = self.piston_leak(gas_a, gas_b);
        let back = Flow { mass: -across.mass, ..across };
        [
            self.chamber_a.rates(gas_a, length_a, rate, [flows_a[0], flows_a[1], back]),
            self.chamber_b.rates(gas_b, length_b, -rate, [flows_b[0], flows_b[1], across]),
        ]
    }

    /// Laminar leakage from chamber A to chamber B past the piston seal.
    fn piston_leak<S: Scalar>(&self, a: GasState<S>, b: GasState<S>) -> Flow<S> {
        let mass = (a.pressure * a.pressure - b.pressure * b.pressure) * self.p.piston_leakage;
        Flow { mass, temperature: if mass.value() >= 0.0 { a.temperature } else { b.temperature } }
    }

    /// Rates of the actuator's two states.
    fn actuator_rates<S: Scalar, const N: usize>(&self, x: &[S; N], u: &[S; 3], memory: &Memory) -> [S; 2] {
        match &self.actuator {
            Actuator::Valve(valve, _) => {
                let set_point = Self::set_point(valve, u, memory);
                [valve.spool_acceleration(set_point, x[ACTUATOR], x[ACTUATOR_RATE]), x[ACTUATOR_RATE]]
            }
            Actuator::Regulator(regulator, _) => {
                [S::zero(), regulator.pressure_rate(regulator.command(u[0]), x[ACTUATOR])]
            }
        }
    }
}

impl<const N: usize> HybridSystem<N, 3> for PneumaticServoCylinder {
    type Memory = Memory;

    fn derivatives<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; 3], memory: &Memory) -> [S; N] {
        let mut rates = [S::zero(); N];
        let rate = self.rate(x, memory);
        let contact = self.contact(time, x, u, rate);
        let bristles = BRISTLES..BRISTLES + self.friction.states();
        let force =
            self.friction.force(&contact, &x[bristles.clone()], &memory.friction, &mut rates[bristles]);
        [rates[ACTUATOR_RATE], rates[ACTUATOR]] = self.actuator_rates(x, u, memory);
        let [a, b] = self.gas_rates(x, u, rate);
        (rates[PRESSURE_A], rates[TEMPERATURE_A]) = (a.pressure, a.temperature);
        (rates[PRESSURE_B], rates[TEMPERATURE_B]) = (b.pressure, b.temperature);
        rates[position(N)] = rate;
        rates[velocity(N)] = (contact.applied - force) / self.p.moving_mass;
        rates
    }

    fn indicators(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &Memory, out: &mut Indicators) {
        let contact = self.contact(time, x, u, self.rate(x, memory));
        self.friction.indicators(&contact, &x[BRISTLES..position(N)], &memory.friction, out);
    }

    fn switch(&self, event: usize, time: f64, x: &mut [f64; N], u: &[f64; 3], memory: &mut Memory) {
        let contact = self.contact(time, x, u, self.rate(x, memory));
        let (bristles, motion) = x[BRISTLES..].split_at_mut(N - BRISTLES - 2);
        self.friction.switch(event, &contact, &mut motion[1], bristles, &mut memory.friction);
    }

    fn follow(&self, time: f64, x: &[f64; N], u: &[f64; 3], memory: &mut Memory) {
        if let Actuator::Valve(valve, _) = &self.actuator {
            memory.set_point = Self::set_point(valve, u, memory);
        }
        let contact = self.contact(time, x, u, self.rate(x, memory));
        self.friction.follow(&contact, &x[BRISTLES..position(N)], &mut memory.friction);
    }

    fn next_sample(&self, memory: &Memory) -> f64 {
        self.friction.next_sample(&memory.friction)
    }

    fn sample(&self, time: f64, x: &mut [f64; N], u: &[f64; 3], memory: &mut Memory) {
        let contact = self.contact(time, x, u, self.rate(x, memory));
        self.friction.sample(&contact, &x[BRISTLES..position(N)], &mut memory.friction);
    }

    fn is_admissible(&self, x: &[f64; N]) -> bool {
        let length_b = self.p.stroke - x[position(N)];
        let volumes = [self.chamber_a.volume(x[position(N)]), self.chamber_b.volume(length_b)];
        let gases = [PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B].map(|index| x[index]);
        volumes.iter().chain(&gases).all(|value| *value > 0.0)
    }

    fn scales(&self) -> [f64; N] {
        let mut scales = [self.friction.state_scale(); N];
        scales[ACTUATOR_RATE] = 30.0 * self.p.bandwidth;
        scales[ACTUATOR] = 30.0;
        (scales[PRESSURE_A], scales[PRESSURE_B]) = (1e5, 1e5);
        (scales[TEMPERATURE_A], scales[TEMPERATURE_B]) = (300.0, 300.0);
        scales[position(N)] = 0.1;
        scales[velocity(N)] = 0.1;
        scales
    }

    fn fits(&self, memory: &Memory) -> bool {
        memory.set_point.is_finite() && self.friction.owns(&memory.friction)
    }
}

impl<const N: usize> Equations<N, 3> for PneumaticServoCylinder {
    fn outputs<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; 3], memory: &Memory, computed: &mut [S]) {
        let held = self.friction.holds_position(&memory.friction);
        let rate = self.rate(x, memory);
        let contact = self.contact(time, x, u, rate);
        let count = self.friction.states();
        let bristles = &x[BRISTLES..BRISTLES + count];
        let mut bristle_rates = [S::zero(); friction::MAX_STATES];
        let friction_force =
            self.friction.force(&contact, bristles, &memory.friction, &mut bristle_rates[..count]);
        let acceleration =
            if held { S::zero() } else { (contact.applied - friction_force) / self.p.moving_mass };
        let [a, b] = self.gas_rates(x, u, rate);
        let [actuator_acceleration, actuator_rate] = self.actuator_rates(x, u, memory);
        let is_valve = matches!(self.actuator, Actuator::Valve(..));
        let of_valve = |value: S| if is_valve { value } else { S::zero() };
        let of_regulator = |value: S| if is_valve { S::zero() } else { value };
        let outputs = Outputs {
            position: x[position(N)],
            velocity: rate,
            acceleration,
            rod_force: acceleration * self.p.carriage_mass - u[1] + (self.p.wire_force + self.carriage_weight),
            pressure_force: self.pressure_force(x),
            friction_force,
            pressure_a: x[PRESSURE_A],
            pressure_b: x[PRESSURE_B],
            temperature_a: self.chamber_a.gas(x[PRESSURE_A], x[TEMPERATURE_A]).temperature,
            temperature_b: self.chamber_b.gas(x[PRESSURE_B], x[TEMPERATURE_B]).temperature,
            mass_flow_a: a.mass_flow,
            mass_flow_b: b.mass_flow,
            spool: of_valve(x[ACTUATOR]),
            sticking: S::constant(f64::from(self.friction.is_sticking(&memory.friction))),
            pressure_rate_a: a.pressure,
            temperature_rate_a: a.temperature,
            pressure_rate_b: b.pressure,
            temperature_rate_b: b.temperature,
            spool_velocity: of_valve(x[ACTUATOR_RATE]),
            spool_acceleration: of_valve(actuator_acceleration),
            regulator_pressure: of_regulator(x[ACTUATOR]),
            regulator_rate: of_regulator(actuator_rate),
            valve_command: match &self.actuator {
                Actuator::Valve(valve, _) => Self::set_point(valve, u, memory),
                Actuator::Regulator(..) => S::zero(),
            },
            stop_force: self.applied_force(x, u, rate).1,
            load_level: contact.level,
        };
        let unused = std::iter::repeat_n(S::zero(), friction::MAX_STATES - count);
        let states = bristles.iter().copied().chain(unused);
        let values = outputs.values().chain(states).chain(bristle_rates);
        computed.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
    }

    fn state_index(&self, place: usize) -> Option<usize> {
        let is_valve = matches!(self.actuator, Actuator::Valve(..));
        match place {
            0 => Some(position(N)),
            1 => Some(velocity(N)),
            2 => Some(PRESSURE_A),
            3 => Some(TEMPERATURE_A),
            4 => Some(PRESSURE_B),
            5 => Some(TEMPERATURE_B),
            6 => is_valve.then_some(ACTUATOR),
            7 => is_valve.then_some(ACTUATOR_RATE),
            8 => (!is_valve).then_some(ACTUATOR),
            bristle => (bristle - 9 < self.friction.states()).then_some(BRISTLES + bristle - 9),
        }
    }
}
