//! Every friction law survives inputs that no machine would see, and what is hardly meant is noticed.

use crate::rig::Rig;
use pneumatic_servo::conformance::Random;
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const FINITE: [&str; 7] =
    ["position", "velocity", "acceleration", "frictionForce", "chamberA.massFlow", "chamberB.massFlow", "valve.spool"];
const POSITIVE: [&str; 4] = ["chamberA.pressure", "chamberB.pressure", "chamberA.temperature", "chamberB.temperature"];

/// Plays random inputs held for 0.1 to 50 ms each for a time; returns the number of accepted steps.
fn survive(rig: &Rig, law: &str, seed: u64, end: f64) -> f64 {
    let mut run = rig.clone().set("solver.maxStepsPerCommunicationStep", 100_000.0).start().unwrap();
    let mut random = Random(seed);
    let mut time = 0.0;
    while time < end {
        run.set("valveVoltage", random.between(0.0, 10.0));
        run.set("externalForce", random.between(-500.0, 500.0));
        run.set("supplyPressure", random.between(1e5, 10e5));
        time += 1e-4 * 500f64.powf(random.between(0.0, 1.0));
        run.advance(time).unwrap_or_else(|error| panic!("{law} with seed {seed}: {error}"));
        for name in FINITE.into_iter().chain(POSITIVE) {
            let value = run.get(name);
            assert!(value.is_finite(), "{law} with seed {seed}: {name} = {value} at {time} s");
            assert!(value > 0.0 || !POSITIVE.contains(&name), "{law} with seed {seed}: {name} = {value} at {time} s");
        }
    }
    run.get("solver.steps")
}

#[test]
fn thirty_seconds_of_hostile_input_are_survived_by_every_law() {
    for (index, (_, law, _)) in LAWS.items.iter().enumerate() {
        let begin = std::time::Instant::now();
        let steps = survive(&Rig::cylinder(law), law, index as u64, 30.0);
        println!("{law:22} {steps:8} steps {:6.2} s", begin.elapsed().as_secs_f64());
        // Ten in a millisecond, three times what most laws take. Breaking bonds are met one by one.
        let most = if *law == "Bristle" { 1e6 } else { 3e5 };
        assert!(steps <= most, "{law}: {steps} steps in 30 s");
    }
}

/// The friction levels grow with one pressure and fall with the other, at times to nothing.
#[test]
fn friction_levels_that_vanish_and_return_are_survived_by_every_law() {
    for (index, (_, law, _)) in LAWS.items.iter().enumerate() {
        let rig = Rig::cylinder(law).set("friction.kappaA", 2e-6).set("friction.kappaB", -6e-6);
        survive(&rig, law, 100 + index as u64, 5.0);
    }
}

/// Velocities from 1 um/s to 1 m/s, held or as ramps through zero, and forces around break-away.
#[test]
fn hostile_input_of_the_bench_is_survived_by_every_law() {
    for (index, (_, law, _)) in LAWS.items.iter().enumerate() {
        for drive in ["SpringPull", "PrescribedMotion", "Free"] {
            let mut run = Rig::bench(law, drive)
                .set("spring.stiffness", 1e4)
                .set("solver.maxStepsPerCommunicationStep", 100_000.0)
                .start()
                .unwrap();
            let mut random = Random(index as u64);
            let mut time = 0.0;
            while time < 5.0 {
                let step = 1e-4 * 500f64.powf(random.between(0.0, 1.0));
                let v = 1e-6 * 1e6f64.powf(random.between(0.0, 1.0)) * random.between(-1.0, 1.0).signum();
                let end = [v, -v, 0.0][random.between(0.0, 3.0) as usize];
                run.set("appliedForce", random.between(-30.0, 30.0));
                run.ramp("driveVelocity", v, (end - v) / step);
                time += step;
                run.advance(time).unwrap_or_else(|error| panic!("{law} {drive}: {error}"));
                for name in ["position", "velocity", "frictionForce", "springForce"] {
                    assert!(run.get(name).is_finite(), "{law} {drive}: {name} at {time} s");
                }
            }
        }
    }
}

