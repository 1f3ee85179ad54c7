//! Temperatures, pressures, forces and start values of the cylinder, each where it differs from every other.

use crate::bounds::{close, within};
use crate::rig::{Rig, Running};

const GAS_CONSTANT: f64 = 287.05;
const GAMMA: f64 = 1.4;
const AMBIENT: f64 = 293.15;
/// Conductance in m3/(s Pa), a tenth of the default, so that flows stay choked for long.
const CONDUCTANCE: f64 = 3.93e-10;
/// Volume in m3 of chamber A at the start.
const VOLUME: f64 = 5e-6 + std::f64::consts::PI / 4.0 * 0.016 * 0.016 * 0.25;

/// A piston that no pressure moves, tight valve without dead zone, no heat through the walls.
fn held() -> Rig {
    Rig::cylinder("CoulombStiction")
        .set("friction.coulombStiction.Fs", 1e6)
        .set("valve.deadZone", 0.0)
        .set("valve.leakage", 0.0)
        .set("valve.C", CONDUCTANCE)
        .set("thermal.heatTransfer", 0.0)
        .set("solver.relativeTolerance", 1e-10)
}

fn started(rig: &Rig, time: f64) -> Running {
    let mut running = rig.start().expect("legal parameters");
    running.advance(time).expect("a bounded solution");
    running
}

#[track_caller]
fn assert_close(found: f64, expected: f64, relative: f64) {
    close(found / expected, 1.0, relative, format_args!("{found}, not {expected}"));
}

/// Choked inflow falls with the root of the supply's temperature (ISO 6358, reference 293.15 K), and brings the enthalpy
/// of that temperature: `dp/dt = gamma*R*T_s*mdot/V`. After 30 ms the spool has arrived, so that only rounding is left.
#[test]
fn supply_fills_with_air_of_its_own_temperature() {
    for temperature in [250.0, 350.0] {
        let rig = held().set("valveVoltage", 10.0).set("supplyPressure", 8e5).set("supplyTemperature", temperature);
        let mut running = started(&rig, 0.03);
        let flow = CONDUCTANCE * 8e5 * 1.185 * (AMBIENT / temperature).sqrt();
        assert_close(running.get("chamberA.massFlow"), flow, 1e-14);
        let rate = GAMMA * GAS_CONSTANT * temperature * flow / VOLUME;
        assert_close(running.get("der(chamberA.pressure)"), rate, 1e-14);
    }
}

/// The outflow has the temperature of the chamber, so the remaining gas expands isentropically, however hot the supply.
#[test]
fn chamber_exhausts_gas_of_its_own_temperature() {
    let rig = held().set("chamberA.pressure0", 8e5).set("valveVoltage", 0.0).set("supplyTemperature", 500.0);
    let mut running = started(&rig, 0.03);
    for step in 4..=20 {
        running.advance(f64::from(step) * 0.01).unwrap();
        let [pressure, temperature] = ["chamberA.pressure", "chamberA.temperature"].map(|name| running.get(name));
        // The solver keeps the entropy of the gas but for rounding, over some hundred steps.
        assert_close(temperature, AMBIENT * (pressure / 8e5_f64).powf((GAMMA - 1.0) / GAMMA), 5e-14);
        let choked = -CONDUCTANCE * pressure * 1.185 * (AMBIENT / temperature).sqrt();
        assert_close(running.get("chamberA.massFlow"), choked, 1e-8);
    }
    assert!(running.get("chamberA.pressure") > 2.5e5, "choked to the end");
}

/// Walls are at ambient temperature: gas that nothing disturbs stays there, and hot gas returns there.
#[test]
fn walls_have_ambient_temperature_whatever_the_supply() {
    // Without play the spool comes back to the middle exactly.
    let rig = held().set("supplyTemperature", 400.0).set("thermal.heatTransfer", 60.0).set("valve.hysteresis", 0.0);
    assert_eq!(started(&rig, 1.0).get("chamberA.temperature"), AMBIENT);
    let mut running = started(&rig.set("valveVoltage", 10.0), 0.3);
    assert!(running.get("chamberA.temperature") > AMBIENT + 20.0);
    running.set("valveVoltage", 5.0);
    running.advance(60.0).unwrap();
    // Time constants of about a second.
    close(running.get("chamberA.temperature"), AMBIENT, 5e-12, "walls have ambient temperature whatever the supply");
}

