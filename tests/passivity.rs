//! No friction law gives back more energy than it can have stored, however its load level varies in space and time.

mod random;
mod rig;

use std::f64::consts::TAU;

use pneumatic_servo::friction::LAWS;
use random::Random;
use rig::{Rig, Running};

/// Levels between which the load varies.
const LEVELS: [f64; 2] = [0.1, 1.9];

/// The largest energy in J that a law with its defaults stores at these levels.
fn stored(law: &str) -> f64 {
    let [least, most] = LEVELS;
    let spring = |force: f64, stiffness: f64| (most * force).powi(2) / (2.0 * stiffness);
    match law {
        "Dahl" => spring(10.6, 8e6),
        "Bristle" => spring(20.0 * 6.2e4 * 1e-5, 20.0 * 6.2e4),
        "ResetIntegrator" => 1.325 * spring(8.3, 1e6),
        "Armstrong" | "LuGre" | "ElastoPlastic" => spring(11.0, 1e6),
        "Leuven" => {
            // Bent to the static friction, by bisection; the energy on the virgin curve.
            let (k1, f1, f2) = (1.483e6, most * 5.595, 5.631e5);
            let force = |z: f64| k1 * z + f1 * (1.0 - f64::exp(-f2 * z));
            let halve = |[low, high]: [f64; 2], _| {
                let middle = 0.5 * (low + high);
                if force(middle) < most * 11.0 { [middle, high] } else { [low, middle] }
            };
            let [z, _] = (0..60).fold([0.0, 1e-4], halve);
            0.5 * k1 * z * z + f1 / f2 * (1.0 - (1.0 + f2 * z) * f64::exp(-f2 * z))
        }
        "GMS" => [4e5, 3e5, 2e5, 1e5].iter().map(|k| spring(11.0 / 4.0, *k)).sum(),
        "MaxwellSlip" | "DNLRX" => [8e5, 4e5, 2e5, 1e5].iter().map(|k| spring(2.075, *k)).sum(),
        "BlimanSorine" => {
            let (f1, f2, eta, path) = (24.6, 16.3, 0.5, 1e-5);
            let c = 2.0 * path * eta * (f1 - eta * f2) / (f1 * f2 * f64::powi(1.0 - eta, 2));
            let (p1, p2) = (eta * (path + c * f2) / f1, (c * f1 / eta - path) / f2);
            // The forces of the highest level at the lowest.
            let (z1, z2) = (most * f1, -most * f2);
            (p1 * z1 * z1 + 2.0 * c * z1 * z2 + p2 * z2 * z2) / (2.0 * least)
        }
        "StickSlipSpring" => spring(11.0, 1e5),
        "StickSlipCreep" => 0.5 * most * 11.0 * 1e-5,
        _ => 0.0,
    }
}

/// A motion back and forth at speeds from 0.1 mm/s to 1 m/s, under a load level with waves along the path and in time: what
/// friction takes, as a sum that grows but for what it gives back.
struct Motion {
    run: Running,
    random: Random,
    phase: f64,
    /// Work in J that friction has taken, and the most it had taken before.
    taken: f64,
    most: f64,
    /// The largest energy in J given back.
    given_back: f64,
}

impl Motion {
    /// Without viscous friction, which would help.
    fn of(law: &str) -> Self {
        let rig = Rig::bench(law, "PrescribedMotion");
        let rig = match law_without_viscous_friction(law) {
            Some(name) => rig.set(&name, 0.0),
            None => rig,
        };
        let run = rig.set("driveVelocity", 0.0).start().unwrap();
        Self { run, random: Random(7), phase: 0.0, taken: 0.0, most: 0.0, given_back: 0.0 }
    }

    /// Goes on at a velocity in m/s for a path in m.
    fn go(&mut self, velocity: f64, path: f64) {
        const PIECE: f64 = 1e-7;
        let pieces = (path / PIECE).ceil() as usize;
        let duration = PIECE / velocity.abs();
        for _ in 0..pieces {
            self.phase += 0.03;
            let waves = (TAU * self.run.get("position") / 5e-5).sin() + self.phase.sin();
            let [least, most] = LEVELS;
            self.run.set("friction.level", 0.5 * (least + most) + 0.25 * (most - least) * waves);
            self.run.set("driveVelocity", velocity);
            let before = self.run.get("frictionForce");
            let end = self.run.simulation().time() + duration;
            self.run.advance(end).unwrap();
            let force = 0.5 * (before + self.run.get("frictionForce"));
            self.taken += force * velocity * duration;
            self.most = self.most.max(self.taken);
            self.given_back = self.given_back.max(self.most - self.taken);
        }
    }

