//! Vessel, cushion and regulator where one limit takes the place of another.

use std::f64::consts::PI;

use crate::bounds::{close, within};
use crate::lines::{AMBIENT, get, held};

/// A supply below the surroundings is none: air of the surroundings comes in through what feeds the vessel.
#[test]
fn vessel_under_a_supply_below_ambient_settles_at_ambient() {
    let mut plant = held(&[("supply.volume", 1e-4), ("supply.C", 1e-9), ("supplyPressure", 5e4)]);
    plant.advance_to(10.0).unwrap();
    close(get(&mut plant, "supply.vesselPressure"), AMBIENT, 1e-9, "Pa");
}

/// A cushion that would let more through than the flow control before it changes nothing.
#[test]
fn cushion_wider_than_the_flow_control_is_none() {
    let values = [
        ("hoseA.length", 0.5),
        ("hoseB.length", 0.5),
        ("throttleA.C", 1e-9),
        ("throttleB.C", 1e-9),
        ("position0", 0.01),
        ("chamberA.pressure0", 6e5),
        ("valveVoltage", 0.0),
    ];
    let after = |cushion: &[(&str, f64)]| {
        let mut plant = held(&[&values[..], cushion].concat());
        plant.advance_to(0.05).unwrap();
        ["chamberA.pressure", "chamberA.massFlow"].map(|name| get(&mut plant, name))
    };
    let alone = after(&[]);
    assert!(alone[0] < 5.5e5 && alone[1] < 0.0, "it vents: {alone:?}");
    assert_eq!(after(&[("cushion.length", 0.1), ("cushion.C", 5e-9)]), alone);
    let narrow = after(&[("cushion.length", 0.1), ("cushion.C", 1e-10)]);
    assert!(narrow[0] > alone[0] + 1e4, "a narrow one holds the pressure: {narrow:?}");
}

/// Commanded to 10 bar, with a chamber above what its vessel has: nothing flows, in or back.
#[test]
fn regulator_on_an_empty_vessel_leaves_the_chamber_as_it_is() {
    let mut plant = held(&[
        ("actuation", 2.0),
        ("regulator.pMax", 10e5),
        ("supply.volume", 1e-5),
        ("supply.C", 1e-13),
        ("supplyPressure", 1.2e5),
        ("chamberA.pressure0", 4e5),
        ("valveVoltage", 10.0),
    ]);
    // Until its own lag is over it may vent.
    plant.advance_to(1.0).unwrap();
    let before = get(&mut plant, "chamberA.pressure");
    assert!(before > get(&mut plant, "supply.vesselPressure") + 1e5, "{before} Pa");
    plant.advance_to(3.0).unwrap();
    assert_eq!(get(&mut plant, "chamberA.pressure"), before);
    assert_eq!(get(&mut plant, "chamberA.massFlow"), 0.0);
}

/// The vessel has lost the chambers' gain, whichever chamber it feeds: `p*V` adds up at one temperature. The supply gives
/// some 15 ug through the smallest conductance there is, and no chamber is vented.
#[test]
fn vessel_loses_what_the_chambers_get() {
    let area = [PI * 0.016f64.powi(2) / 4.0, PI * (0.016f64.powi(2) - 0.006f64.powi(2)) / 4.0];
    for (actuation, voltage) in [(1.0, 9.0), (1.0, 1.0), (2.0, 10.0), (3.0, 7.0), (3.0, 3.0)] {
        let mut plant = held(&[
            ("actuation", actuation),
            ("switching.centre", 2.0),
            ("supply.volume", 1e-4),
            ("supply.C", 1e-13),
            ("supplyPressure", 6e5),
            ("valveVoltage", voltage),
        ]);
        let [bore, rod] = ["cylinder.bore", "cylinder.rod"].map(|name| get(&mut plant, name));
        assert_eq!([bore, rod], [0.016, 0.006], "the areas are theirs");
        let fed = usize::from(voltage < 5.0);
        let volume = 5e-6 + area[fed] * 0.25;
        let names = [["chamberA.pressure", "chamberB.pressure"][fed], "supply.vesselPressure"];
        let before = names.map(|name| get(&mut plant, name));
        plant.advance_to(0.2).unwrap();
        let after = names.map(|name| get(&mut plant, name));
        let (received, lost) = ((after[0] - before[0]) * volume, (before[1] - after[1]) * 1e-4);
        assert!(received > 0.1 * before[0] * volume, "{actuation} at {voltage} V: {received} J");
        within((lost / received - 1.0).abs(), 2e-4, format_args!("{actuation} at {voltage} V: {lost} J, {received} J"));
    }
}

/// A hose is there without the other one and without a vessel. What the valve lets in reaches the chamber as sound does: in
/// 15 ms through 5 m of it, and at once without.
#[test]
fn hose_at_one_chamber_alone_delays_what_comes_through_it() {
    for (side, voltage) in [("A", 10.0), ("B", 0.0)] {
        let rise = |length: f64| {
            let mut plant =
                held(&[("supplyPressure", 6e5), ("valveVoltage", voltage), (&format!("hose{side}.length"), length)]);
            let name = format!("chamber{side}.pressure");
            let before = get(&mut plant, &name);
            plant.advance_to(0.01).unwrap();
            get(&mut plant, &name) - before
        };
        let (at_once, late) = (rise(0.0), rise(5.0));
        assert!(at_once > 1e4, "{side}: {at_once} Pa");
        // Some of it comes early, since the hose is made of few volumes.
        within(late.abs() / at_once, 1e-2, format_args!("{side}: {late} Pa, not {at_once} Pa"));
    }
}
