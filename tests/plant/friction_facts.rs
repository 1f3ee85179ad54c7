//! Facts with closed forms about laws with modes, memory, noise or samples.

use std::f64::consts::{PI, TAU};

use crate::bounds::{close, farthest, larger, largest, loosely, within};
use crate::rig::{Rig, Running};

/// A law on a bench with a prescribed motion and without viscous friction.
fn moved(law: &str, group: &str) -> Rig {
    Rig::bench(law, "PrescribedMotion").set(&format!("friction.{group}.sigma2"), 0.0).set("driveVelocity", 0.0)
}

/// Moves the mass by a distance at a velocity; returns the friction force at the end.
fn go(run: &mut Running, velocity: f64, distance: f64) -> f64 {
    let start = run.simulation().time();
    run.set("driveVelocity", velocity);
    run.advance(start + distance / velocity.abs()).expect("a step that ends");
    run.get("frictionForce")
}

/// Largest force on the way.
fn peak(run: &mut Running, velocity: f64, distance: f64, samples: u32) -> f64 {
    largest((0..samples).map(|_| go(run, velocity, distance / f64::from(samples))))
}

/// The closed form of the path equation, from rest and after a reversal; to the tolerance of the solver.
#[test]
fn bliman_sorine_is_a_function_of_the_path() {
    let rise = |path: f64| 24.6 * (1.0 - (-path / 5e-6).exp()) - 16.3 * (1.0 - (-path / 1e-5).exp());
    let top = 1e-5 * (24.6f64 / (0.5 * 16.3)).ln();
    close(rise(top), 11.0, 5e-4, "bliman sorine is a function of the path");
    for velocity in [1e-4, 0.1] {
        let mut run = moved("BlimanSorine", "blimanSorine").set("solver.relativeTolerance", 1e-9).start().unwrap();
        let mut path = 0.0;
        for leg in [1e-6, 4e-6, top - 5e-6, 2e-5] {
            path += leg;
            let found = go(&mut run, velocity, leg);
            close(found, rise(path), 1e-8, format_args!("{found} N, not {} N after {path} m", rise(path)));
        }
        close(go(&mut run, velocity, 1e-3), 8.3, 1e-11, "bliman sorine is a function of the path");
        let back = 8.3 - 2.0 * 24.6 * (1.0 - (-2f64).exp()) + 2.0 * 16.3 * (1.0 - (-1f64).exp());
        close(go(&mut run, -velocity, 1e-5), back, 1e-8, "bliman sorine is a function of the path");
    }
}

/// Below `zbaRatio*F_c` = 5.81 N the bristle is a spring: exactly on a path, and without drift under a load that
/// oscillates between 0.1 and 0.4 F_s; what remains is the tolerance.
#[test]
fn elasto_plastic_bristle_is_elastic_at_first() {
    let mut run = moved("ElastoPlastic", "elastoPlastic").start().unwrap();
    for leg in [5e-6, -8e-6, 6e-6, -6e-6] {
        go(&mut run, 1e-4 * f64::signum(leg), f64::abs(leg));
        run.set("driveVelocity", 0.0);
        let (force, position) = (run.get("frictionForce"), run.get("position"));
        close(force, 1e6 * position, 5e-14, format_args!("N at {position} m"));
    }
    let mut run = Rig::bench("ElastoPlastic", "Free").set("solver.relativeTolerance", 1e-9).start().unwrap();
    let mut positions = Vec::new();
    for cycle in 0..20 {
        for step in 0..100 {
            let time = f64::from(cycle) + f64::from(step) * 0.01;
            run.set("appliedForce", 11.0 * (0.25 - 0.15 * (TAU * time).cos()));
            run.advance(time + 0.01).unwrap();
        }
        positions.push(run.get("position"));
    }
    let drift = positions[19] - positions[9];
    within(drift.abs(), 5e-20, "m in 10 cycles");
}

