//! Inputs and states.

use super::parameters::Parameters;
use crate::pneumatics::actuator::{self, SUPPLY, VOLTAGE};
use crate::variables::{Variable, units};
use crate::{inputs, states};

/// Value reference of the external force.
pub const FORCE: u32 = 2;

inputs! {
    /// The inputs.
    Inputs {
        valve_voltage = Variable::input(VOLTAGE, "valveVoltage", units::VOLT, 5.0).nominal(5.0)
            .text("Valve voltage: 5 V closes the valve, more feeds chamber A, less chamber B; saturates at 0 and 10 V. Commands the regulator on the second rig");
        external_force = Variable::input(FORCE, "externalForce", units::NEWTON, 0.0).nominal(10.0)
            .text("External force on the carriage towards +x");
        supply_pressure = Variable::input(SUPPLY, "supplyPressure", units::PASCAL, 5e5).at_least(0.0).nominal(1e5).shown_in("bar")
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
