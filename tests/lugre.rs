//! What the default bristle of the law LuGre promises.

mod bounds;
mod rig;

use std::f64::consts::TAU;

use bounds::{close, larger};
use rig::{Rig, Running};

/// The dry part of the friction force.
fn dry(run: &mut Running) -> f64 {
    run.get("frictionForce") - 30.0 * run.get("velocity")
}

/// However fast the load grows, no more than the static friction holds the mass; less at fast loading, as published.
#[test]
fn break_away_does_not_exceed_the_static_friction_at_any_rate() {
    for (rate, least) in [(1.0, 10.9), (10.0, 10.9), (100.0, 10.6), (1000.0, 9.5)] {
        let mut run = Rig::bench("LuGre", "Free").set("mass", 0.88).start().unwrap();
        run.ramp("appliedForce", 0.0, rate);
        let mut strongest = 0.0f64;
        for step in 1..=20_000 {
            run.advance(f64::from(step) * 1e-3 / rate).unwrap();
            strongest = larger(strongest, dry(&mut run));
        }
        assert!(run.get("velocity") > 0.0 && run.get("position") > 1e-4, "20 N move the mass at {rate} N/s");
        assert!(strongest > least && strongest < 11.0 + 1e-6, "{strongest} N at {rate} N/s");
    }
}

/// Also where the motion reverses.
#[test]
fn dry_friction_of_the_default_experiment_stays_below_the_static_friction() {
    let mut run = Rig::cylinder("LuGre").start().unwrap();
    let mut strongest = 0.0f64;
    for step in 0..30_000 {
        let time = f64::from(step) * 1e-4;
        run.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
        run.advance(time + 1e-4).unwrap();
        strongest = larger(strongest, dry(&mut run).abs());
    }
    assert!(strongest > 8.3 && strongest < 11.0, "{strongest} N");
}

/// Bending and damping take at least the power that the bristle stores, at every instant of a motion with reversals at
/// all speeds, and without viscous friction to help.
#[test]
fn default_bristle_is_passive() {
    let rig = Rig::bench("LuGre", "PrescribedMotion").set("friction.lugre.sigma2", 0.0);
    let mut run = rig.set("driveVelocity", 0.0).start().unwrap();
    let mut time = 0.0;
    for reversal in 0..60 {
        let speed = 10f64.powf(-5.0 + 0.1 * f64::from(reversal)) * if reversal % 2 == 0 { 1.0 } else { -1.0 };
        run.set("driveVelocity", speed);
        for _ in 0..200 {
            time += 2e-7 / speed.abs();
            run.advance(time).unwrap();
            let [force, z, rate] =
                ["frictionForce", "friction.deflection", "der(friction.deflection)"].map(|name| run.get(name));
            let (taken, stored) = (force * speed, 1e6 * z * rate);
            // Rounding of two nearly equal powers.
            assert!(taken - stored > -1e-9 * taken.abs(), "{taken} W against {stored} W at {speed} m/s");
        }
    }
}

/// While it slides, a bristle relaxes up to a hundred million times a second; the carriage does nothing of that kind.
#[test]
fn sliding_bristle_of_any_stiffness_takes_one_explicit_step_a_millisecond() {
    for stiffness in [1e6, 8e6, 1e8, 1e9] {
        let mut run = Rig::cylinder("LuGre").set("friction.lugre.sigma0", stiffness).start().unwrap();
        let (mut sliding, mut steps, mut jacobians) = (0.0, 0.0, 0.0);
        for step in 0..1000 {
            let time = f64::from(step) * 1e-3;
            run.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
            let before = ["velocity", "solver.steps", "solver.jacobians"].map(|name| run.get(name));
            run.advance(time + 1e-3).unwrap();
            let after = ["velocity", "solver.steps", "solver.jacobians"].map(|name| run.get(name));
            // Away from the Stribeck effect, where a bristle follows the velocity within 1/r.
            if before[0].abs().min(after[0].abs()) > 0.1 {
                sliding += 1.0;
                steps += after[1] - before[1];
                jacobians += after[2] - before[2];
                let expected = (8.3 + 30.0 * after[0].abs()).copysign(after[0]);
                close(run.get("frictionForce"), expected, 5e-13, format_args!("{stiffness} at {time} s"));
            }
        }
        // A step more where the valve has a kink.
        assert!(
            sliding > 500.0 && steps < 1.1 * sliding && jacobians == 0.0,
            "{stiffness}: {sliding}, {steps}, {jacobians}"
        );
    }
}
