//! The bench moved and loaded as measured: a prescribed position, and a load level over time.

use crate::bounds::{close, larger};
use crate::rig::{Rig, Running};

/// Interval of the samples in s.
const SAMPLE: f64 = 5e-3;

/// A position in m as an encoder of 1 um gives it: back and forth, with rests between.
fn sample(index: u32) -> f64 {
    let swing = (f64::from(index) * SAMPLE * 2.0).sin().clamp(-0.8, 0.8);
    (swing * 2000.0).round() * 1e-6
}

/// Moves the bench to the sample of an index.
fn move_to(run: &mut Running, index: u32) {
    run.set("prescribedPosition", sample(index));
    run.advance(f64::from(index) * SAMPLE).expect("a step that ends");
}

#[test]
fn prescribed_position_passes_through_all_samples() {
    let mut run = Rig::bench("LuGre", "PrescribedPosition").start().unwrap();
    let mut rests = 0;
    for index in 1..1000 {
        move_to(&mut run, index);
        let (position, velocity) = (run.get("position"), run.get("velocity"));
        // A thousand additions of at most 2 mm round by 1e-16 m.
        close(position, sample(index), 1e-16, format_args!("m at sample {index}"));
        assert_eq!(
            velocity,
            (sample(index) - sample(index - 1)) / (f64::from(index) * SAMPLE - f64::from(index - 1) * SAMPLE)
        );
        rests += i32::from(velocity == 0.0);
    }
    assert!(rests > 300, "{rests}");
}

/// The same straight lines, given as velocities, with every law that there is.
#[test]
fn prescribed_position_gives_the_forces_of_its_velocity() {
    for law in laws() {
        let mut by_position = Rig::bench(law, "PrescribedPosition").set("driveVelocity", 0.0).start().unwrap();
        let mut by_velocity = Rig::bench(law, "PrescribedMotion").set("driveVelocity", 0.0).start().unwrap();
        for index in 1..400 {
            move_to(&mut by_position, index);
            by_velocity.set("driveVelocity", by_position.get("velocity"));
            by_velocity.advance(f64::from(index) * SAMPLE).expect("a step that ends");
            let [a, b] = [&mut by_position, &mut by_velocity].map(|run| run.get("frictionForce"));
            assert_eq!(a, b, "{law} at sample {index}");
        }
    }
}

#[test]
fn prescribed_position_goes_on_from_a_saved_state() {
    let mut run = Rig::bench("GMS", "PrescribedPosition").start().unwrap();
    (1..150).for_each(|index| move_to(&mut run, index));
    let saved = run.simulation().save();
    let mut ahead = || {
        (150..300).for_each(|index| move_to(&mut run, index));
        let seen = (run.get("position"), run.get("frictionForce"));
        run.simulation().restore(&saved).expect("its own state");
        seen
    };
    assert_eq!(ahead(), ahead());
}

/// In steady sliding the viscous part is free of the load, the rest goes with it. Bonds that break have no steady force,
/// sampled springs of DNLRX none beside their own parameters, and creep of the stick-slip laws ends where they slip.
#[test]
fn steady_friction_grows_with_the_load_level() {
    let rigs = [
        "Coulomb",
        "CoulombStiction",
        "SmoothCoulomb",
        "Stribeck",
        "Polito",
        "Dahl",
        "LuGre",
        "GMS",
        "MaxwellSlip",
        "Leuven",
    ];
    for law in rigs {
        let force = |level: f64| {
            let rig = Rig::bench(law, "PrescribedMotion").set("friction.level", level).set("driveVelocity", 0.1);
            let mut run = rig.start().unwrap();
            run.advance(2.0).unwrap();
            run.get("frictionForce")
        };
        let (none, one, three) = (force(0.0), force(1.0), force(3.0));
        assert!(one - none > 5.0, "{law}: {one} N, {none} N without load");
        // LuGre and GMS come up to their level exponentially, and are there long before.
        close(three - none, 3.0 * (one - none), 5e-13, format_args!("{law}: {none}, {one}, {three} N"));
    }
}

#[test]
fn every_law_survives_a_load_that_jumps() {
    for law in laws() {
        let mut run = Rig::bench(law, "PrescribedPosition").start().unwrap();
        let mut strongest = 0.0f64;
        for index in 1..600 {
            run.set("friction.level", [1.0, 2.0, 0.0, 0.5][index as usize / 7 % 4]);
            move_to(&mut run, index);
            let force = run.get("frictionForce");
            assert!(force.is_finite() && force.abs() < 200.0, "{law}: {force} N at sample {index}");
            strongest = larger(strongest, force.abs());
        }
        assert!(law == "None" || strongest > 1.0, "{law}: {strongest} N");
    }
}

/// The names of all laws.
fn laws() -> impl Iterator<Item = &'static str> {
    pneumatic_servo::friction::LAWS.items.iter().map(|(_, name, _)| *name)
}
