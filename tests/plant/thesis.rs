//! Facts that the experiments on the rig show, with the defaults identified from them.

use std::f64::consts::TAU;

use crate::bounds::close;
use crate::rig::Rig;

/// Runs a voltage and lists the intervals (start, end, position) of sticking, sampled at 0.1 ms.
fn rests(rig: &Rig, end: f64, voltage: impl Fn(f64) -> f64) -> Vec<(f64, f64, f64)> {
    let mut running = rig.start().unwrap();
    let mut rests = Vec::new();
    let mut since = Some(0.0);
    for step in 0..(end / 1e-4).round() as usize {
        let (at, next) = (step as f64 * 1e-4, (step + 1) as f64 * 1e-4);
        running.set("valveVoltage", voltage(at));
        running.advance(next).unwrap();
        let sticks = running.get("sticking") == 1.0;
        match since {
            None if sticks => since = Some(next),
            Some(start) if !sticks => {
                rests.push((start, next, running.get("position")));
                since = None;
            }
            _ => {}
        }
    }
    rests
}

/// The carriage sticks at each reversal, the shorter the faster the voltage: about 95, 38 and 19 ms.
#[test]
fn carriage_sticks_at_each_reversal() {
    for (frequency, expected) in [(1.0, 95e-3), (2.0, 38e-3), (4.0, 19e-3)] {
        let found = rests(&Rig::cylinder("Stribeck"), 3.0, |t| 5.0 + 2.0 * (TAU * frequency * t).sin());
        // After the first two periods, in which the pressures build up.
        let settled: Vec<f64> = found.iter().filter(|r| r.0 > 2.0 / frequency).map(|r| r.1 - r.0).collect();
        let mean = settled.iter().sum::<f64>() / settled.len() as f64;
        close(mean / expected, 1.0, 0.15, format_args!("{frequency} Hz: {mean} s, not {expected}"));
        assert!(settled.len() as f64 >= 2.0 * (3.0 * frequency - 2.0) - 2.0, "a rest at every reversal: {settled:?}");
    }
}

/// The voltage moves at once; pressures must build up and overcome stiction before the carriage does.
#[test]
fn first_motion_comes_later_than_the_voltage() {
    let found = rests(&Rig::cylinder("Stribeck"), 0.5, |_| 7.0);
    let (start, end, _) = found[0];
    assert_eq!(start, 0.0);
    assert!(end > 5e-3 && end < 0.2, "first motion after {end} s");
}

/// At the edge of the dead zone the carriage moves in steps with long rests.
#[test]
fn stick_slip_appears_at_the_edge_of_the_dead_zone() {
    let found = rests(&Rig::cylinder("Stribeck").set("position0", 0.05), 7.0, |_| 5.42);
    close(found[0].1, 3.2, 0.1, format_args!("first motion after {} s", found[0].1));
    assert!(found.len() >= 4, "{found:?}");
    for (before, after) in found.iter().zip(&found[1..]) {
        let (step, rest) = (after.2 - before.2, after.1 - after.0);
        close(step, 5.5e-3, 0.3e-3, "a step, m");
        assert!((0.6..1.2).contains(&rest), "a rest of {rest} s");
    }
}

#[test]
fn slightly_more_voltage_gives_smooth_motion() {
    let found = rests(&Rig::cylinder("Stribeck").set("position0", 0.05), 7.0, |_| 5.46);
    assert_eq!(found.len(), 1, "only the first rest: {found:?}");
}

/// With a dependence on pressure the same carriage breaks away later, under a higher force.
#[test]
fn pressure_raises_the_break_away_force() {
    let break_away = |kappa: f64| {
        let rig = Rig::cylinder("Stribeck").set("friction.kappaA", kappa).set("valveVoltage", 6.0);
        let mut running = rig.start().unwrap();
        let mut force = 0.0;
        for step in 1..5000 {
            running.advance(f64::from(step) * 1e-4).unwrap();
            if running.get("sticking") == 0.0 {
                return (force, running.get("chamberA.pressure"));
            }
            force = running.get("frictionForce");
        }
        panic!("the carriage never breaks away");
    };
    let (plain, _) = break_away(0.0);
    let (loaded, pressure) = break_away(5e-6);
    // 0.1 ms of rising pressure before break-away change the force by less than 0.1 %.
    close(plain / 11.0, 1.0, 5e-3, plain);
    let expected = 11.0 * (1.0 + 5e-6 * (pressure - 101_325.0));
    assert!(loaded > 1.2 * plain, "{loaded}, {plain} without");
    close(loaded / expected, 1.0, 5e-3, "loaded");
}

/// Ten seconds under a load below break-away: not the last bit of the position changes, at any communication step.
#[test]
fn stiction_does_not_drift() {
    for law in ["Coulomb", "CoulombStiction", "Stribeck", "Karnopp", "Polito"] {
        for interval in [1e-3, 1e-2, 5e-2] {
            let rig = Rig::cylinder(law).set("externalForce", 6.0).set("thermal.heatTransfer", 0.0);
            let mut running = rig.set("solver.relativeTolerance", 1e-6).start().unwrap();
            let start = running.get("position");
            for step in 1..=(10.0 / interval) as usize {
                // A load that swings below the break-away force of every law.
                running.set("externalForce", 6.0 * (step as f64 * interval * 7.0).cos());
                running.advance(step as f64 * interval).unwrap();
                assert_eq!(running.get("position").to_bits(), start.to_bits(), "{law} at {interval} s");
                assert_eq!((running.get("velocity"), running.get("sticking")), (0.0, 1.0), "{law} at {interval} s");
            }
        }
    }
}

/// With the input held over 50 ms, finer communication steps in between change the result by the tolerance only.
#[test]
fn communication_step_does_not_matter() {
    for law in ["Stribeck", "Polito", "LuGre", "Dahl"] {
        let end = |interval: f64| {
            let mut running = Rig::cylinder(law).start().unwrap();
            let steps = (0.05 / interval).round() as usize;
            for hold in 0..40 {
                running.set("valveVoltage", 5.0 + 2.0 * (TAU * f64::from(hold) * 0.05).sin());
                for step in 1..=steps {
                    running.advance(f64::from(hold) * 0.05 + step as f64 * interval).unwrap();
                }
            }
            (running.get("position"), running.get("chamberA.pressure"))
        };
        let (position, pressure) = end(0.05);
        for interval in [0.01, 0.001] {
            let (x, p) = end(interval);
            close(x, position, 5e-8, format_args!("{law} {interval}, m"));
            close(p, pressure, 0.1, format_args!("{law} {interval}, Pa"));
        }
    }
}
