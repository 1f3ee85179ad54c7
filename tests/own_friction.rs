//! Static friction that grows at rest, and with a load level of its own.

mod bounds;
mod rig;

use bounds::close;
use rig::{Rig, Running};

/// A free mass under the Stribeck law, with 11 N of static friction and 8.3 N of Coulomb friction.
fn free(values: &[(&str, f64)]) -> Running {
    let rig = Rig::bench("Stribeck", "Free").set("friction.stribeck.gamma", 0.5);
    values.iter().fold(rig, |rig, (name, value)| rig.set(name, *value)).start().unwrap()
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
    let mut run = free(&[("friction.stribeck.FsInf", 16.0)]);
    run.ramp("appliedForce", 0.0, 100.0);
    run.advance(0.16 - 1e-9).unwrap();
    assert_eq!((run.get("sticking"), run.get("position")), (1.0, 0.0));
    run.ramp("appliedForce", 16.0 - 1e-7, 100.0);
    run.advance(0.16 + 1e-6).unwrap();
    assert!(run.get("sticking") == 0.0 && run.get("velocity") > 0.0);
}

/// `F_s(t) = 11 + 5*t/(t + 0.5)`. The rest begins within 10 us of where the steps see it, in which it grows by 0.1 mN.
#[test]
fn later_break_away_grows_with_the_time_at_rest() {
    for rest in [0.01, 0.5, 1.0, 20.0] {
        let mut run = free(&[("friction.stribeck.FsInf", 16.0)]);
        assert!(!holds(&mut run, 20.0, 0.0));
        run.set("appliedForce", -3.0);
        let mut time = 1e-6;
        while run.get("sticking") == 0.0 {
            time += 1e-5;
            run.advance(time).unwrap();
        }
        run.set("appliedForce", 0.0);
        time += rest;
        run.advance(time).unwrap();
        let expected = 11.0 + 5.0 * rest / (rest + 0.5);
        assert!(holds(&mut run, expected - 1e-3, time), "{expected} N after {rest} s");
        assert!(!holds(&mut run, expected + 1e-3, time + 2e-6), "{expected} N after {rest} s");
        // After a slip the mass slides at once as if it had never rested.
        let speed = run.get("velocity");
        close(
            run.get("frictionForce"),
            8.3 + 2.7 * (-(speed / 0.01).powi(2)).exp() + 30.0 * speed,
            1e-13,
            "later break away grows with the time at rest",
        );
    }
}

/// Half as much load again: half as much Coulomb friction again, and of static friction as the ratio says, but no less
/// than the former.
#[test]
fn static_friction_grows_with_the_load_at_its_own_pace() {
    for (ratio, expected) in [(0.0, 1.5 * 8.3), (0.5, 13.75), (1.0, 16.5), (2.0, 22.0)] {
        let mut run = free(&[("friction.stribeck.kappaRatio", ratio), ("friction.level", 1.5)]);
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
    let mut run = free(&[("friction.stribeck.FsInf", 16.0)]);
    assert!(!holds(&mut run, 20.0, 0.0));
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
