//! Options of the cylinder: other rods, a spring, an open chamber, friction that varies along the stroke.

use std::f64::consts::{PI, TAU};

use crate::bounds::{close, within};
use crate::rig::{Rig, Running};

const AMBIENT: f64 = 101_325.0;

fn area(diameter: f64) -> f64 {
    PI * diameter * diameter / 4.0
}

/// Equal rods, the carriage in the middle: both chambers are alike to the last bit, so nothing ever pushes it, held by
/// friction or not; half an hour stands for ever.
#[test]
fn symmetric_cylinder_stays_at_rest_in_the_middle_for_ever() {
    for law in ["Stribeck", "LuGre", "None"] {
        let mut running = Rig::cylinder(law).set("cylinder.rodA", 0.006).start().unwrap();
        for minute in 1..=30 {
            running.advance(60.0 * f64::from(minute)).unwrap();
            let [position, velocity, force] = ["position", "velocity", "pressureForce"].map(|name| running.get(name));
            assert_eq!((position, velocity, force), (0.25, 0.0, 0.0), "{law} after {minute} min");
        }
        assert!(running.get("chamberA.pressure") > 1.5 * AMBIENT, "the valve leaks into both chambers");
    }
}

/// Away from the middle the pressures approach their balance at different rates, which friction bears; they end alike.
#[test]
fn symmetric_cylinder_stays_at_rest_anywhere_under_friction() {
    let rig = Rig::cylinder("Stribeck").set("cylinder.rodA", 0.006).set("position0", 0.1);
    let mut running = rig.set("chamberA.pressure0", 3.5e5).set("chamberB.pressure0", 3.5e5).start().unwrap();
    for second in 1..=600 {
        running.advance(f64::from(second)).unwrap();
        assert_eq!(running.get("position"), 0.1, "after {second} s");
    }
    within(running.get("pressureForce").abs(), 2e-5, format_args!("{} N", running.get("pressureForce")));
}

/// `p_A*(A - A_rodA) - p_B*(A - A_rod) - p_atm*(A_rod - A_rodA)`: at equal pressures of the chambers and of the atmosphere
/// nothing is left, whatever the rods.
#[test]
fn rods_take_their_areas() {
    for (rod, rod_a) in [(0.006, 0.0), (0.0, 0.0), (0.006, 0.006), (0.004, 0.01)] {
        let rig = Rig::cylinder("Stribeck").set("cylinder.rod", rod).set("cylinder.rodA", rod_a);
        let force = |p_a: f64, p_b: f64| {
            let rig = rig.clone().set("chamberA.pressure0", p_a).set("chamberB.pressure0", p_b);
            rig.start().unwrap().get("pressureForce")
        };
        assert!(force(AMBIENT, AMBIENT).abs() < 1e-14);
        let expected =
            3e5 * (area(0.016) - area(rod_a)) - 2e5 * (area(0.016) - area(rod)) - AMBIENT * (area(rod) - area(rod_a));
        close(force(3e5, 2e5), expected, 2e-13, format_args!("{} N, not {expected}", force(3e5, 2e5)));
    }
    let error = Rig::cylinder("Stribeck").set("cylinder.rodA", 0.016).start().err().expect("no area is left");
    assert!(error.to_string().contains("cylinder.rodA = 0.016 is refused"), "{error}");
}

/// A carriage on a spring between chambers open or as large as rooms is a harmonic oscillator.
#[test]
fn carriage_swings_on_its_spring() {
    let rig = Rig::cylinder("None").set("load.stiffness", 500.0).set("load.rest", 0.26);
    let rig = rig.choose("thermal.model", "Isothermal").set("valve.leakage", 0.0).set("valve.deadZone", 0.5);
    let rig =
        rig.set("chamberA.deadVolume", 1.0).set("chamberB.deadVolume", 1.0).set("solver.relativeTolerance", 1e-10);
    let mut running = rig.start().unwrap();
    // The air of two cubic metres adds p*A^2/V, relaxed where the carriage starts.
    let air = AMBIENT * (area(0.016).powi(2) + (area(0.016) - area(0.006)).powi(2));
    let (centre, frequency) = ((500.0 * 0.26 + air * 0.25) / (500.0 + air), ((500.0 + air) / 0.88f64).sqrt());
    for step in 1..=200 {
        let time = f64::from(step) * 5e-3;
        running.advance(time).unwrap();
        let expected = centre - (centre - 0.25) * (frequency * time).cos();
        // The solver's tolerance, over some hundred steps.
        close(running.get("position"), expected, 5e-10, format_args!("{} at {time} s", running.get("position")));
        // The carriage has its part of the inertia, and all of the spring.
        let load = 0.75 * running.get("acceleration") + 500.0 * (running.get("position") - 0.26);
        close(running.get("rodForce"), load, 1e-14, "carriage swings on its spring");
    }
}