/// The largest difference of the two shapes, 0.010009, is a number of calculus.
#[test]
fn step_and_sine_differ_by_one_percent_of_the_static_friction() {
    let force = |law: &str, group: &str, v: f64| {
        let mut run =
            moved(law, group).set(&format!("friction.{group}.Fc"), 0.0).set("driveVelocity", v).start().unwrap();
        run.get("frictionForce")
    };
    let difference = |v: f64| {
        let [step, sine] = [("StepRegularised", "stepRegularised"), ("SineRegularised", "sineRegularised")]
            .map(|(law, group)| force(law, group, v));
        (step - sine).abs() / 11.0
    };
    let top = largest((0..2000).map(|i| difference(1.2e-2 * f64::from(i) / 2000.0)));
    assert!((0.010_000..0.010_009_5).contains(&top), "{top}");
    // The descent has the same shape as the ascent.
    let shape = |q: f64| (3.0 * q * q - 2.0 * q.powi(3) - 0.5 * (1.0 - (PI * q).cos())).abs();
    close(difference(2.8e-3), shape(0.2), 2e-16, "above");
    close(difference(2e-4), shape(0.2), 1e-16, "below");
}

/// `(1 + a)*sigma0*z0` on the way to the limit, `sigma0*z0` there, and the bond again after a reversal.
#[test]
fn reset_integrator_drops_from_break_away_to_sliding() {
    let mut run =
        moved("ResetIntegrator", "resetIntegrator").set("friction.resetIntegrator.sigma1", 0.0).start().unwrap();
    let before = go(&mut run, 1e-4, 8.29e-6);
    close(before, 1.325 * 8.29, 1e-13, "N");
    let after = go(&mut run, 1e-4, 0.02e-6);
    close(after, 8.3, 1e-13, "N");
    assert_eq!(go(&mut run, 0.1, 0.1), after);
    let back = go(&mut run, -1e-4, 8.3e-6);
    within(back.abs(), 1e-13, "N after a return by z0");
    close(go(&mut run, -1e-4, 1e-5), -8.3, 1e-13, "N backwards");
}

/// A mass pushed with 5 N hangs on the spring of its law, `force/stiffness` from where it was, without creep.
#[test]
fn springs_of_stick_slip_laws_hold_the_mass() {
    let cases = [
        ("StickSlipSpring", 1e5, 1.0),
        ("StickSlipCreep", 1.1e6, 0.0),
        ("ResetIntegrator", 1.325e6, 0.0),
        ("Armstrong", 1e6, 1.0),
    ];
    for (law, stiffness, sticking) in cases {
        let mut run = Rig::bench(law, "Free").set("appliedForce", 5.0).start().unwrap();
        for end in [1.0, 100.0] {
            run.advance(end).unwrap();
            let position = run.get("position");
            close(position, 5.0 / stiffness, 2e-17, format_args!("{law}, m"));
            assert_eq!(run.get("sticking"), sticking, "{law}");
        }
        run.set("appliedForce", 11.2);
        run.advance(101.0).unwrap();
        assert!(run.get("velocity") > 0.01, "{law} holds 11.2 N");
        // After slip the contact has a new elastic range where it stops.
        run.set("appliedForce", 0.0);
        run.advance(110.0).unwrap();
        within(run.get("velocity").abs(), 2e-14, law);
        within(run.get("frictionForce").abs(), 5e-12, law);
    }
}

