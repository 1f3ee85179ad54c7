//! Settings of the valve: electrical zero, metering edges, characteristic.

use crate::bounds::close;
use crate::rig::Rig;

const CONDUCTANCE: f64 = 3.93e-10;
const TEMPERATURE: f64 = 293.15;

/// The piston held by more friction than any pressure overcomes, gas at constant temperature, a tight valve without dead
/// zone.
fn held() -> Rig {
    Rig::cylinder("CoulombStiction")
        .choose("thermal.model", "Isothermal")
        .set("friction.coulombStiction.Fs", 1e6)
        .set("valve.leakage", 0.0)
        .set("valve.deadZone", 0.0)
        .set("valve.C", CONDUCTANCE)
        .set("solver.relativeTolerance", 1e-10)
}

/// Choked flow of one edge into chamber A or out of it, as a fraction of the flow through `valve.C`: far from the pressure behind.
fn choked_flow(rig: &Rig, voltage: f64, pressure: f64) -> f64 {
    let rig = rig.clone().set("supplyPressure", 20e5).set("chamberA.pressure0", pressure);
    let mut running = rig.set("valveVoltage", voltage).start().unwrap();
    running.advance(0.03).unwrap(); // the spool has arrived
    let upstream = if voltage > 5.0 { 20e5 } else { running.get("chamberA.pressure") };
    running.get("chamberA.massFlow") / (CONDUCTANCE * upstream * 1.185 * (TEMPERATURE / 293.15).sqrt())
}

/// At full command the edges are open, however little the spool still moves.
#[test]
fn edges_feed_and_vent_by_their_own_conductance() {
    let rig = held().set("valve.PA.factor", 1.25).set("valve.AR.factor", 0.5);
    let (fed, vented) = (choked_flow(&rig, 10.0, 1e5), choked_flow(&rig, 0.0, 10e5));
    close(fed, 1.25, 1e-14, "fed");
    close(vented, -0.5, 5e-15, "vented");
}

/// At half the pressure of the supply, an edge of a critical ratio of 0.5 is choked, one of 0 passes `sqrt(1 - 1/4)`.
#[test]
fn edges_choke_at_their_own_ratio() {
    for (ratio, expected) in [(0.5, 1.0), (0.0, 0.75f64.sqrt()), (-1.0, (1.0 - (0.2f64 / 0.7).powi(2)).sqrt())] {
        // So little flow that the pressure stays.
        let rig = held().set("valve.PA.b", ratio).set("valve.PA.factor", 1e-6);
        let found = choked_flow(&rig, 10.0, 10e5) * 1e6;
        close(found, expected, 5e-8, format_args!("a ratio of {ratio}"));
    }
}

#[test]
fn offset_moves_the_voltage_at_which_the_valve_is_closed() {
    for (offset, voltage, command) in [(-0.18, 5.18, 0.0), (-0.18, 5.0, -0.036), (0.5, 5.5, 0.2), (0.5, 9.5, 1.0)] {
        let rig = held().set("valve.offset", offset).set("valve.hysteresis", 0.0).set("valveVoltage", voltage);
        let found = rig.start().unwrap().get("valve.command");
        close(found, command, 1e-15, format_args!("{voltage} V"));
    }
}

/// Half command on a table that opens by 0.1 there; towards chamber B by 0.9.
#[test]
fn table_opens_each_way_by_its_own_points() {
    let mut rig = held().choose("valve.characteristic", "Table");
    for (name, value) in [
        ("A.points", 3.0),
        ("A.spool[2]", 0.5),
        ("A.spool[3]", 1.0),
        ("A.opening[2]", 0.1),
        ("A.opening[3]", 1.0),
        ("B.points", 3.0),
        ("B.spool[2]", 0.5),
        ("B.spool[3]", 1.0),
        ("B.opening[2]", 0.9),
        ("B.opening[3]", 1.0),
    ] {
        rig = rig.set(&format!("valve.table{name}"), value);
    }
    let rig = rig.set("valve.hysteresis", 0.0);
    let (fed, vented) = (choked_flow(&rig, 7.5, 1e5), choked_flow(&rig, 2.5, 10e5));
    close(fed, 0.1, 1e-7, "fed");
    close(vented, -0.9, 1e-7, "vented");
}

#[test]
fn table_that_does_not_rise_is_refused_by_its_point() {
    let refused = |name: &str, value: f64| {
        let rig = held().choose("valve.characteristic", "Table").set(name, value);
        rig.start().err().expect("a table that does not rise").to_string()
    };
    assert_eq!(
        refused("valve.tableA.spool[3]", 0.1),
        "valve.tableA.spool[3] = 0.1 is refused: it must exceed the one before, 0.1"
    );
    assert_eq!(
        refused("valve.tableB.opening[5]", 0.2),
        "valve.tableB.opening[5] = 0.2 is refused: it must not be below the one before, 0.3"
    );
    // Points beyond the number of those in use, and tables out of use, may hold anything.
    held().set("valve.tableA.spool[3]", 0.1).start().unwrap();
    let short = held().choose("valve.characteristic", "Table").set("valve.tableA.points", 2.0);
    short.set("valve.tableA.spool[3]", 0.1).start().unwrap();
}
