//! Air consumption of a cylinder, against the consumption of textbooks: a chamber that is filled from ambient pressure
//! at its least volume to supply pressure at its greatest.

use std::f64::consts::PI;

use crate::bounds::close;
use crate::rig::{Rig, Running};

const AMBIENT: f64 = 101_325.0;
const SUPPLY: f64 = 6e5;
/// `R*T` in J/kg.
const GAS: f64 = 287.05 * 293.15;
/// Dead volume of each chamber in m3.
const DEAD: f64 = 5e-6;
const HOSE_DIAMETER: f64 = 4e-3;

fn area(diameter: f64) -> f64 {
    PI * diameter * diameter / 4.0
}

/// A tight valve, isothermal gas.
fn metered() -> Rig {
    let rig = Rig::cylinder("Stribeck").choose("thermal.model", "Isothermal").set("consumption.enabled", 1.0);
    let rig = rig.set("solver.relativeTolerance", 1e-9).set("supplyPressure", SUPPLY);
    rig.set("valve.leakage", 0.0).set("chamberA.deadVolume", DEAD).set("chamberB.deadVolume", DEAD)
}

/// Goes under a voltage until nothing flows.
fn settled(running: &mut Running, time: f64, voltage: f64) -> f64 {
    running.set("valveVoltage", voltage);
    running.advance(time).unwrap();
    running.get("position")
}

/// The masses in kg that a double stroke between two positions in m takes: of each chamber the gas at the pressure of the
/// supply in its greatest volume less that at ambient pressure in its least, a hose of a length in m counted to both.
fn of_double_stroke([low, high]: [f64; 2], hose: f64) -> f64 {
    let (bore, stroke, fixed) = (area(0.016), 0.5, DEAD + hose * area(HOSE_DIAMETER));
    let chamber = |least: f64, most: f64| (SUPPLY * (fixed + most) - AMBIENT * (fixed + least)) / GAS;
    let rod_side = bore - area(0.006);
    chamber(bore * low, bore * high) + chamber(rod_side * (stroke - high), rod_side * (stroke - low))
}

#[test]
fn double_stroke_takes_what_textbooks_say() {
    // While switching valves travel, some air goes straight to the exhaust.
    let cases: [(&[(&str, f64)], f64); 4] = [
        (&[], 1e-6),
        (&[("hoseA.length", 2.0), ("hoseB.length", 2.0)], 1e-6),
        (&[("hoseA.length", 2.0), ("hoseB.length", 2.0), ("supply.volume", 1e-4)], 1e-6),
        (&[("actuation", 3.0)], 1e-4),
    ];
    for (case, bound) in cases {
        let mut rig = metered().set("hoseA.diameter", HOSE_DIAMETER).set("hoseB.diameter", HOSE_DIAMETER);
        for (name, value) in case {
            rig = rig.set(name, *value);
        }
        let mut running = rig.start().unwrap();
        settled(&mut running, 3.0, 0.0);
        let before = running.get("supply.consumed");
        let high = settled(&mut running, 6.0, 10.0);
        let low = settled(&mut running, 9.0, 0.0);
        let found = running.get("supply.consumed") - before;
        let hose = case.iter().find(|(name, _)| *name == "hoseA.length").map_or(0.0, |(_, length)| *length);
        let expected = of_double_stroke([low, high], hose);
        close(found / expected, 1.0, bound, format_args!("{found} kg, not {expected}, with {case:?}"));
        let volume = running.get("supply.consumedVolume");
        close(volume * 1.185 / running.get("supply.consumed"), 1.0, 1e-15, "m3 (ANR)");
    }
}

/// A regulator gives what a chamber has taken, and takes nothing back.
#[test]
fn regulator_draws_what_it_gives() {
    let rig = metered().set("actuation", 2.0).set("supplyPressure", 1e6).set("position0", 0.5);
    let mut running = rig.start().unwrap();
    let high = settled(&mut running, 3.0, 5.0);
    let (pressure, given) = (running.get("chamberA.pressure"), running.get("supply.consumed"));
    let expected = (pressure * (DEAD + area(0.016) * high) - AMBIENT * (DEAD + area(0.016) * 0.5)) / GAS;
    close(given / expected, 1.0, 1e-6, format_args!("{given} kg, not {expected}"));
    settled(&mut running, 6.0, 1.0);
    // Roundings of some hundred steps.
    close(running.get("supply.consumed") / given, 1.0, 1e-12, "nothing comes back");
}

/// Choked flow is `C*p*rho0` at the reference temperature.
#[test]
fn mass_flow_is_that_of_an_open_edge() {
    let rig = metered().set("chamberA.deadVolume", 0.1).set("valve.C", 4e-9).set("valveVoltage", 10.0);
    let mut running = rig.start().unwrap();
    running.advance(0.1).unwrap();
    close(running.get("supply.massFlow") / (4e-9 * SUPPLY * 1.185), 1.0, 1e-9, "choked");
    running.set("valveVoltage", 5.0);
    running.advance(0.2).unwrap();
    assert_eq!(running.get("supply.massFlow"), 0.0, "closed");
}

#[test]
fn nothing_is_counted_unless_asked_for() {
    let mut running = metered().set("consumption.enabled", 0.0).set("valveVoltage", 10.0).start().unwrap();
    running.advance(0.2).unwrap();
    for name in ["supply.massFlow", "supply.consumed", "supply.consumedVolume"] {
        assert_eq!(running.get(name), 0.0, "{name}");
    }
}
