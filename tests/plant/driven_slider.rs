//! The driven slider: closed forms of sticking, sliding and stick-slip on a shaken tray, and the walk beside it.

use std::f64::consts::{PI, TAU};

use crate::bounds::{close, larger, within};
use crate::rig::{Rig, watch};

const GRAVITY: f64 = 9.80665;
const MASS: f64 = 21.19e-3;
const FREQUENCY: f64 = 20.0;
const W: f64 = TAU * FREQUENCY;
const PERIOD: f64 = 1.0 / FREQUENCY;

/// A slider with friction coefficients on a tray that reaches an acceleration in units of g.
fn slider(law: &str, statics: f64, dynamic: f64, acceleration: f64) -> Rig {
    Rig::new("DrivenSlider")
        .choose("friction.law", law)
        .set("muDynamic", dynamic)
        .set("muStatic", statics)
        .set("tray.velocityAmplitude", acceleration * GRAVITY / W)
        .set("walk.stepsPerPeriod", 0.0)
        .set("solver.relativeTolerance", 1e-10)
}

const SET_VALUED: [&str; 4] = ["Coulomb", "CoulombStiction", "Stribeck", "Polito"];

/// A ten-thousandth below the threshold nothing moves by a bit; a ten-thousandth above it the slider breaks away, though
/// it does so only in a hundredth of the period.
#[test]
fn slider_is_stuck_exactly_up_to_the_threshold() {
    for law in SET_VALUED {
        // Coulomb's law breaks away at the dynamic coefficient.
        let threshold = if law == "Coulomb" { 0.32 } else { 0.4 };
        let mut stuck = slider(law, 0.4, 0.32, threshold * (1.0 - 1e-4)).start().unwrap();
        watch(&mut stuck, 1.0, 7e-3, |time, run| {
            assert_eq!(run.get("relativePosition").to_bits(), 0, "{law} at {time} s");
            assert_eq!(run.get("velocity").to_bits(), run.get("tray.velocity").to_bits(), "{law}");
            assert_eq!(run.get("sticking"), 1.0, "{law}");
            let balance = run.get("frictionForce") + MASS * run.get("tray.acceleration");
            assert_eq!(balance, 0.0, "{law}, N");
        });
        assert_eq!(stuck.get("solver.events"), 0.0, "{law}");
        let mut loose = slider(law, 0.4, 0.32, threshold * (1.0 + 1e-4)).start().unwrap();
        loose.advance(PERIOD).unwrap();
        assert!(loose.get("solver.events") >= 2.0, "{law} does not break away");
    }
}

/// Without rest the velocity is a triangle of slope mu*g and amplitude pi*mu*g/(2*w). The start is forgotten at a rate of
/// about a third per period.
#[test]
fn strong_shaking_makes_an_exact_triangle() {
    let mu = 0.32;
    let limit = 1.0 / (1.0 + PI * PI / 4.0).sqrt();
    close(limit, 0.537, 2e-4, "strong shaking makes an exact triangle");
    for acceleration in [1.02 * mu / limit, 2.0 * mu / limit] {
        let mut run = slider("Coulomb", mu, mu, acceleration).start().unwrap();
        run.advance(60.0 * PERIOD).unwrap();
        let mut top = [0.0f64; 2];
        watch(&mut run, 62.0 * PERIOD, PERIOD / 4000.0, |time, run| {
            assert_eq!(run.get("sticking"), 0.0, "rests at {time} s");
            let a = run.get("acceleration");
            close(a.abs(), mu * GRAVITY, 5e-14, format_args!("slope {a}"));
            let v = run.get("velocity");
            top = [larger(top[0], v), larger(top[1], -v)];
        });
        let amplitude = PI * mu * GRAVITY / (2.0 * W);
        // The peak lies within half a sample: 12.5 us of the slope.
        let resolution = mu * GRAVITY * PERIOD / 8000.0;
        for top in top {
            close(top, amplitude, resolution, "m/s");
        }
    }
}

#[test]
fn weaker_shaking_makes_the_slider_rest() {
    let mu = 0.32;
    let limit = 1.0 / (1.0 + PI * PI / 4.0).sqrt();
    let mut run = slider("Coulomb", mu, mu, 0.98 * mu / limit).start().unwrap();
    run.advance(60.0 * PERIOD).unwrap();
    let mut rests = false;
    watch(&mut run, 61.0 * PERIOD, PERIOD / 4000.0, |_, run| rests |= run.get("sticking") == 1.0);
    assert!(rests);
}