/// Behind the exhaust is the ambient pressure of the place, high in the mountains too.
#[test]
fn exhaust_leads_to_ambient_pressure() {
    for ambient in [7e4, 1.2e5] {
        let rig = held().set("ambientPressure", ambient).set("chamberA.pressure0", 3e5).set("valveVoltage", 0.0);
        // The laminar part near equal pressures decays in milliseconds.
        assert_close(started(&rig, 60.0).get("chamberA.pressure"), ambient, 1e-14);
    }
}

/// The polytropic gas is at ambient temperature at its initial pressure, and its temperature changes as it says.
#[test]
fn polytropic_gas_starts_at_ambient_temperature_at_any_pressure() {
    let rig = Rig::cylinder("None").choose("thermal.model", "Polytropic").set("valve.leakage", 0.0);
    let rig = rig.set("chamberA.pressure0", 3e5).set("chamberB.pressure0", 2e5).set("solver.relativeTolerance", 1e-10);
    let mut running = rig.start().unwrap();
    assert_eq!(running.get("chamberA.temperature"), AMBIENT);
    let (step, mut time) = (1e-5, 0.02);
    running.advance(time).unwrap();
    let pressure = running.get("chamberA.pressure");
    // p and T of a polytropic change with the exponent 1.2.
    assert_close(running.get("chamberA.temperature"), AMBIENT * (pressure / 3e5).powf(0.2 / 1.2), 1e-14);
    let (before, rate) = (running.get("chamberA.temperature"), running.get("der(chamberA.temperature)"));
    time += step;
    running.advance(time).unwrap();
    let difference = (running.get("chamberA.temperature") - before) / step;
    assert!(rate.abs() > 100.0, "{rate} K/s");
    // A difference over a step of 1e-5 s, in which the rate itself changes by less.
    assert_close(difference, rate, 1e-3);
}

/// The orifices of valve and regulator have a critical pressure ratio each, without effect on the other.
#[test]
fn orifices_of_valve_and_regulator_have_their_own_critical_ratio() {
    // The flow is subsonic with the default ratio, and choked with the ratio of a nozzle.
    let flow = |actuation: &str, changed: Option<&str>| {
        let rig = Rig::cylinder("CoulombStiction").set("friction.coulombStiction.Fs", 1e6);
        let rig = changed.map_or(rig.clone(), |name| rig.set(name, 0.7));
        let rig = rig.choose("actuation", actuation).set("chamberA.pressure0", 2.8e5).set("valveVoltage", 10.0);
        started(&rig, 0.01).get("chamberA.massFlow").to_bits()
    };
    for (actuation, own, other) in
        [("ProportionalValve", "valve.b", "regulator.b"), ("PressureRegulator", "regulator.b", "valve.b")]
    {
        let usual = flow(actuation, None);
        assert_eq!(flow(actuation, Some(other)), usual, "{actuation}");
        assert_ne!(flow(actuation, Some(own)), usual, "{actuation}");
    }
}

/// At rest the load cell reads what pulls at the carriage: wire and external force, and its weight on an incline.
#[test]
fn rod_holds_the_carriage() {
    let rig = Rig::cylinder("CoulombStiction").set("friction.coulombStiction.Fs", 1e3);
    let rig = rig.set("wireForce", 3.0).set("externalForce", 5.0).set("incline", 0.1);
    let mut running = started(&rig, 0.1);
    assert_eq!(running.get("velocity"), 0.0);
    assert_close(running.get("rodForce"), 3.0 - 5.0 + 0.75 * 9.80665 * 0.1_f64.sin(), 1e-14);
}

/// A stop pushes back into the stroke with the force that presses the carriage against it.
#[test]
fn stops_push_towards_the_middle() {
    for (force, position) in [(200.0, 0.5), (-200.0, 0.0)] {
        let rig = Rig::cylinder("SmoothCoulomb").set("externalForce", force).set("position0", position);
        let mut running = started(&rig, 20.0);
        // The gas still settles, some micrometres a second.
        within(running.get("velocity").abs(), 5e-6, format_args!("{} m/s", running.get("velocity")));
        let expected = -(force + running.get("pressureForce") - running.get("frictionForce"));
        assert_close(running.get("cylinder.stopForce"), expected, 2e-10);
        assert!(expected * force < 0.0);
    }
}

/// The carriage starts with the velocity it is given, and is where that takes it.
#[test]
fn initial_velocity_moves_the_carriage() {
    let mut running = Rig::cylinder("None").set("velocity0", -0.2).start().unwrap();
    assert_eq!(running.get("velocity"), -0.2);
    running.advance(1e-3).unwrap();
    // Gas springs and viscous friction change the mean velocity by less than three in ten thousand within 1 ms.
    assert_close(running.get("position") - 0.25, -0.2e-3, 3e-4);
}