    /// The largest energy in J given back in sixty reversals, here and there with less than a millimetre per second.
    fn given_back(mut self) -> f64 {
        for reversal in 0..60 {
            let speed = 10f64.powf(self.random.between(-4.0, 0.0));
            let path = self.random.between(1e-6, 4e-5);
            self.go(if reversal % 2 == 0 { speed } else { -speed }, path);
        }
        self.given_back
    }
}

/// The coefficient of viscous friction of a law, if it has one.
fn law_without_viscous_friction(law: &str) -> Option<String> {
    let group = law[..1].to_lowercase() + &law[1..];
    let group = match law {
        "GMS" | "DNLRX" => law.to_lowercase(),
        "LuGre" => "lugre".to_owned(),
        _ => group,
    };
    let has_none = ["None", "Polito", "DNLRX"].contains(&law);
    (!has_none).then(|| format!("friction.{group}.sigma2"))
}

#[test]
fn laws_give_back_no_more_than_they_store() {
    for (_, law, _) in LAWS.items {
        let (given, stored) = (Motion::of(law).given_back(), stored(law));
        println!("{law}: {given:.2e} J given back, {stored:.2e} J stored");
        if *law == "DNLRX" {
            // Sampled: the force of the last sample drives the mass after a reversal. Its page says so.
            assert!(given > stored, "{law}: {given} J given back of {stored} J");
            continue;
        }
        // A break within a piece of the path is counted in the middle of it: 11 N along a tenth of a micrometre.
        let rounding = if stored > 0.0 { 2e-6 } else { 1e-12 };
        assert!(given < stored + rounding, "{law}: {given} J given back, {stored} J stored");
    }
}

/// DNLRX is sampled, and gives back more than its springs hold where the motion turns within a sample: the figures of its page,
/// 9.9e-5 J in the default experiment of the cylinder, where the springs hold 4.0e-5 J at level 1.
#[test]
fn sampled_law_gives_back_more_than_its_springs_hold() {
    let mut run = Rig::cylinder("DNLRX").start().unwrap();
    let (mut taken, mut most, mut given_back) = (0.0, 0.0f64, 0.0f64);
    // The force is that of the last sample, of which there is one each millisecond: it is constant within each step.
    for step in 0..30_000 {
        let time = f64::from(step) * 1e-4;
        if step % 10 == 0 {
            run.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin());
        }
        let before = run.get("position");
        run.advance(time + 0.5e-4).unwrap();
        let force = run.get("frictionForce");
        run.advance(time + 1e-4).unwrap();
        taken += force * (run.get("position") - before);
        most = most.max(taken);
        given_back = given_back.max(most - taken);
    }
    let springs = stored("DNLRX") / LEVELS[1].powi(2);
    assert!((9.85e-5..9.95e-5).contains(&given_back), "{given_back} J");
    assert!((3.95e-5..4.05e-5).contains(&springs), "{springs} J");
}

/// What the stored energy takes up is less than the power of friction, at every instant.
#[test]
fn bristles_are_passive_at_every_instant_under_any_level() {
    for (law, stiffness) in [("Dahl", 8e6), ("ElastoPlastic", 1e6)] {
        let mut motion = Motion::of(law);
        for reversal in 0..40 {
            let speed = 10f64.powf(motion.random.between(-4.0, 0.0));
            let velocity = if reversal % 2 == 0 { speed } else { -speed };
            for _ in 0..100 {
                motion.go(velocity, 2e-7);
                let [force, z, rate] =
                    ["frictionForce", "friction.deflection", "der(friction.deflection)"].map(|it| motion.run.get(it));
                let (taken, stored) = (force * velocity, stiffness * z * rate);
                let rounding = 1e-9 * (taken.abs() + stored.abs());
                assert!(taken - stored >= -rounding, "{law}: {taken} W against {stored} W at {velocity} m/s");
            }
        }
    }
}