/// Pulled by a spring, the mass sticks again and again: its friction force never jumps there.
#[test]
fn force_is_continuous_where_the_mass_sticks_again() {
    for (law, group) in [("StickSlipSpring", "stickSlipSpring"), ("Armstrong", "armstrong")] {
        let mut run = Rig::bench(law, "SpringPull")
            .set(&format!("friction.{group}.sigma2"), 0.0)
            .set("spring.stiffness", 1e3)
            .set("driveVelocity", 1e-2)
            .start()
            .unwrap();
        let (mut last, mut was_sticking, mut stops) = (0.0, 1.0, 0);
        for step in 1..400_000 {
            run.advance(f64::from(step) * 2e-5).unwrap();
            let (force, is_sticking) = (run.get("frictionForce"), run.get("sticking"));
            if is_sticking > was_sticking {
                stops += 1;
                // In a sample of 20 us the velocity changes by 0.1 mm/s, of which the contact damping makes 0.1 N.
                assert!(f64::abs(force - last) < 0.15, "{law}: from {last} N to {force} N");
            }
            (last, was_sticking) = (force, is_sticking);
        }
        assert!(stops > 2, "{law} stops {stops} times");
    }
}

/// `F_s(t) = F_sa + (FsInf - F_sa)*t/(t + gamma)`, with `F_sa = 2.7/(1 + 10^2)` after sliding at ten times `v_s`. At
/// 1 mm/s break-away comes within 3 ms, of which the contact damping carries 1 N.
#[test]
fn armstrong_break_away_grows_with_the_time_at_rest() {
    for rest in [0.02, 0.1, 1.0, 10.0] {
        let mut run = moved("Armstrong", "armstrong").start().unwrap();
        go(&mut run, 0.1, 0.01);
        run.set("driveVelocity", 0.0);
        let now = run.simulation().time();
        run.advance(now + rest).unwrap();
        let found = peak(&mut run, 1e-3, 5e-6, 500);
        let left = 2.7 / 101.0;
        let risen = |time: f64| 8.3 + left + (2.7 - left) * time / (time + 0.1);
        assert!(found > risen(rest) - 0.01 && found < risen(rest + 3e-3) + 1e-9, "{found} N after {rest} s");
    }
}

/// Friction answers a change of speed after `tauL`; before, it belongs to the old speed.
#[test]
fn armstrong_friction_lags_behind_the_speed() {
    let mut run = moved("Armstrong", "armstrong").start().unwrap();
    go(&mut run, 0.05, 0.05);
    let [old, new] = [0.05f64, 5e-3].map(|v| 8.3 + 2.7 / (1.0 + (v / 0.01).powi(2)));
    run.set("driveVelocity", 5e-3);
    for (time, expected) in [(0.0, old), (2e-3, old), (4.99e-3, old), (5.01e-3, new), (0.1, new)] {
        run.advance(1.0 + time).unwrap();
        let found = run.get("frictionForce");
        close(found, expected, 2e-13, format_args!("N after {time} s"));
    }
}

/// A ramp of the speed comes back 5 ms later, exactly, since the delay line has parabolas.
#[test]
fn armstrong_friction_follows_a_ramp_of_the_speed_after_the_delay() {
    let mut run = moved("Armstrong", "armstrong").set("driveVelocity", 0.01).start().unwrap();
    run.advance(0.1).unwrap();
    run.ramp("driveVelocity", 0.01, 0.5);
    for step in 1..50 {
        let time = f64::from(step) * 1e-3;
        run.advance(0.1 + time).unwrap();
        let expected = 8.3 + 2.7 / (1.0 + (1.0 + 50.0 * (time - 5e-3).max(0.0)).powi(2));
        let found = run.get("frictionForce");
        close(found, expected, 1e-13, format_args!("N after {time} s"));
    }
}

