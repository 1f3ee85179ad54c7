//! Switching valves under pulses, against closed forms and against the proportional valve that is their mean.

mod bounds;
mod rig;

use std::f64::consts::TAU;

use bounds::{close, farthest, largest};
use pneumatic_servo::conformance::Host;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use rig::{Rig, Running};

const CONDUCTANCE: f64 = 3.93e-9;
/// `R*T` in J/kg.
const GAS: f64 = 287.05 * 293.15;

/// Switching valves with the given values changed.
fn switched(law: &str, centre: &str, values: &[(&str, f64)]) -> Rig {
    let rig = Rig::cylinder(law).choose("actuation", "SwitchingValves").choose("switching.centre", centre);
    values.iter().fold(rig, |rig, (name, value)| rig.set(name, *value))
}

/// The piston held, gas at constant temperature, a chamber A as large as a room, so that choked flow stays choked.
fn filling(values: &[(&str, f64)]) -> Running {
    let held = [("friction.coulombStiction.Fs", 1e6), ("chamberA.deadVolume", 1.0), ("supplyPressure", 20e5)];
    switched("CoulombStiction", "Closed", &[&held, values].concat())
        .choose("thermal.model", "Isothermal")
        .start()
        .unwrap()
}

/// Choked, a pulse brings `C*p*rho0` times its length, more by what closing starts later than opening: the travels, of
/// the same length, make up for each other. Ten pulses of 4 ms.
#[test]
fn pulses_bring_what_their_length_says() {
    for (opening, closing, travel, open) in
        [(0.0, 0.0, 0.0, 4e-3), (1e-3, 1e-3, 5e-4, 4e-3), (2e-3, 1e-3, 1e-3, 3e-3), (5e-4, 2e-3, 7e-4, 5.5e-3)]
    {
        let delays = [("switching.openingDelay", opening), ("switching.closingDelay", closing)];
        let values = [&delays[..], &[("switching.travelTime", travel), ("valveVoltage", 7.0)]].concat();
        let mut running = filling(&values);
        let before = running.get("chamberA.pressure");
        running.advance(0.1).unwrap();
        let volume = 1.0 + 0.25 * std::f64::consts::PI * 0.016f64.powi(2) / 4.0;
        let expected = 10.0 * open * CONDUCTANCE * 20e5 * 1.185 * GAS / volume;
        let found = running.get("chamberA.pressure") - before;
        close(
            found / expected,
            1.0,
            5e-11,
            format_args!("{found} Pa, not {expected}, with delays {opening}, {closing}"),
        );
    }
}

/// 5 V: both chambers end at the pressure of the surroundings, or keep what they have.
#[test]
fn centre_vents_or_closes_both_chambers() {
    for (centre, expected) in [("Vented", 101_325.0), ("Closed", 4e5)] {
        let pressures =
            [("chamberA.pressure0", 4e5), ("chamberB.pressure0", 4e5), ("friction.coulombStiction.Fs", 1e6)];
        let rig = switched("CoulombStiction", centre, &pressures).choose("thermal.model", "Isothermal");
        let mut running = rig.start().unwrap();
        running.advance(3.0).unwrap();
        for name in ["chamberA.pressure", "chamberB.pressure"] {
            let found = running.get(name);
            close(found, expected, 5e-9, name);
        }
    }
}

/// The position of a carriage under a slow sine of the voltage, sampled each 10 ms.
fn course(rig: &Rig) -> Vec<f64> {
    let mut running = rig.start().unwrap();
    let mut positions = Vec::new();
    for step in 0..500 {
        let time = f64::from(step) * 1e-3;
        running.set("valveVoltage", 5.0 + 2.0 * (TAU * 2.0 * time).sin());
        running.advance(time + 1e-3).unwrap();
        positions.push(running.get("position"));
    }
    positions
}

/// Pulses without delay and travel are in the mean the valve without dead zone, play and leakage: the faster, the closer.
#[test]
fn fast_pulses_are_the_proportional_valve_of_their_mean() {
    let valve = [("valve.deadZone", 0.0), ("valve.hysteresis", 0.0), ("valve.leakage", 0.0), ("valve.bandwidth", 1e4)];
    let averaged = valve.iter().fold(Rig::cylinder("Coulomb"), |rig, (name, value)| rig.set(name, *value));
    let expected = course(&averaged);
    let moved = largest(expected.iter().map(|position| (position - 0.25).abs()));
    assert!(moved > 0.02, "the carriage moves by {moved} m");
    let apart = |frequency: f64| {
        let direct = [("switching.openingDelay", 0.0), ("switching.closingDelay", 0.0), ("switching.travelTime", 0.0)];
        let values = [&direct[..], &[("switching.frequency", frequency)]].concat();
        farthest(&course(&switched("Coulomb", "Closed", &values)), &expected)
    };
    let (slow, fast) = (apart(1000.0), apart(4000.0));
    // The pulses lie in the first part of their period; the spool of 10 kHz adds its lag of 20 us at 0.9 m/s.
    assert!(slow < 3e-4 && fast < 0.25 * slow + 2e-5, "{slow} m at 1 kHz, {fast} m at 4 kHz");
}

