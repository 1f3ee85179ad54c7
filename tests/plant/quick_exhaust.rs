//! Quick exhaust valves, against closed forms of a chamber of constant volume.

use std::f64::consts::PI;

use crate::bounds::{close, within};
use crate::rig::{Rig, Running};

const CONDUCTANCE: f64 = 1e-8;
/// Chamber A with its dead volume, in m3.
const VOLUME: f64 = 5e-6 + PI / 4.0 * 0.016 * 0.016 * 0.25;

/// A cylinder at constant temperature whose carriage is held in the middle.
fn held(voltage: f64, changes: &[(&str, f64)]) -> Running {
    let rig = Rig::cylinder("None").choose("motion", "Imposed").choose("thermal.model", "Isothermal");
    let rig = rig.set("imposedPosition", 0.25).set("valveVoltage", voltage).set("solver.relativeTolerance", 1e-9);
    let rig = rig.set("balance.enabled", 1.0).set("supplyPressure", 6e5);
    changes.iter().fold(rig, |rig, (name, value)| rig.set(name, *value)).start().unwrap()
}

/// While the line is vented and the outflow is choked, the pressure falls as `exp(-C*rho0*R*T*t/V)`; nothing goes back into the line.
#[test]
fn chamber_empties_through_it_alone() {
    for length in [0.0, 0.2] {
        let quick = [("quickExhaustA.C", CONDUCTANCE), ("chamberA.pressure0", 9e5), ("hoseA.length", length)];
        let mut running = held(0.0, &quick);
        let pressures = [0.02, 0.04].map(|time| {
            running.advance(time).unwrap();
            running.get("chamberA.pressure")
        });
        assert!(pressures[1] > 101_325.0 / 0.3, "choked: {pressures:?} Pa");
        assert!(running.get("hoseA.pressure[4]") < pressures[1] - 1e4, "open");
        let rate = (pressures[0] / pressures[1]).ln() / 0.02;
        let expected = CONDUCTANCE * 1.185 * 287.05 * 293.15 / VOLUME;
        close(rate / expected, 1.0, 1e-6, format_args!("of the rate, {length} m"));
        within(running.get("balance.massResidual").abs(), 1e-11, "kg");
    }
}

/// A chamber that is fed keeps what it gets, as without: the valve leaks a little.
#[test]
fn it_is_closed_under_pressure_from_the_line() {
    let [with, without] = [CONDUCTANCE, 0.0].map(|conductance| {
        let mut running = held(10.0, &[("quickExhaustA.C", conductance), ("hoseA.length", 0.1)]);
        running.advance(2.0).unwrap();
        within(running.get("chamberA.massFlow").abs(), 1e-9, "kg/s");
        running.get("chamberA.pressure")
    });
    assert!(with > 5.99e5, "{with} Pa");
    close(with, without, 1e-2, "Pa");
}

/// A carriage goes out faster where chamber B need not empty through valve and hose, and no faster where its own port is the cushion's.
#[test]
fn carriage_is_faster_with_it() {
    let time = |changes: &[(&str, f64)]| {
        let rig = Rig::cylinder("Stribeck").set("valveVoltage", 10.0).set("supplyPressure", 6e5).set("position0", 0.05);
        let rig = rig.set("hoseB.length", 3.0).set("chamberB.pressure0", 6e5);
        let mut running = changes.iter().fold(rig, |rig, (name, value)| rig.set(name, *value)).start().unwrap();
        let mut end = 0.0;
        while running.get("position") < 0.45 && end < 5.0 {
            end += 1e-3;
            running.advance(end).unwrap();
        }
        end
    };
    let (without, with) = (time(&[]), time(&[("quickExhaustB.C", CONDUCTANCE)]));
    assert!(with < 0.8 * without, "{with} s, {without} s without");
    let cushioned = [("cushion.length", 0.5), ("cushion.C", 1e-10)];
    let both = time(&[&cushioned[..], &[("quickExhaustB.C", CONDUCTANCE)]].concat());
    assert!(both > 2.0 * without, "{both} s through the cushion");
}
