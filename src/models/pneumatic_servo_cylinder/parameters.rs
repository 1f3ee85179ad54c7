//! The parameters of the rig.

use std::f64::consts::PI;

use super::motion::Motion;
use crate::parameters;
use crate::pneumatics::chamber::ThermalModel;
use crate::variables::{Condition, Fixed, Following, ParameterError, Tunable, Variable, units};

parameters! {
    /// The parameters of the rig; the friction law's and the solver's follow in the table.
    Parameters {
        bore: Fixed = Variable::parameter(1001, "cylinder.bore", units::METRE, 0.016).range(1e-4, 1.0).shown_in("mm")
            .text("Bore diameter");
        rod: Fixed = Variable::parameter(1002, "cylinder.rod", units::METRE, 0.006).range(0.0, 1.0).shown_in("mm")
            .text("Rod diameter, smaller than the bore");
        stroke: Fixed = Variable::parameter(1003, "cylinder.stroke", units::METRE, 0.5).range(1e-3, 10.0).shown_in("mm")
            .text("Stroke");
        stop_stiffness: Fixed = Variable::parameter(1004, "cylinder.stopStiffness", units::NEWTON_PER_METRE, 1e6).range(1e3, 1e10).plausible(1e4, 1e10)
            .text("Contact stiffness of the end stops");
        stop_damping: Fixed = Variable::parameter(1005, "cylinder.stopDamping", units::SECOND_PER_METRE, 0.75).range(0.0, 1e3)
            .text("Dissipation coefficient of the end stops (Hunt-Crossley)");
        dead_volume_a: Fixed = Variable::parameter(1006, "chamberA.deadVolume", units::CUBIC_METRE, 5e-6).range(1e-8, 1.0).plausible(1e-8, 2e-3).shown_in("cm3")
            .text("Dead volume of chamber A, hose included");
        dead_volume_b: Fixed = Variable::parameter(1007, "chamberB.deadVolume", units::CUBIC_METRE, 5e-6).range(1e-8, 1.0).plausible(1e-8, 2e-3).shown_in("cm3")
            .text("Dead volume of chamber B, hose included");
        pressure0_a: Fixed = Variable::parameter(1008, "chamberA.pressure0", units::PASCAL, 101_325.0).counts_where(Condition::off("chamberA.open")).range(1e3, 1e8).shown_in("bar")
            .text("Initial absolute pressure in chamber A");
        pressure0_b: Fixed = Variable::parameter(1009, "chamberB.pressure0", units::PASCAL, 101_325.0).counts_where(Condition::off("chamberB.open")).range(1e3, 1e8).shown_in("bar")
            .text("Initial absolute pressure in chamber B");
        tank_volume: Fixed = Variable::parameter(1010, "chamberB.tankVolume", units::CUBIC_METRE, 0.0).range(0.0, 1.0).plausible(1e-8, 0.1).absent_at_zero().shown_in("cm3")
            .text("Volume of a tank connected to chamber B, a cylinder twice as long as wide");
        moving_mass: Fixed = moved_by_forces(Variable::parameter(1011, "mass.moving", units::KILOGRAM, 0.88)).range(1e-5, 1e4)
            .text("Moving mass: piston, rod, load cell and carriage");
        carriage_mass: Fixed = Variable::parameter(1012, "mass.carriage", units::KILOGRAM, 0.75).follows("mass.moving", Following::Whole).counts_where(Condition::is("motion", &[Motion::Free])).range(0.0, 1e4)
            .text("Part of the moving mass on the load's side of the load cell");
        position0: Fixed = Variable::parameter(1013, "position0", units::METRE, 0.25).follows("cylinder.stroke", Following::InProportion).counts_where(Condition::is("motion", &[Motion::Free])).range(0.0, 10.0).shown_in("mm")
            .text("Initial position, within the stroke");
        velocity0: Fixed = Variable::parameter(1014, "velocity0", units::METRE_PER_SECOND, 0.0).counts_where(Condition::is("motion", &[Motion::Free])).range(-100.0, 100.0).plausible(-10.0, 10.0).shown_in("mm/s")
            .text("Initial velocity");
        ambient_pressure: Fixed = Variable::parameter(1015, "ambientPressure", units::PASCAL, 101_325.0).range(1e3, 1e7).shown_in("bar")
            .text("Absolute ambient pressure, also behind the exhaust");
        ambient_temperature: Fixed = Variable::parameter(1016, "ambientTemperature", units::KELVIN, 293.15).range(100.0, 1000.0).shown_in("degC")
            .text("Ambient and initial gas temperature");
        supply_temperature: Tunable = Variable::parameter(1017, "supplyTemperature", units::KELVIN, 293.15).range(100.0, 1000.0).shown_in("degC")
            .text("Temperature of the supplied gas");
        heat_transfer: Tunable = Variable::parameter(1018, "thermal.heatTransfer", units::WATT_PER_SQUARE_METRE_KELVIN, 60.0).counts_where(Condition::is("thermal.model", &[ThermalModel::EnergyBalance])).range(0.0, 1e5)
            .text("Heat transfer coefficient between gas and wall, which is at ambient temperature");
        thermal_model: ThermalModel = Variable::choice(1019, "thermal.model", ThermalModel::EnergyBalance)
            .text("Thermal model of the gas in the chambers");
        exponent: Fixed = Variable::parameter(1020, "thermal.exponent", units::ONE, 1.2).counts_where(Condition::is("thermal.model", &[ThermalModel::Polytropic, ThermalModel::PolytropicServo])).range(1.0, 2.0)
            .text("Polytropic exponent");
        incline: Fixed = moved_by_forces(Variable::parameter(1021, "incline", units::RADIAN, 0.0)).range(-PI / 2.0, PI / 2.0).shown_in("deg")
            .text("Inclination of the axis; positive: extending is uphill");
        wire_force: Tunable = Variable::parameter(1022, "wireForce", units::NEWTON, 0.0).range(-1e4, 1e4)
            .text("Retracting force of the position transducer's wire, towards -x");
        piston_leakage: Fixed = Variable::parameter(1023, "piston.leakage", units::KILOGRAM_PER_SECOND_SQUARE_PASCAL, 0.0).range(0.0, 1e-10)
            .text("Laminar leakage coefficient between the chambers, for air");
        kappa_a: Tunable = Variable::parameter(1038, "friction.kappaA", units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).shown_in("1/bar")
            .text("Pressure dependence: increase of the load factor of friction per pressure in chamber A above ambient");
        kappa_b: Tunable = Variable::parameter(1039, "friction.kappaB", units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).shown_in("1/bar")
            .text("Pressure dependence: increase of the load factor of friction per pressure in chamber B above ambient");
        keeps_balance: bool = Variable::option(1040, "balance.enabled", false)
            .text("Keep account of mass and energy, for balance.massResidual and balance.energyResidual; makes steps a fifth slower");
    }
}

/// A variable of a carriage that moves by forces, not rigidly as imposed.
fn moved_by_forces(variable: Variable) -> Variable {
    variable.counts_where(Condition::is("motion", &[Motion::Free]).or(Condition::on("coupling.compliance")))
}

impl Parameters {
    /// Refuses combinations without a meaning.
    pub fn check(&self) -> Result<(), ParameterError> {
        let refuse = |name: &str, value: f64, reason: String| Err(ParameterError::new(name, value, &reason));
        let of = [self.rod, self.bore, self.position0, self.stroke, self.carriage_mass, self.moving_mass];
        let [rod, bore, position0, stroke, carriage_mass, moving_mass] = of.map(|it| it.value);
        if rod >= bore {
            return refuse("cylinder.rod", rod, format!("it must be smaller than cylinder.bore = {bore}"));
        }
        if position0 > stroke {
            return refuse("position0", position0, format!("it must not exceed cylinder.stroke = {stroke}"));
        }
        if carriage_mass > moving_mass {
            return refuse("mass.carriage", carriage_mass, format!("it must not exceed mass.moving = {moving_mass}"));
        }
        Ok(())
    }
}
