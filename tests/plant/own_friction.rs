//! Static friction that grows at rest, and with a load level of its own.

use crate::bounds::close;
use crate::rig::{Rig, Running};

/// Laws whose break-away force grows at rest, with the parameter that says so and its value, and the force in N at once and after a long
/// rest.
const GROWING: [(&str, &str, f64, [f64; 2]); 5] = [
    ("Stribeck", "friction.stribeck.FsInf", 16.0, [11.0, 16.0]),
    ("Coulomb", "friction.coulomb.restGrowth", 0.5, [8.3, 12.45]),
    ("CoulombStiction", "friction.coulombStiction.restGrowth", 0.2, [11.0, 13.2]),
    ("Polito", "friction.polito.restGrowth", 0.5, [10.8, 16.2]),
    ("Table", "friction.table.restGrowth", 1.0, [11.0, 22.0]),
];

/// A free mass under a law.
fn free(law: &str, values: &[(&str, f64)]) -> Running {
    let rig = Rig::bench(law, "Free");
    values.iter().fold(rig, |rig, (name, value)| rig.set(name, *value)).start().unwrap()
}

/// The same under a law that grows, half of it in half a second.
fn growing((law, name, value, _): (&str, &str, f64, [f64; 2])) -> Running {
    let (group, _) = name.rsplit_once('.').expect("a group");
    free(law, &[(name, value), (&format!("{group}.gamma"), 0.5)])
}

/// Whether a force is held, from a time in s on; a microsecond tells.
fn holds(run: &mut Running, force: f64, time: f64) -> bool {
    run.set("appliedForce", force);
    run.advance(time + 1e-6).unwrap();
    run.get("sticking") == 1.0
}

/// A force that rises by 100 N/s meets the static friction of a contact that has rested for ever.
#[test]
fn first_break_away_is_that_of_a_long_rest() {
    for growth in GROWING {
        let (law, .., [_, rested]) = growth;
        let mut run = growing(growth);
        run.ramp("appliedForce", 0.0, 100.0);
        let time = rested / 100.0;
        run.advance(time - 1e-9).unwrap();
        assert_eq!((run.get("sticking"), run.get("position")), (1.0, 0.0), "{law}");
        run.ramp("appliedForce", rested - 1e-7, 100.0);
        run.advance(time + 1e-6).unwrap();
        assert!(run.get("sticking") == 0.0 && run.get("velocity") > 0.0, "{law}");
    }
}

/// `F(t) = F + (F_inf - F)*t/(t + 0.5)`. The rest begins within 10 us of where the steps see it, in which it grows by 0.2 mN.
#[test]
fn later_break_away_grows_with_the_time_at_rest() {
    for (growth, rest) in GROWING.into_iter().flat_map(|growth| [0.01, 0.5, 1.0, 20.0].map(|rest| (growth, rest))) {
        let (law, .., [fresh, rested]) = growth;
        let mut run = growing(growth);
        assert!(!holds(&mut run, 25.0, 0.0));
        run.set("appliedForce", -3.0);
        let mut time = 1e-6;
        while run.get("sticking") == 0.0 {
            time += 1e-5;
            run.advance(time).unwrap();
        }
        run.set("appliedForce", 0.0);
        time += rest;
        run.advance(time).unwrap();
        let expected = fresh + (rested - fresh) * rest / (rest + 0.5);
        assert!(holds(&mut run, expected - 1e-3, time), "{law}: {expected} N after {rest} s");
        assert!(!holds(&mut run, expected + 1e-3, time + 2e-6), "{law}: {expected} N after {rest} s");
        // After a slip the mass slides at once as if it had never rested.
        let speed = run.get("velocity");
        let coulomb = if law == "Polito" { 7.8 } else { 8.3 };
        let sliding = match law {
            "Coulomb" | "CoulombStiction" => coulomb,
            // The table has points of this curve, the first two at 0 and 2 mm/s.
            _ => coulomb + (fresh - coulomb) * (-(speed / 0.01).powi(2)).exp(),
        };
        let viscous = if law == "Polito" { 33.0 } else { 30.0 };
        close(run.get("frictionForce"), sliding + viscous * speed, if law == "Table" { 5e-4 } else { 1e-13 }, law);
    }
}