/// Numbers too small to be normal are as good as zero: they take no other course and hardly more work.
#[test]
fn denormal_inputs_are_harmless() {
    const TINY: f64 = 1e-310;
    for (_, law, _) in LAWS.items {
        let run = |tiny: f64| {
            let mut run = Rig::cylinder(law).set("velocity0", tiny).set("externalForce", tiny).start().unwrap();
            run.set("valveVoltage", 5.0 + tiny);
            run.advance(0.2).unwrap_or_else(|error| panic!("{law}: {error}"));
            ["position", "chamberA.pressure", "solver.steps", "solver.rejectedSteps"].map(|name| run.get(name))
        };
        let ([x, p, steps, rejected], [tiny_x, tiny_p, tiny_steps, tiny_rejected]) = (run(0.0), run(TINY));
        // The direction in which the mass is said to start may differ, and with it the steps.
        assert!((x - tiny_x).abs() < 1e-6 && (p - tiny_p).abs() < 1.0, "{law}: {x}, {p}; {tiny_x}, {tiny_p}");
        let (work, tiny_work) = (steps + rejected, tiny_steps + tiny_rejected);
        assert!(tiny_work <= 1.5 * work + 20.0, "{law}: {tiny_work} steps instead of {work}");
    }
}

/// 0 is what some hosts give an input that is not connected, 5 a pressure in bar.
#[test]
fn supply_below_ambient_neither_empties_a_chamber_nor_moves_the_carriage() {
    for supply in [0.0, 5.0] {
        for law in ["None", "Stribeck", "LuGre"] {
            let setup = Setup::new(&MODEL).set("friction.law", law).unwrap().set("supplyPressure", supply).unwrap();
            let mut plant = setup.start(0.0).unwrap();
            for (end, voltage) in [(0.5, 9.0), (1.0, 1.0)] {
                plant.set("valveVoltage", voltage).unwrap();
                plant.advance_to(end).unwrap();
                for chamber in ["chamberA.pressure", "chamberB.pressure"] {
                    assert_eq!(plant.get(chamber), Ok(101_325.0), "{law}: {supply} Pa, {voltage} V");
                }
                assert_eq!(plant.get("position"), Ok(0.25), "{law}: {supply} Pa, {voltage} V");
            }
        }
    }
}

#[test]
fn supply_below_ambient_is_noticed_where_a_valve_has_it() {
    let noticed = |actuation: &str, supply: f64| {
        let setup = Setup::new(&MODEL).set("actuation", actuation).unwrap().set("supplyPressure", supply).unwrap();
        setup.start(0.0).unwrap().notices().map(|notice| notice.to_string()).collect::<Vec<_>>()
    };
    let [notice] = &noticed("ProportionalValve", 5.0)[..] else { panic!("one notice") };
    assert!(notice.starts_with("supplyPressure = 5: it acts as ambientPressure"), "{notice}");
    assert!(noticed("ProportionalValve", 101_325.0).is_empty());
    assert_eq!(noticed("PressureRegulator", 5.0), noticed("ProportionalValve", 5.0));
}

/// In every system.
#[test]
fn shares_that_do_not_add_up_to_1_are_noticed_under_their_law() {
    for model in models::ALL.iter().filter(|model| Setup::new(model).table().find("friction.law").is_some()) {
        let noticed = |law: &str, share: f64| {
            let setup =
                Setup::new(model).set("friction.law", law).unwrap().set("friction.gms.alpha[1]", share).unwrap();
            setup.start(0.0).unwrap().notices().map(|notice| notice.to_string()).collect::<Vec<_>>()
        };
        let [notice] = &noticed("GMS", 0.5)[..] else { panic!("{}: one notice", model.name) };
        assert!(notice.starts_with("sum of friction.gms.alpha = 1.25: "), "{}: {notice}", model.name);
        assert!(noticed("GMS", 0.25).is_empty());
        assert!(noticed("GMS", 0.25 + 1e-8).is_empty(), "rounded");
        assert!(noticed("LuGre", 0.5).is_empty());
    }
}