/// With a delay of 0.2 s a speed that oscillates with 20 and 60 Hz comes back with the error that the law states:
/// `6.2e-5*(f*tauL)^3` of its amplitude, times the steepest slope of the Stribeck part, `0.65*2.7 N/v_s`. Ramps of 0.1 ms
/// through the sine add `(w*h)^2/12` of it.
#[test]
fn armstrong_long_delay_is_as_accurate_as_stated() {
    const DELAY: f64 = 0.2;
    for frequency in [20.0, 60.0] {
        let speed = |time: f64| 0.03 + 0.02 * (TAU * frequency * time.max(0.0)).sin();
        let rig = moved("Armstrong", "armstrong").set("friction.armstrong.tauL", DELAY);
        let mut run = rig.set("driveVelocity", speed(0.0)).start().unwrap();
        let mut worst = 0.0f64;
        for step in 0..6000 {
            let (from, to) = (f64::from(step) * 1e-4, f64::from(step + 1) * 1e-4);
            run.ramp("driveVelocity", speed(from), (speed(to) - speed(from)) / 1e-4);
            run.advance(to).unwrap();
            let expected = 8.3 + 2.7 / (1.0 + (speed(to - DELAY) / 0.01).powi(2));
            worst = larger(worst, (run.get("frictionForce") - expected).abs());
        }
        let relative = 6.2e-5 * (frequency * DELAY).powi(3) + (TAU * frequency * 1e-4).powi(2) / 12.0;
        let bound = 0.65 * 2.7 / 0.01 * 0.02 * relative;
        loosely(worst, bound, "estimates of two errors that need not meet", format_args!("N at {frequency} Hz"));
    }
}

/// At the start all bonds are stretched alike.
#[test]
fn bristles_first_break_together() {
    let mut run = moved("Bristle", "bristle").start().unwrap();
    let before = go(&mut run, 1e-3, 9.99e-6);
    close(before, 20.0 * 6.2e4 * 9.99e-6, 1e-13, "N");
    assert!(go(&mut run, 1e-3, 0.02e-6) < 0.8 * before);
}

/// `2/3*N*sigma0*deltaS` = 8.267 N, whether breaks are located (1 mm/s) or averaged (0.3 m/s). The force of 20 bristles
/// scatters by 0.65 N and forgets within `deltaS`; the mean over 2000 `deltaS` is good to 0.015 N.
#[test]
fn bristles_slide_with_two_thirds_of_their_strength() {
    let expected = 2.0 / 3.0 * 20.0 * 6.2e4 * 1e-5;
    for velocity in [1e-3, -0.3] {
        let mut run = moved("Bristle", "bristle").start().unwrap();
        go(&mut run, velocity, 1e-3);
        let samples = 4000;
        let sum: f64 = (0..samples).map(|_| go(&mut run, velocity, 5e-6)).sum();
        let mean = sum / f64::from(samples) * velocity.signum();
        close(mean, expected, 0.06, format_args!("N at {velocity} m/s"));
    }
}

/// Averaging changes the force while it lasts, not the bonds: afterwards they are where single breaks would have left
/// them.
#[test]
fn bristles_break_where_the_path_says() {
    let [averaged, located] = [1e-4, 0.0].map(|window| {
        let mut run = moved("Bristle", "bristle").set("friction.bristle.window", window).start().unwrap();
        go(&mut run, 0.1, 5e-4);
        go(&mut run, -0.2, 2e-4);
        go(&mut run, 1e-3, 1e-5);
        run.get("frictionForce")
    });
    close(averaged, located, 1e-10, "N");
}

#[test]
fn bristles_repeat_their_seed_bit_for_bit() {
    let force = |seed: f64| {
        let rig = Rig::bench("Bristle", "SpringPull").set("spring.stiffness", 1e3).set("friction.bristle.seed", seed);
        let mut run = rig.set("driveVelocity", 0.02).start().unwrap();
        run.advance(1.0).unwrap();
        run.get("frictionForce").to_bits()
    };
    assert_eq!(force(1.0), force(1.0));
    assert_ne!(force(1.0), force(2.0));
}