/// Fed, chamber A presses against the spring; vented, the spring returns the carriage to where it is relaxed, to the stop.
#[test]
fn single_acting_cylinder_goes_out_and_comes_back() {
    let rig = Rig::cylinder("Stribeck")
        .set("chamberB.open", 1.0)
        .set("load.stiffness", 100.0)
        .set("load.rest", -0.2)
        .set("position0", 0.0)
        .set("ambientPressure", 9e4)
        .set("chamberA.pressure0", 9e4);
    let mut running = rig.start().unwrap();
    let settle = |running: &mut Running, voltage: f64, end: f64| {
        running.set("valveVoltage", voltage);
        running.advance(end).unwrap();
        assert_eq!((running.get("chamberB.pressure"), running.get("chamberB.temperature")), (9e4, 293.15));
        running.get("position")
    };
    let out = settle(&mut running, 10.0, 5.0);
    // Balance within friction: p_A*A - p_atm*A - k*(x + 0.2), 82 N less the spring.
    let rest = (5e5 - 9e4) * area(0.016) / 100.0 - 0.2;
    assert!(out > 0.5 && rest > 0.5, "{out}: at the far stop, since the spring would balance at {rest}");
    assert!(settle(&mut running, 0.0, 10.0).abs() < 1e-4);
    // The chamber breathes as much as the piston displaces.
    running.set("valveVoltage", 10.0);
    running.advance(10.3).unwrap();
    let breath = -9e4 / (287.05 * 293.15) * (area(0.016) - area(0.006)) * running.get("velocity");
    assert!(running.get("velocity") > 0.1);
    close(running.get("chamberB.massFlow") / breath, 1.0, 1e-14, "what it breathes");
}

/// The force at which the carriage breaks away under a slow ramp, at ambient pressure.
fn break_away(rig: &Rig, position: f64) -> f64 {
    let rig = rig.clone().set("position0", position).set("valve.leakage", 0.0);
    let mut running = rig.set("solver.relativeTolerance", 1e-9).start().unwrap();
    running.ramp("externalForce", 0.0, 100.0);
    let mut last = 0.0;
    for step in 1..1000 {
        running.advance(f64::from(step) * 1e-3).unwrap();
        if running.get("sticking") == 0.0 {
            return last;
        }
        last = running.get("frictionForce");
    }
    panic!("the carriage sticks")
}

/// To the 0.1 N by which the ramp rises in a step.
#[test]
fn friction_varies_along_the_stroke_as_a_sine() {
    let rig = Rig::cylinder("Stribeck").set("friction.position.amplitude", 0.3).set("friction.position.period", 0.08);
    for position in [0.1, 0.12, 0.13, 0.25, 0.333] {
        let expected = 11.0 * (1.0 + 0.3 * (TAU * position / 0.08).sin());
        let found = break_away(&rig, position);
        close(expected, found, 0.11, format_args!("N at {position} m"));
    }
}

#[test]
fn friction_grows_with_the_pressure_difference_of_either_sign() {
    for (p_a, p_b) in [(4e5, 1e5), (1e5, 4e5)] {
        let rig = Rig::cylinder("Stribeck").set("friction.kappaDifference", 2e-6).set("friction.kappaA", 1e-6);
        let level =
            rig.set("chamberA.pressure0", p_a).set("chamberB.pressure0", p_b).start().unwrap().get("friction.level");
        let expected = 1.0 + 1e-6 * (p_a - AMBIENT) + 2e-6 * 3e5;
        close(level, expected, 1e-14, "friction grows with the pressure difference of either sign");
    }
}

