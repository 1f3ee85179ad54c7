//! The variable table of the cylinder.

use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::co_simulation::counters_table;
use crate::friction::Friction;
use crate::models::bristles::bristle_table;
use crate::pneumatics::chamber::THERMAL_MODELS;
use crate::solver::Tuning;
use crate::variables::{Enumeration, ParameterError, ParameterSet, Table, Variable, units};
use crate::{outputs, parameters};

/// Conserved quantities: mass and energy.
pub const RESIDUALS: usize = 2;

/// Value reference of the first variable of the friction law.
const FRICTION_BASE: u32 = 10_000;
/// Value reference of the first parameter of the solver.
const SOLVER_BASE: u32 = 5_000;
/// Value reference of the first counter of the solver.
const COUNTERS_BASE: u32 = 5_100;
/// Value reference of the first bristle state; its derivatives follow.
const BRISTLE_BASE: u32 = 400;

/// Every variable of the cylinder.
pub static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let mut table = vec![Variable::time()];
    table.extend(Inputs::table());
    table.extend(Outputs::<f64>::table());
    table.extend(bristle_table("friction", BRISTLE_BASE, depends::MOTION));
    table.extend(residuals_table());
    table.extend(counters_table(COUNTERS_BASE));
    table.extend(Parameters::table());
    table.extend(Friction::table("friction", FRICTION_BASE, 7));
    table.extend(Tuning::grouped(SOLVER_BASE));
    Table::new(table)
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
    // The laminar leakage past the piston depends on both pressures and on the temperature upstream.
    /// What the mass flow into chamber A depends on.
    pub const FLOW_A: &[u32] = &[SUPPLY, P_A, P_B, T_A, T_B, SPOOL, REGULATOR];
    /// What the mass flow into chamber B depends on.
    pub const FLOW_B: &[u32] = &[SUPPLY, P_A, P_B, T_A, T_B, SPOOL];
    /// What the rates of chamber A depend on.
    pub const GAS_A: &[u32] = &[SUPPLY, X, V, P_A, P_B, T_A, T_B, SPOOL, REGULATOR];
    /// What the rates of chamber B depend on.
    pub const GAS_B: &[u32] = &[SUPPLY, X, V, P_A, P_B, T_A, T_B, SPOOL];
    /// What friction and acceleration depend on.
    pub const MOTION: &[u32] = &[FORCE, X, V, P_A, P_B, Z[0], Z[1], Z[2], Z[3], Z[4], Z[5], Z[6], Z[7], Z[8], Z[9]];
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
            .depends_on(depends::FLOW_A)
            .text("Net mass flow into chamber A, leakage included");
        mass_flow_b = Variable::output(112, "chamberB.massFlow", units::KILOGRAM_PER_SECOND).nominal(1e-3).shown_in("l/min(ANR)")
            .depends_on(depends::FLOW_B)
            .text("Net mass flow into chamber B, leakage included");
        spool = Variable::output(113, "valve.spool", units::ONE).nominal(1.0)
            .depends_on(&[depends::SPOOL])
            .text("Spool position as a fraction of its travel, positive feeds chamber A; 0 on the rig with a regulator");
        sticking = Variable::flag(114, "sticking")
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the carriage");
        pressure_rate_a = Variable::output(207, "der(chamberA.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(107)
            .depends_on(depends::GAS_A)
            .text("Rate of the pressure in chamber A");
        temperature_rate_a = Variable::output(209, "der(chamberA.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(109)
            .depends_on(depends::GAS_A)
            .text("Rate of the temperature in chamber A");
        pressure_rate_b = Variable::output(208, "der(chamberB.pressure)", units::PASCAL_PER_SECOND).local().nominal(1e6).derivative_of(108)
            .depends_on(depends::GAS_B)
            .text("Rate of the pressure in chamber B");
        temperature_rate_b = Variable::output(210, "der(chamberB.temperature)", units::KELVIN_PER_SECOND).local().nominal(100.0).derivative_of(110)
            .depends_on(depends::GAS_B)
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

/// Residuals of the balances, in the order of the conserved quantities.
fn residuals_table() -> [Variable; RESIDUALS] {
    [
        Variable::output(213, "balance.massResidual", units::KILOGRAM).local().nominal(1e-3).shown_in("g")
            .text("Mass of the gas in both chambers beyond what was there at the start and has flowed in since: the error of the integration; 0 unless balance.enabled"),
        Variable::output(214, "balance.energyResidual", units::JOULE).local().nominal(1.0)
            .text("Energy of gas and carriage beyond what was there at the start and has flowed in since as enthalpy, heat and work; of the carriage alone unless thermal.model = EnergyBalance; 0 unless balance.enabled"),
    ]
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
        keeps_balance: f64 = Variable::option(1040, "balance.enabled", false)
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
            return refuse(
                "position0",
                self.position0,
                format!("it must not exceed cylinder.stroke = {}", self.stroke),
            );
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
