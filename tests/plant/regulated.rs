//! The regulator and what feeds it.

use crate::bounds::close;
use crate::rig::Rig;

const AMBIENT: f64 = 101_325.0;

/// The piston held, gas at constant temperature.
fn regulated(values: &[(&str, f64)]) -> f64 {
    let rig = Rig::cylinder("CoulombStiction").set("friction.coulombStiction.Fs", 1e6);
    let rig = rig.choose("actuation", "PressureRegulator").choose("thermal.model", "Isothermal");
    let mut running = values.iter().fold(rig, |rig, (name, value)| rig.set(name, *value)).start().unwrap();
    running.advance(5.0).unwrap();
    running.get("chamberA.pressure")
}

/// 9 V command 8.02 bar: the chamber gets that, or the pressure of the supply where it is lower. A supply below ambient acts
/// as ambient. A vessel that a wide orifice fills makes no difference.
#[test]
fn regulator_gives_no_more_than_its_supply_has() {
    let wide_vessel = [("supply.volume", 1e-3), ("supply.C", 1e-6)];
    for (supply, expected) in [(0.0, AMBIENT), (3e5, 3e5), (8e5, 8e5), (10e5, 8.02e5)] {
        for vessel in [&[][..], &wide_vessel] {
            let values = [vessel, &[("valveVoltage", 9.0), ("supplyPressure", supply)]].concat();
            let found = regulated(&values);
            close(found, expected, 0.1, format_args!("Pa from a supply of {supply} Pa, {vessel:?}"));
        }
    }
}

/// Above its supply the chamber keeps what it has up to the regulated pressure, and is vented to it beyond.
#[test]
fn supply_takes_nothing_back() {
    for (voltage, expected) in [(9.0, 6e5), (2.0, 2.56e5)] {
        let values = [("valveVoltage", voltage), ("supplyPressure", 2e5), ("chamberA.pressure0", 6e5)];
        let found = regulated(&values);
        close(found, expected, 0.1, format_args!("Pa at {voltage} V"));
    }
}
