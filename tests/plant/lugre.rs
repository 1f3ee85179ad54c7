//! Promises of the default bristle of the law LuGre.

use std::f64::consts::TAU;

use crate::bounds::{close, larger};
use crate::rig::{Rig, Running};
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

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

/// At constant velocity the published law has a closed form: `z = s/sigma0*(1 - e)` and
/// `F = sigma0*z + sigma1*v*e + sigma2*v` with `e = exp(-sigma0*v*t/s)`.
#[test]
fn published_damping_does_not_decay() {
    for speed in [1e-4, 1e-2, 0.5] {
        let rig = Rig::bench("LuGre", "PrescribedMotion").set("friction.lugre.vd", 0.0);
        let mut run = rig.set("solver.relativeTolerance", 1e-9).set("driveVelocity", speed).start().unwrap();
        let ratio: f64 = speed / 0.01;
        let limit = 8.3 + 2.7 * (-ratio * ratio).exp();
        for part in [0.0, 0.3, 1.0, 3.0] {
            let time = part * limit / (1e6 * speed);
            run.advance(time).unwrap();
            let left = (-part).exp();
            let expected = limit * (1.0 - left) + 1000.0 * speed * left + 30.0 * speed;
            close(run.get("frictionForce") / expected, 1.0, 1e-7, format_args!("at {speed} m/s after {part}"));
        }
    }
}

/// The unit mass of the first paper, pulled at 0.1 m/s by a spring of 2 N/m, against the classical method of Runge and Kutta
/// with 10 us, whose bristle relaxes at most 1e5 times a second.
#[test]
fn published_law_sticks_and_slips_as_an_independent_solution() {
    let mut rig = Rig::bench("LuGre", "SpringPull").set("mass", 1.0).set("driveVelocity", 0.1);
    for (name, value) in [("spring.stiffness", 2.0), ("spring.damping", 0.0), ("solver.relativeTolerance", 1e-9)] {
        rig = rig.set(name, value);
    }
    let [static_force, coulomb, vs, sigma0, sigma1, sigma2] = [1.5, 1.0, 1e-3, 1e5, 1e5f64.sqrt(), 0.4];
    let values = [("Fs", static_force), ("Fc", coulomb), ("vs", vs), ("sigma0", sigma0), ("sigma1", sigma1)];
    for (name, value) in values.into_iter().chain([("sigma2", sigma2), ("vd", 0.0)]) {
        rig = rig.set(&format!("friction.lugre.{name}"), value);
    }
    let rates = |time: f64, [x, v, z]: [f64; 3]| {
        let ratio = v / vs;
        let limit = coulomb + (static_force - coulomb) * (-ratio * ratio).exp();
        let rate = v - sigma0 * v.abs() * z / limit;
        [v, 2.0 * (0.1 * time - x) - (sigma0 * z + sigma1 * rate + sigma2 * v), rate]
    };
    let along = |x: [f64; 3], rate: [f64; 3], h: f64| std::array::from_fn(|i| x[i] + h * rate[i]);
    let (mut run, mut x, h) = (rig.start().unwrap(), [0.0; 3], 1e-5);
    let mut slips = 0;
    for step in 1..=200 {
        let was_slow = x[1] < 0.05;
        for index in (step - 1) * 10_000..step * 10_000 {
            let time = f64::from(index) * h;
            let first = rates(time, x);
            let second = rates(time + 0.5 * h, along(x, first, 0.5 * h));
            let third = rates(time + 0.5 * h, along(x, second, 0.5 * h));
            let fourth = rates(time + h, along(x, third, h));
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]));
        }
        run.advance(f64::from(step) * 0.1).unwrap();
        slips += i32::from(was_slow && x[1] >= 0.05);
        close(run.get("position"), x[0], 2e-6, format_args!("m after {step} tenths of a second"));
    }
    assert!(slips >= 2, "it slips {slips} times");
}

/// Values for the law as printed, given without a word about the decay, get one.
#[test]
fn bristle_of_another_damping_is_told_which_law_it_is() {
    let told = |changes: &[(&str, f64)]| {
        let mut setup = Setup::new(&MODEL).set("friction.law", "LuGre").unwrap();
        changes.iter().for_each(|(name, value)| setup.change(&format!("friction.lugre.{name}"), *value).unwrap());
        setup.start(0.0).unwrap().notices().any(|notice| notice.variable == "friction.lugre.vd")
    };
    assert!(!told(&[]) && told(&[("sigma0", 1e5)]) && told(&[("sigma1", 300.0)]));
    // Without damping both are one; with both of another load it is the default contact.
    assert!(!told(&[("sigma0", 1e5), ("sigma1", 0.0)]) && !told(&[("sigma0", 1e5), ("sigma1", 100.0)]));
    for stated in [0.0, 0.02] {
        assert!(!told(&[("sigma0", 1e5), ("sigma1", 300.0), ("vd", stated)]), "vd = {stated}");
    }
}
