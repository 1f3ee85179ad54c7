//! The lubricant film of the law RevisedLuGre, against closed forms of its thickness.

use std::f64::consts::TAU;

use crate::bounds::{close, larger, smaller};
use crate::rig::{Rig, Running};

const STATIC: f64 = 11.0;
const COULOMB: f64 = 8.3;
const THICKEST: f64 = 1.0 - COULOMB / STATIC;
/// Time constants in s: growing, shrinking in motion, at rest.
const GROWING: f64 = 0.25;
const SHRINKING: f64 = 1.0;
const AT_REST: f64 = 40.0;

fn bench() -> Running {
    Rig::bench("RevisedLuGre", "PrescribedMotion").set("driveVelocity", 0.1).start().unwrap()
}

fn film(run: &mut Running) -> f64 {
    run.get("friction.revisedLuGre.film")
}

/// Friction of bristles that have settled, in N.
fn settled(velocity: f64, film: f64) -> f64 {
    let stribeck = (-(velocity / 0.01f64).powi(2)).exp();
    COULOMB + ((1.0 - film) * STATIC - COULOMB) * stribeck + 30.0 * velocity
}

/// It grows from nothing, shrinks to the thickness of a lower speed, and shrinks at rest with a third time constant.
#[test]
fn film_follows_the_speed_with_three_time_constants() {
    let mut run = bench();
    run.advance(0.3).unwrap();
    let grown = THICKEST * (1.0 - f64::exp(-0.3 / GROWING));
    close(film(&mut run), grown, 1e-7, "grown");
    run.set("driveVelocity", 0.005);
    run.advance(1.0).unwrap();
    let slow = THICKEST * 0.1f64.powf(2.0 / 3.0);
    let shrunk = slow + (grown - slow) * f64::exp(-0.7 / SHRINKING);
    close(film(&mut run), shrunk, 1e-7, "shrunk");
    close(run.get("frictionForce"), settled(0.005, shrunk), 5e-3, "N, of bristles that follow within 2 ms");
    run.set("driveVelocity", 0.0);
    run.advance(21.0).unwrap();
    close(film(&mut run), shrunk * f64::exp(-20.0 / AT_REST), 1e-7, "at rest");
}

/// Friction at 5 mm/s, 50 ms after a rest, in N, and what is left of the film.
fn after_rest(seconds: f64) -> [f64; 2] {
    let mut run = bench();
    run.advance(5.0).unwrap();
    run.set("driveVelocity", 0.0);
    run.advance(5.0 + seconds).unwrap();
    run.set("driveVelocity", 0.005);
    run.advance(5.05 + seconds).unwrap();
    [run.get("frictionForce"), film(&mut run)]
}

#[test]
fn break_away_grows_with_the_time_at_rest() {
    let mut last = 0.0;
    for seconds in [0.1, 10.0, 40.0, 400.0] {
        let [force, film] = after_rest(seconds);
        close(force, settled(0.005, film), 5e-3, format_args!("N after {seconds} s"));
        assert!(force > last + 0.05, "{force} N after {seconds} s, {last} N after less");
        last = force;
    }
}

/// Friction while the speed rises less that while it falls, in N, at 12 mm/s amid a swing of 10 mm/s.
fn width_of_loop(frequency: f64) -> f64 {
    const STEPS: usize = 400;
    let mut run = bench();
    let mut forces = [0.0; 2];
    for step in 0..=3 * STEPS {
        let phase = step as f64 / STEPS as f64;
        run.set("driveVelocity", 0.012 + 0.01 * (TAU * phase).sin());
        let end = (step + 1) as f64 / STEPS as f64 / frequency;
        run.advance(end).unwrap();
        match step {
            _ if step == 3 * STEPS => forces[0] = run.get("frictionForce"),
            _ if step == 5 * STEPS / 2 => forces[1] = run.get("frictionForce"),
            _ => {}
        }
    }
    forces[0] - forces[1]
}

#[test]
fn hysteresis_widens_with_frequency() {
    let [slow, medium, fast] = [0.02, 0.1, 0.4].map(width_of_loop);
    assert!(0.01 < slow && 2.0 * slow < medium && medium < fast, "{slow} N, {medium} N, {fast} N");
}

/// A film that takes days to grow leaves the law LuGre as published, with constant damping.
#[test]
fn law_without_film_is_lugre() {
    let pulled = |law: &str, changes: &[(&str, f64)]| {
        let rig = Rig::bench(law, "SpringPull").set("spring.stiffness", 1e3).set("driveVelocity", 0.01);
        let rig = changes.iter().fold(rig, |rig, (name, value)| rig.set(name, *value));
        rig.set("solver.relativeTolerance", 1e-9).start().unwrap()
    };
    let mut runs = [
        pulled("LuGre", &[("friction.lugre.vd", 0.0), ("friction.lugre.sigma1", 100.0)]),
        pulled(
            "RevisedLuGre",
            &[
                ("friction.revisedLuGre.vd", 0.0),
                ("friction.revisedLuGre.sigma1", 100.0),
                ("friction.revisedLuGre.tauHp", 1e6),
            ],
        ),
    ];
    let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
    for step in 1..=200 {
        let [expected, found] = runs.each_mut().map(|run| {
            run.advance(0.02 * f64::from(step)).unwrap();
            run.get("frictionForce")
        });
        close(found, expected, 1e-3, format_args!("N after {step} steps"));
        (least, most) = (smaller(least, found), larger(most, found));
    }
    assert!(most - least > 2.0, "it sticks and slips: {least} N to {most} N");
}