/// Half as much load again: half as much Coulomb friction again, and of static friction as the ratio says, but no less
/// than the former.
#[test]
fn static_friction_grows_with_the_load_at_its_own_pace() {
    for (ratio, expected) in [(0.0, 1.5 * 8.3), (0.5, 13.75), (1.0, 16.5), (2.0, 22.0)] {
        let mut run = free("Stribeck", &[("friction.stribeck.kappaRatio", ratio), ("friction.level", 1.5)]);
        assert!(holds(&mut run, expected - 1e-6, 0.0) && !holds(&mut run, expected + 1e-6, 2e-6), "ratio {ratio}");
        let drive = Rig::bench("Stribeck", "PrescribedMotion").set("friction.stribeck.kappaRatio", ratio);
        let mut run = drive.set("friction.level", 1.5).set("driveVelocity", 1.0).start().unwrap();
        run.advance(0.01).unwrap();
        let found = run.get("frictionForce");
        close(found, 1.5 * 8.3 + 30.0, 5e-13, format_args!("N at a ratio of {ratio}"));
    }
}

/// Saved in the middle of a rest, a run goes on to the same break-away.
#[test]
fn saved_rest_goes_on() {
    for growth in GROWING {
        let mut run = growing(growth);
        assert!(!holds(&mut run, 25.0, 0.0));
        run.set("appliedForce", -3.0);
        run.advance(0.3).unwrap();
        assert_eq!(run.get("sticking"), 1.0);
        let saved = run.simulation().save();
        let broken = |run: &mut Running| {
            run.ramp("appliedForce", 0.0, 20.0);
            run.advance(1.3).unwrap();
            ["position", "velocity"].map(|name| run.get(name).to_bits())
        };
        let first = broken(&mut run);
        assert_ne!(first[1], 0);
        run.simulation().restore(&saved).unwrap();
        assert_eq!(broken(&mut run), first);
    }
}

#[test]
fn rested_friction_below_the_static_one_is_refused() {
    let error = Rig::bench("Stribeck", "Free").set("friction.stribeck.FsInf", 9.0).start().err().unwrap();
    let expected = "friction.stribeck.FsInf = 9 is refused: it must be 0, for no growth, or at least the static friction \
                    Fs = 11";
    assert_eq!(error.to_string(), expected);
}

mod with_a_delta {
    use pneumatic_servo::models::vibro_impact;
    use pneumatic_servo::prelude::*;

    parameters! {
        /// A law with a parameter whose name another law uses for the exponent of its Stribeck curve.
        Wedge {
            angle: f64 = Variable::parameter(0, "delta", units::ONE, 3.0).text("Angle of the wedge");
        }
    }

    impl VelocityLaw for Wedge {
        fn force<S: Scalar>(&self, v: S, level: S) -> S {
            (v * self.angle).tanh() * level
        }
    }

    laws! {
        /// All laws, and a wedge.
        mod catalogue {
            ..builtin;
            1000 Wedge "wedge" OfVelocity<Wedge>, "A wedge";
        }
    }

    static MODEL: Model = vibro_impact::model::<catalogue::Friction>();

    /// The vibro-impact model takes an exponent of 1 from its source, not another parameter named `delta`.
    #[test]
    fn a_name_is_no_meaning() {
        let table = MODEL.table();
        let start = |name: &str| table.find(name).and_then(|entry| entry.variable.start);
        assert_eq!([start("friction.stribeck.delta"), start("friction.wedge.delta")], [Some(1.0), Some(3.0)]);
        let (choice, laws) = table.friction_law().expect("a law to choose");
        assert_eq!((choice.name.as_str(), laws.id("Wedge")), ("friction.law", Some(1000)));
        let case = table.find("friction.wedge.delta").and_then(|entry| entry.variable.counts_for);
        let (choice, item) = case.and_then(|case| table.case(case)).expect("it counts for its law alone");
        assert_eq!((choice.name.as_str(), item), ("friction.law", "Wedge"));
    }
}