/// At a sample the force follows Maxwell slip with the backward difference as velocity; half a sample time later
/// Maxwell slip has moved on by at most the stiffness 1.5e6 N/m times the path, and by the change of the viscous force.
#[test]
fn dnlrx_samples_maxwell_slip() {
    let [mut sampled, mut continuous] = ["DNLRX", "MaxwellSlip"]
        .map(|law| Rig::bench(law, "PrescribedMotion").set("driveVelocity", 0.0).start().unwrap());
    let mut last = 0.0;
    for step in 0..2000 {
        let time = f64::from(step) * 1e-3;
        let v = 2e-5 * (TAU * time).sin() * (1.0 + 50.0 * time);
        let expected = continuous.get("frictionForce");
        // The sample is taken when the step after it begins.
        sampled.advance(time + 1e-9).unwrap();
        let found = sampled.get("frictionForce");
        close(found, expected, 1e-6, format_args!("N after {time} s"));
        for run in [&mut sampled, &mut continuous] {
            run.set("driveVelocity", v);
            run.advance(time + 5e-4).unwrap();
        }
        let apart = (sampled.get("frictionForce") - continuous.get("frictionForce")).abs();
        let bound = 1.5e6 * v.abs() * 5e-4 + 30.0 * f64::abs(v - last) + 1e-6;
        assert!(apart <= bound, "{apart} N apart, more than {bound} N, after {time} s");
        for run in [&mut sampled, &mut continuous] {
            run.advance(time + 1e-3).unwrap();
        }
        last = v;
    }
}

/// At constant speed the displacement `r` samples ago is `r*v*T_s` behind, so coefficients that add up to 0 give a
/// constant force; a spring at its limit has been there for as long as taps look back.
#[test]
fn dnlrx_remembers_as_many_samples_as_it_is_told() {
    let (speed, sample) = (0.05, 1e-3);
    let coefficients = [1e4, -3e3, 2e3, 5e3, -1.4e4];
    let force = |position_taps: usize, spring_taps: usize| {
        let mut rig = Rig::bench("DNLRX", "PrescribedMotion").set("driveVelocity", speed);
        for (tap, coefficient) in (1..).zip(coefficients) {
            rig = rig.set(&format!("friction.dnlrx.c[{tap}]"), coefficient);
        }
        for spring in 1..=4 {
            let [mut chi0, mut chi1, mut chi2] = [0.0; 3];
            if spring == 2 {
                (chi0, chi1, chi2) = (1e5, 2e5, 4e5);
            }
            for (name, value) in [("chi0", chi0), ("chi1", chi1), ("chi2", chi2)] {
                rig = rig.set(&format!("friction.dnlrx.{name}[{spring}]"), value);
            }
        }
        rig = rig.set("friction.dnlrx.nx", position_taps as f64).set("friction.dnlrx.nchi", spring_taps as f64);
        let mut run = rig.start().unwrap();
        run.advance(20.5 * sample).unwrap();
        (run.get("frictionForce"), run.get("position"))
    };
    for (position_taps, spring_taps) in [(0, 0), (1, 0), (2, 1), (3, 2), (4, 2)] {
        let (found, position) = force(position_taps, spring_taps);
        let last = position - 0.5 * sample * speed;
        let displacements: f64 =
            (0..=position_taps).map(|r| coefficients[r] * (last - r as f64 * sample * speed)).sum();
        let springs = 5.1875e-6 * [1e5, 3e5, 7e5][spring_taps];
        close(found - displacements, springs, 5e-14, format_args!("{position_taps}, {spring_taps}: {found} N"));
    }
}

/// Before the bristle has bent its rate is the velocity, damped by what is left of `sigma1` at that speed.
#[test]
fn lugre_damping_fades_with_its_own_velocity() {
    for (speed, fading) in [(0.01, 0.01), (0.02, 0.01), (0.01, 0.03)] {
        let rig = Rig::bench("LuGre", "PrescribedMotion").set("friction.lugre.vd", fading);
        let mut run = rig.set("driveVelocity", speed).start().unwrap();
        let ratio: f64 = speed / fading;
        let expected = (1000.0 * (-ratio * ratio).exp() + 30.0) * speed;
        let found = run.get("frictionForce");
        close(found, expected, 1e-14 * expected, "N");
    }
}