/// Phases of break-away and of the stop after it, and the path on the tray in between, in units of v_d/w.
fn closed_form(break_away: f64, kinetic: f64) -> (f64, f64, f64) {
    let start = break_away.asin();
    // The slider is ahead of the tray until their velocities agree again.
    let ahead = |phase: f64| start.cos() - kinetic * (phase - start) - phase.cos();
    let (mut low, mut high) = (start + 0.05, start + TAU);
    for step in 0..10_000 {
        let phase = low + (high - low) * f64::from(step) / 10_000.0;
        if ahead(phase) < 0.0 {
            high = phase;
            break;
        }
    }
    while high - low > 1e-14 {
        let middle = 0.5 * (low + high);
        if ahead(middle) > 0.0 { low = middle } else { high = middle }
    }
    let slide = low - start;
    (start, low, start.cos() * slide - 0.5 * kinetic * slide * slide - (low.sin() - start.sin()))
}

/// Sticks and slips twice per period; phases are sampled every microsecond, paths are exact but for the tolerance.
#[test]
fn switching_phases_of_stick_slip_have_a_closed_form() {
    for (statics, dynamic, acceleration) in [(0.32, 0.32, 0.45), (0.4, 0.32, 0.5), (0.4, 0.3, 0.44)] {
        let (start, stop, path) = closed_form(statics / acceleration, dynamic / acceleration);
        assert!(stop < start + PI, "this set rests");
        let path = path * acceleration * GRAVITY / (W * W);
        let mut run = slider("CoulombStiction", statics, dynamic, acceleration).start().unwrap();
        // In the middle of the rest before the first slip.
        let middle = 2.0 * PERIOD + 0.5 * (stop - PI + start) / W;
        run.advance(middle).unwrap();
        assert_eq!(run.get("sticking"), 1.0);
        let mut changes = Vec::new();
        let mut was_sticking = true;
        watch(&mut run, middle + PERIOD, 1e-6, |time, run| {
            if (run.get("sticking") == 1.0) != was_sticking {
                was_sticking = !was_sticking;
                changes.push((time - 2.0 * PERIOD, run.get("relativePosition")));
            }
        });
        let phases = [start, stop, start + PI, stop + PI].map(|phase| phase / W);
        assert_eq!(changes.len(), 4, "{changes:?}");
        for ((time, _), expected) in changes.iter().zip(phases) {
            assert!(*time >= expected - 1e-12 && *time < expected + 1.01e-6, "{time} s, not {expected} s");
        }
        assert!(
            (changes[1].1 - changes[0].1 + path).abs() < 1e-11 || (changes[1].1 - changes[0].1 - path).abs() < 1e-11
        );
        close(changes[3].1 + changes[1].1 - changes[2].1, changes[0].1, 5e-17, "the way back is the same");
    }
}

/// Path on the tray in one slip at an acceleration just above the threshold of break-away.
fn path_at_onset(statics: f64, excess: f64) -> f64 {
    let mut run = slider("CoulombStiction", statics, 0.32, statics * (1.0 + excess)).start().unwrap();
    let mut furthest = 0.0f64;
    watch(&mut run, 3.0 * PERIOD, PERIOD / 400.0, |_, run| {
        furthest = larger(furthest, run.get("relativePosition").abs())
    });
    furthest
}

/// With mu_stat = mu_dyn the slip grows from nothing; with mu_stat > mu_dyn it sets in with its closed form.
#[test]
fn static_friction_makes_the_onset_a_jump() {
    assert!(path_at_onset(0.32, 1e-4) < 1e-9);
    let (.., path) = closed_form(1.0 / (1.0 + 1e-7), 0.8 / (1.0 + 1e-7));
    let path = path.abs() * 0.4 * GRAVITY / (W * W);
    assert!(path > 1e-5);
    let found = path_at_onset(0.4, 1e-7);
    close(found, path, 5e-7 * path, "m");
}

/// The published measurement of mu_dyn: a kick on a tray at rest, and a stop after v^2/(2*mu*g).
#[test]
fn kicked_slider_stops_for_good_after_its_braking_distance() {
    let mut run = slider("CoulombStiction", 0.4, 0.32, 0.0).set("relativeVelocity0", 0.3).start().unwrap();
    let distance = 0.3f64.powi(2) / (2.0 * 0.32 * GRAVITY);
    run.advance(0.3 / (0.32 * GRAVITY) + 1e-6).unwrap();
    let stop = run.get("position");
    close(stop, distance, 2e-16, "m");
    run.advance(10.0).unwrap();
    assert_eq!(run.get("position").to_bits(), stop.to_bits());
    assert_eq!(run.get("velocity"), 0.0);
}