/// A table along the stroke passes through its points, between those beside it, and is constant beyond them.
#[test]
fn friction_follows_a_table_along_the_stroke() {
    let table = [(0.1, 1.0), (0.2, 0.6), (0.3, 0.6), (0.4, 1.4)];
    let rig = Rig::cylinder("Stribeck").set("friction.position.points", table.len() as f64);
    let rig = (1..).zip(table).fold(rig, |rig, (number, (at, factor))| {
        let rig = rig.set(&format!("friction.position.at[{number}]"), at);
        rig.set(&format!("friction.position.factor[{number}]"), factor)
    });
    let level = |position: f64| rig.clone().set("position0", position).start().unwrap().get("friction.level");
    for (at, factor) in table {
        close(level(at), factor, 1e-14, format_args!("at {at} m"));
    }
    for (at, [low, high]) in
        [(0.05, [1.0; 2]), (0.15, [0.61, 0.99]), (0.25, [0.6; 2]), (0.35, [0.61, 1.39]), (0.45, [1.4; 2])]
    {
        let found = level(at);
        assert!((low - 1e-14..=high + 1e-14).contains(&found), "{found} at {at} m");
    }
    let with_a_load = rig.clone().set("friction.kappaA", 1e-6).set("chamberA.pressure0", 3e5).set("position0", 0.4);
    let expected = 1.4 * (1.0 + 1e-6 * (3e5 - AMBIENT));
    close(with_a_load.start().unwrap().get("friction.level"), expected, 1e-14, "the table multiplies the load");
    let refused = |name: &str, value: f64| rig.clone().set(name, value).start().err().expect("refused").variable;
    assert_eq!(refused("friction.position.points", 1.0), "friction.position.points");
    assert_eq!(refused("friction.position.at[3]", 0.2), "friction.position.at[3]");
}

/// Everything at once; bounds as in the balances of the plain cylinder.
#[test]
fn balances_close_with_all_options() {
    for open in [0.0, 1.0] {
        let rig = Rig::cylinder("Stribeck").set("balance.enabled", 1.0).set("chamberB.open", open);
        let rig = rig.set("cylinder.rodA", 0.004).set("load.stiffness", 50.0).set("load.rest", 0.1);
        let rig = rig.set("friction.position.amplitude", 0.2).set("friction.kappaDifference", 1e-6);
        let rig = rig.set("friction.position.points", 2.0).set("friction.position.factor[2]", 1.5);
        let rig = rig.set("friction.stribeckVelocity.kappaDriving", 2e-6).set("friction.viscous.kappaResisting", 1e-6);
        let mut running = rig.set("piston.leakage", 1e-16).set("position0", 0.45).start().unwrap();
        for step in 0..1000 {
            let time = f64::from(step) * 1e-3;
            running.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
            running.advance(time + 1e-3).unwrap();
            let [mass, energy] = ["mass", "energy"].map(|name| running.get(&format!("balance.{name}Residual")).abs());
            within(mass, 2e-9, format_args!("kg at {time} s"));
            within(energy, 5e-4, format_args!("J at {time} s"));
        }
    }
}

#[test]
fn saved_state_of_a_cylinder_with_options_goes_on_bit_for_bit() {
    let rig = Rig::cylinder("GMS").set("load.stiffness", 80.0).set("friction.position.amplitude", 0.2);
    let mut running = rig.set("valveVoltage", 6.5).start().unwrap();
    running.advance(0.2).unwrap();
    let saved = running.simulation().save();
    let mut go_on = || {
        running.advance(0.4).unwrap();
        ["position", "chamberA.pressure", "frictionForce"].map(|name| running.get(name).to_bits())
    };
    let first = go_on();
    running.simulation().restore(&saved).unwrap();
    running.advance(0.4).unwrap();
    assert_eq!(["position", "chamberA.pressure", "frictionForce"].map(|name| running.get(name).to_bits()), first);
}
