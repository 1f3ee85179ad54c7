//! Actuators with a command for each chamber.

use std::f64::consts::{PI, TAU};

use crate::bounds::close;
use crate::rig::Rig;

/// Under friction that nothing overcomes the carriage rests in the middle.
fn held(actuation: &str) -> Rig {
    let rig = Rig::cylinder("Coulomb").choose("actuation", actuation).set("friction.coulomb.Fc", 1e4);
    rig.choose("thermal.model", "Isothermal").set("supplyPressure", 6e5).set("solver.relativeTolerance", 1e-9)
}

/// With opposite commands both valves are one proportional valve, where spools are fast.
#[test]
fn opposite_commands_are_those_of_one_valve() {
    let rig = |actuation| Rig::cylinder("LuGre").choose("actuation", actuation).set("supplyPressure", 6e5);
    let one = rig("ProportionalValve").set("valve.hysteresis", 0.0).set("valve.bandwidth", 1e4);
    let (mut one, mut two) = (one.start().unwrap(), rig("TwoValves").set("twoValves.tau", 2e-5).start().unwrap());
    let mut travelled = 0.0f64;
    for index in 0..800 {
        let time = 1e-3 * f64::from(index);
        let voltage = 2.5 * (TAU * 2.0 * time).sin();
        one.set("valveVoltage", 5.0 + voltage);
        two.set("valveVoltageA", 5.0 + voltage);
        two.set("valveVoltageB", 5.0 - voltage);
        for running in [&mut one, &mut two] {
            running.advance(time + 1e-3).unwrap();
        }
        travelled = travelled.max((two.get("position") - 0.25).abs());
        close(two.get("position"), one.get("position"), 2e-5, format_args!("m at {time} s"));
    }
    assert!(travelled > 0.02, "{travelled} m");
}

/// Choked flow through a valve that opens with its lag fills a chamber of constant volume by
/// `dp/dt = R*T*C*p_s*rho0/V*(1 - exp(-t/tau))`; the other chamber is none of it.
#[test]
fn chamber_is_filled_by_its_own_command() {
    let area = PI * 0.016 * 0.016 / 4.0;
    let rate = 287.05 * 293.15 * 1e-10 * 6e5 * 1.185 / (5e-6 + area * 0.25);
    let rig = held("TwoValves").set("twoValves.C", 1e-10).set("twoValves.deadZone", 0.0).set("twoValves.leakage", 0.0);
    let mut running = rig.set("twoValves.tau", 0.02).set("valveVoltageA", 10.0).start().unwrap();
    for index in 1..=100 {
        let time = 1e-3 * f64::from(index);
        running.advance(time).unwrap();
        let opened = time - 0.02 * (1.0 - (-time / 0.02f64).exp());
        close(running.get("chamberA.pressure"), 101_325.0 + rate * opened, 1e-3, format_args!("Pa at {time} s"));
        assert_eq!(running.get("chamberB.pressure"), 101_325.0, "closed");
        close(running.get("chamberA.massFlow"), 1e-10 * 6e5 * 1.185 * (1.0 - (-time / 0.02f64).exp()), 1e-12, "kg/s");
    }
}

/// Both chambers are fed, vented or closed at once, which one valve cannot do.
#[test]
fn both_chambers_are_fed_and_vented_at_once() {
    let mut running = held("TwoValves").set("valveVoltageA", 10.0).set("valveVoltageB", 10.0).start().unwrap();
    running.advance(3.0).unwrap();
    // A closed edge leaks two parts in a thousand.
    for chamber in ["chamberA.pressure", "chamberB.pressure"] {
        assert!((5.99e5..6e5).contains(&running.get(chamber)), "{chamber}: {} Pa", running.get(chamber));
    }
    running.set("valveVoltageA", 0.0);
    running.set("valveVoltageB", 0.0);
    running.advance(6.0).unwrap();
    for chamber in ["chamberA.pressure", "chamberB.pressure"] {
        close(running.get(chamber), 101_325.0, 200.0, chamber);
    }
}

/// Each regulator brings its chamber to its command, independent of the other.
#[test]
fn regulators_set_both_pressures() {
    let rig = held("TwoRegulators").set("valveVoltageA", 5.0).set("valveVoltageB", 2.5);
    let mut running = rig.set("consumption.enabled", 1.0).start().unwrap();
    running.advance(3.0).unwrap();
    close(running.get("chamberA.pressure"), 4.9e5, 1.0, "Pa");
    close(running.get("chamberB.pressure"), 2.95e5, 1.0, "Pa");
    let consumed = running.get("supply.consumed");
    running.set("valveVoltageB", 7.5);
    running.advance(3.05).unwrap();
    let lagged = 6.85e5 - 3.9e5 * (-0.05f64 / 0.02).exp();
    // Beyond the supply a regulator has nothing to give.
    close(running.get("twoRegulators.pressureB"), lagged, 1.0, "Pa");
    running.advance(6.0).unwrap();
    close(running.get("chamberA.pressure"), 4.9e5, 1.0, "Pa");
    close(running.get("chamberB.pressure"), 6e5, 1.0, "Pa");
    let drawn = (6e5 - 2.95e5) * (5e-6 + (PI * (0.016f64.powi(2) - 0.006f64.powi(2)) / 4.0) * 0.25) / (287.05 * 293.15);
    close(running.get("supply.consumed") - consumed, drawn, 1e-9, "kg");
    running.set("valveVoltageA", 0.0);
    running.advance(9.0).unwrap();
    close(running.get("chamberA.pressure"), 1e5, 1.0, "Pa");
    assert_eq!(running.get("supply.massFlow"), 0.0, "what comes back is vented");
}

/// Commands of chambers do not count for other actuators, nor theirs for these.
#[test]
fn commands_count_for_their_actuators_alone() {
    let end = |actuation: &str, input: &str| {
        let mut running = Rig::cylinder("LuGre").choose("actuation", actuation).set(input, 8.0).start().unwrap();
        running.advance(0.3).unwrap();
        running.get("position").to_bits()
    };
    for actuation in ["ProportionalValve", "PressureRegulator", "SwitchingValves"] {
        let nothing = end(actuation, "imposedVelocity");
        assert_eq!(["valveVoltageA", "valveVoltageB"].map(|input| end(actuation, input)), [nothing; 2], "{actuation}");
        assert_ne!(end(actuation, "valveVoltage"), nothing, "{actuation}");
    }
    for actuation in ["TwoValves", "TwoRegulators"] {
        let nothing = end(actuation, "valveVoltage");
        assert_eq!(end(actuation, "imposedVelocity"), nothing, "{actuation}");
        ["valveVoltageA", "valveVoltageB"]
            .iter()
            .for_each(|input| assert_ne!(end(actuation, input), nothing, "{input}"));
    }
}

#[test]
fn regulators_whose_range_is_turned_round_are_refused() {
    let rig = held("TwoRegulators").set("twoRegulators.pMax", 5e4);
    let error = rig.start().err().expect("refused").to_string();
    assert!(error.contains("twoRegulators.pMax = 50000") && error.contains("twoRegulators.pMin"), "{error}");
}