/// In the end the second half of a period mirrors the first.
#[test]
fn motion_is_odd_in_time_after_the_start() {
    for law in ["CoulombStiction", "Stribeck", "Dahl", "ElastoPlastic", "StribeckRegularised"] {
        let mut run = slider(law, 0.4, 0.32, 0.5).start().unwrap();
        run.advance(200.0 * PERIOD).unwrap();
        let mut velocities = Vec::new();
        watch(&mut run, 201.0 * PERIOD, PERIOD / 100.0, |_, run| velocities.push(run.get("velocity")));
        for (first, second) in velocities.iter().zip(&velocities[50..]) {
            within((first + second).abs(), 1e-11, format_args!("{law}: {first} and {second} m/s"));
        }
    }
}

/// m*dv = -integral of friction over a long run, by Simpson's rule on samples of a smooth law.
#[test]
fn momentum_comes_from_friction_alone() {
    let rig = slider("LuGre", 0.4, 0.32, 0.5).set("friction.lugre.sigma0", 5e3);
    let mut run = rig.set("friction.lugre.sigma1", 20.03).set("friction.lugre.vd", 1e3).start().unwrap();
    let interval = PERIOD / 2000.0;
    let before = run.get("velocity");
    let (mut impulse, mut index) = (run.get("frictionForce"), 0);
    watch(&mut run, 4.0 * PERIOD, interval, |_, run| {
        index += 1;
        impulse += run.get("frictionForce") * if index == 8000 { 1.0 } else { 2.0 + 2.0 * f64::from(index % 2) };
    });
    let change = MASS * (run.get("velocity") - before);
    within((change + impulse * interval / 3.0).abs(), 5e-8, format_args!("{change} and {impulse}"));
}

fn walk(seed: f64) -> Rig {
    Rig::new("DrivenSlider").set("walk.seed", seed).set("muStatic", 0.8)
}

fn velocities(rig: &Rig, interval: f64) -> Vec<f64> {
    let mut run = rig.start().unwrap();
    let mut velocities = Vec::new();
    watch(&mut run, 0.2, interval, |_, run| velocities.push(run.get("walk.velocity")));
    velocities
}

/// The walk has its own seed and clock: neither law nor communication step change it.
#[test]
fn walk_depends_on_its_seed_alone() {
    // Samples in the middle of the walk's time steps of 0.1 ms.
    let reference = velocities(&walk(1.0), 5e-5);
    for law in ["None", "Stribeck", "LuGre"] {
        assert_eq!(velocities(&walk(1.0).choose("friction.law", law), 5e-5), reference, "{law}");
    }
    let every_tenth: Vec<f64> = reference.iter().skip(8).step_by(10).copied().collect();
    let mut run = walk(1.0).start().unwrap();
    for (index, expected) in every_tenth.iter().enumerate() {
        run.advance((9.0 + 10.0 * index as f64) * 5e-5).unwrap();
        assert_eq!(run.get("walk.velocity"), *expected);
    }
    assert_ne!(velocities(&walk(2.0), 5e-5), reference);
}

/// The velocity moves by at most mu_dyn*g*dt per time step, and lies between the attractors but for that.
#[test]
fn walk_moves_by_single_steps_between_the_attractors() {
    let step = 0.32 * GRAVITY * PERIOD / 500.0;
    let mut run = walk(1.0).start().unwrap();
    close(run.get("walk.chi"), 0.6 * 0.04 * W / GRAVITY, 5e-15, "walk moves by single steps between the attractors");
    let mut last = run.get("walk.velocity");
    watch(&mut run, 0.2, PERIOD / 500.0, |time, run| {
        let velocity = run.get("walk.velocity");
        let steps = (velocity - last) / step;
        assert!(steps.abs() < 1.0 + 1e-9 && (steps - steps.round()).abs() < 1e-9, "{steps} steps at {time} s");
        last = velocity;
    });
}

#[test]
fn coefficients_that_do_not_fit_are_refused_by_name() {
    let error = Rig::new("DrivenSlider").set("muStatic", 0.3).start().err().expect("a refusal");
    assert_eq!((error.variable.as_str(), error.value), ("muStatic", 0.3));
    let equal = Rig::new("DrivenSlider").choose("friction.law", "VelocityBased").set("muStatic", 0.32);
    let error = equal.start().err().expect("a refusal");
    assert_eq!((error.variable.as_str(), error.value), ("muDynamic", 0.32));
}