/// Ten seconds of 100 Hz have 4,000 beginnings and ends of motions, each of which the solver meets, and 1,000 voltages to
/// take: it costs three steps for each of them, wherever the pulses are between the communication points.
#[test]
fn pulses_cost_their_edges() {
    let mut running = switched("Stribeck", "Vented", &[("valveVoltage", 7.0)]).start().unwrap();
    running.advance(10.0).unwrap();
    let [steps, rejected] = ["solver.steps", "solver.rejectedSteps"].map(|name| running.get(name));
    assert!((5e3..2e4).contains(&(steps + rejected)), "{steps} steps, {rejected} rejected");
    let jacobians = running.get("solver.jacobians");
    assert!(20.0 * jacobians < steps, "{jacobians} implicit steps, which cost twice as much as explicit ones");
}

/// A duty cycle counts from the period on that begins after it is set, on a communication point or not.
#[test]
fn voltage_counts_at_the_beginning_of_a_period() {
    let mut running = switched("Stribeck", "Vented", &[("valveVoltage", 7.0)]).start().unwrap();
    running.advance(0.005).unwrap();
    running.set("valveVoltage", 9.0);
    running.advance(0.01).unwrap();
    close(running.get("switching.duty"), 0.4, 1e-15, "voltage counts at the beginning of a period");
    running.set("valveVoltage", 2.0);
    running.advance(0.011).unwrap();
    close(running.get("switching.duty"), -0.6, 1e-15, "voltage counts at the beginning of a period");
}

#[test]
fn saved_state_between_edges_goes_on_bit_for_bit() {
    let mut running = switched("LuGre", "Closed", &[("valveVoltage", 7.0)]).start().unwrap();
    // On the way of an armature.
    running.advance(0.1013).unwrap();
    let opening = running.get("switching.openingA");
    assert!(0.0 < opening && opening < 1.0, "{opening}");
    let saved = running.simulation().save();
    let names = ["position", "switching.openingA", "chamberB.pressure", "frictionForce"];
    running.advance(0.2).unwrap();
    let first = names.map(|name| running.get(name).to_bits());
    running.simulation().restore(&saved).unwrap();
    running.advance(0.2).unwrap();
    assert_eq!(names.map(|name| running.get(name).to_bits()), first);
}

/// A host with a solver of its own is told every edge as a time event, and comes to the same states.
#[test]
fn solver_outside_sees_every_edge() {
    let setup = Setup::new(&MODEL).set("actuation", "SwitchingValves").unwrap().set("valveVoltage", 7.0).unwrap();
    let setup = setup.set("friction.law", "LuGre").unwrap().set("solver.relativeTolerance", 1e-9).unwrap();
    let model = setup.exchange(0.0).unwrap().unwrap();
    let table = setup.table();
    let counts = [table.number_of_states(), MODEL.indicators().len()];
    let mut host =
        Host::new(model, setup.inputs(), counts, |_, inputs| inputs[..3].copy_from_slice(&[7.0, 0.0, 5e5]), 1e-9);
    let mut inside = setup.start(0.0).unwrap();
    for step in 1..=100 {
        let time = f64::from(step) * 1e-3;
        host.advance(time);
        inside.advance_to(time).unwrap();
        let mut computed = vec![0.0; table.computed().count()];
        host.model.values(&mut computed);
        for (name, allowed) in [("position", 1e-8), ("chamberA.pressure", 1e-1), ("switching.openingA", 1e-9)] {
            let place = table.computed().position(|variable| variable.name == name).unwrap();
            let (found, expected) = (computed[place], inside.get(name).unwrap());
            close(found, expected, allowed, format_args!("{name} at {time} s, inside {expected}"));
        }
    }
    assert!(inside.get("position").unwrap() > 0.25);
}

/// Each coil by a command of its own: chamber B is fed from 20 ms on, while chamber A is, and no longer vented. Choked, each gets
/// `C*p*rho0` times the time for which its valve is open, half of the travel included.
#[test]
fn each_coil_has_a_command_of_its_own() {
    let delay = 3e-3;
    let held = [("friction.coulombStiction.Fs", 1e6), ("supplyPressure", 20e5), ("switching.frequency", 1000.0)];
    let volumes = [("chamberA.deadVolume", 1.0), ("chamberB.deadVolume", 1.0), ("switching.openingDelay", delay)];
    let rig = switched("CoulombStiction", "Vented", &[held, volumes].concat()).choose("thermal.model", "Isothermal");
    let mut running = rig
        .choose("switching.command", "EachValve")
        .set("valveVoltageA", 10.0)
        .set("valveVoltageB", 0.0)
        .start()
        .unwrap();
    running.advance(0.02).unwrap();
    assert_eq!(running.get("chamberB.pressure"), 101_325.0, "closed");
    running.set("valveVoltageB", 10.0);
    running.advance(0.1).unwrap();
    let area = std::f64::consts::PI / 4.0 * 0.016f64.powi(2);
    let areas = [area, area - std::f64::consts::PI / 4.0 * 0.006f64.powi(2)];
    for ((name, begin), area) in [("chamberA.pressure", 0.0), ("chamberB.pressure", 0.02)].into_iter().zip(areas) {
        let open = 0.1 - begin - delay - 0.25e-3;
        let mean = 0.5 * 5e-4;
        let expected = open * CONDUCTANCE * 20e5 * 1.185 * GAS / (1.0 + 0.25 * area);
        let vented = mean * CONDUCTANCE * 20e5 * 1.185 * GAS;
        let found = running.get(name) - 101_325.0;
        // While it opens it vents a little, too, at a pressure that is hardly above that around it.
        close(found, expected, 1e-3 * vented, format_args!("{name}"));
    }
    assert_eq!(["switching.openingA", "switching.openingB"].map(|name| running.get(name)), [1.0, 1.0]);
}
