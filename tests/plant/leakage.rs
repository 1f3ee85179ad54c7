//! Leaks of the chambers to the surroundings, against the closed form of a chamber that empties while its leak is choked:
//! `p = p0*exp(-C*rho0*R*T*t/V)` at the reference temperature.

use crate::bounds::{close, within};
use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

/// `rho0*R*T0` in Pa.
const REFERENCE: f64 = 1.185 * 287.05 * 293.15;
/// Dead volume of each chamber in m3.
const DEAD: f64 = 1.0;

/// Large chambers at 6 bar with the piston held, isothermal gas, a tight valve that is closed.
fn tight() -> Setup {
    let setup = Setup::new(&MODEL).set("friction.law", "CoulombStiction").unwrap().tolerance(1e-10);
    let mut setup = setup.set("thermal.model", "Isothermal").unwrap();
    for (name, value) in [
        ("friction.coulombStiction.Fs", 1e6),
        ("valve.leakage", 0.0),
        ("chamberA.pressure0", 6e5),
        ("chamberB.pressure0", 6e5),
        ("chamberA.deadVolume", DEAD),
        ("chamberB.deadVolume", DEAD),
    ] {
        setup.change(name, value).unwrap();
    }
    setup
}

/// Pressures in both chambers.
fn pressures(plant: &Plant) -> [f64; 2] {
    ["chamberA.pressure", "chamberB.pressure"].map(|name| plant.get(name).unwrap())
}

/// Volumes in m3 of both chambers at half the stroke, with a bore of 16 mm and a rod of 6 mm.
fn volumes() -> [f64; 2] {
    let area = |diameter: f64| std::f64::consts::PI * diameter * diameter / 4.0;
    [area(0.016), area(0.016) - area(0.006)].map(|area| DEAD + area * 0.25)
}

#[test]
fn leaking_chamber_empties_as_its_closed_form() {
    let mut plant =
        tight().set("chamberA.leakage", 5e-7).unwrap().set("chamberB.leakage", 1e-7).unwrap().start(0.0).unwrap();
    plant.advance_to(2.0).unwrap();
    for ((found, volume), leak) in pressures(&plant).into_iter().zip(volumes()).zip([5e-7, 1e-7]) {
        let expected = 6e5 * (-leak * REFERENCE * 2.0 / volume).exp();
        close(found / expected, 1.0, 1e-8, format_args!("{found} Pa, not {expected}"));
    }
}

/// Down to the pressure around it, and no further; one below it fills.
#[test]
fn leaking_chambers_come_to_ambient_pressure() {
    let setup = tight().set("chamberA.leakage", 1e-5).unwrap().set("chamberB.leakage", 1e-5).unwrap();
    let mut plant = setup.set("chamberB.pressure0", 2e4).unwrap().start(0.0).unwrap();
    plant.advance_to(20.0).unwrap();
    for pressure in pressures(&plant) {
        close(pressure, 101_325.0, 1e-6, "ambient pressure");
    }
}

/// A fault that begins in a run, and how a tight chamber would change with one.
#[test]
fn leak_begins_in_a_run_and_has_a_derivative_where_there_is_none() {
    let mut plant = tight().start(0.0).unwrap();
    plant.carry_sensitivities(&["chamberA.leakage"]).unwrap();
    plant.advance_to(0.5).unwrap();
    assert_eq!(plant.get("chamberA.pressure").unwrap(), 6e5, "no leak yet");
    let place = plant.table().computed().position(|variable| variable.name == "chamberA.pressure").unwrap();
    let [volume, _] = volumes();
    let slope = plant.sensitivities(0).unwrap()[place];
    close(slope / (-REFERENCE * 0.5 / volume * 6e5), 1.0, 1e-8, "derivative of the pressure by the leak");
    plant.set("chamberA.leakage", 5e-7).unwrap();
    plant.advance_to(1.5).unwrap();
    let [found, other] = pressures(&plant);
    let expected = 6e5 * (-5e-7 * REFERENCE / volume).exp();
    close(found / expected, 1.0, 1e-8, format_args!("{found} Pa, not {expected}"));
    assert_eq!(other, 6e5, "the other chamber stays tight");
}

/// Mass and energy balance with leaks, with hoses, under every actuator.
#[test]
fn balances_close_with_leaks() {
    for (actuation, hose) in
        [("ProportionalValve", 0.0), ("ProportionalValve", 1.0), ("PressureRegulator", 0.0), ("SwitchingValves", 1.0)]
    {
        let mut setup = Setup::new(&MODEL).set("actuation", actuation).unwrap().set("balance.enabled", true).unwrap();
        for (name, value) in [
            ("chamberA.leakage", 2e-10),
            ("chamberB.leakage", 1e-10),
            ("piston.leakage", 1e-16),
            ("hoseA.length", hose),
            ("valveVoltage", 7.0),
        ] {
            setup.change(name, value).unwrap();
        }
        let mut plant = setup.start(0.0).unwrap();
        for step in 1..=100 {
            plant.set("valveVoltage", if step % 20 < 10 { 7.0 } else { 3.0 }).unwrap();
            plant.advance_to(f64::from(step) * 1e-2).unwrap();
        }
        let [mass, energy] = ["mass", "energy"].map(|name| plant.get(&format!("balance.{name}Residual")).unwrap());
        within(mass.abs(), 2e-9, format_args!("kg under {actuation}, hose of {hose} m"));
        within(energy.abs(), 1e-3, format_args!("J under {actuation}, hose of {hose} m"));
    }
}