/// The delay line of Armstrong's law keeps four points within its delay, however long nothing happens.
#[test]
fn armstrong_steps_resolve_the_delay() {
    let mut run = Rig::bench("Armstrong", "PrescribedMotion")
        .set("driveVelocity", 0.1)
        .set("friction.armstrong.tauL", 0.02)
        .start()
        .unwrap();
    run.advance(1.0).unwrap();
    assert!(run.get("solver.steps") >= 200.0, "{} steps", run.get("solver.steps"));
}

/// The default experiment at a loose and at a tight tolerance: a position to a micrometre.
#[test]
fn trajectories_do_not_depend_on_the_tolerance() {
    let laws = [
        "ResetIntegrator",
        "Armstrong",
        "DNLRX",
        "BlimanSorine",
        "ElastoPlastic",
        "StepRegularised",
        "SineRegularised",
        "StickSlipSpring",
        "StickSlipCreep",
    ];
    for law in laws {
        let [loose, tight] = [1e-6, 1e-10].map(|tolerance| {
            let mut run = Rig::cylinder(law).set("solver.relativeTolerance", tolerance).start().unwrap();
            let mut positions = Vec::new();
            for step in 0..3000 {
                let time = f64::from(step) * 1e-3;
                run.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
                run.advance(time + 1e-3).unwrap();
                positions.push(run.get("position"));
            }
            positions
        });
        within(farthest(&loose, &tight), 1e-6, law);
    }
}

/// Load levels that fall to zero and rise again, flat curves, frictionless ones and steep ones: no chatter.
#[test]
fn unusual_parameters_are_survived() {
    let cases: [(&str, &[(&str, f64)]); 14] = [
        ("StickSlipSpring", &[("friction.stickSlipSpring.Fc", 11.0)]),
        ("StickSlipSpring", &[("friction.stickSlipSpring.Fc", 0.0)]),
        ("StickSlipSpring", &[("friction.stickSlipSpring.Fc", 0.0), ("friction.stickSlipSpring.Fs", 0.0)]),
        ("StickSlipSpring", &[("friction.kappaA", -1e-5)]),
        ("StickSlipCreep", &[("friction.stickSlipCreep.Fc", 0.0), ("friction.stickSlipCreep.Fs", 0.0)]),
        ("StickSlipCreep", &[("friction.kappaA", -1e-5)]),
        ("Armstrong", &[("friction.armstrong.FsInf", 0.0)]),
        ("Armstrong", &[("friction.armstrong.FsInf", 0.0), ("friction.armstrong.Fc", 0.0)]),
        ("Armstrong", &[("friction.armstrong.tauL", 0.0)]),
        ("Armstrong", &[("friction.kappaA", -1e-5)]),
        ("ElastoPlastic", &[("friction.elastoPlastic.Fc", 0.0), ("friction.elastoPlastic.delta", 0.5)]),
        ("ElastoPlastic", &[("friction.elastoPlastic.Fc", 11.0), ("friction.elastoPlastic.zbaRatio", 0.99)]),
        ("ElastoPlastic", &[("friction.kappaA", -1e-5)]),
        ("BlimanSorine", &[("friction.kappaA", -1e-5)]),
    ];
    for (law, values) in cases {
        let mut run =
            values.iter().fold(Rig::cylinder(law), |rig, (name, value)| rig.set(name, *value)).start().unwrap();
        for step in 0..2000 {
            let time = f64::from(step) * 1e-3;
            run.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
            run.advance(time + 1e-3).unwrap_or_else(|error| panic!("{law} {values:?}: {error}"));
        }
        let (steps, events) = (run.get("solver.steps"), run.get("solver.events"));
        assert!(steps < 10_000.0 && events < 200.0, "{law} {values:?}: {steps} steps, {events} events");
    }
}
