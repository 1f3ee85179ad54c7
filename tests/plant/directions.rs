//! Differences by direction: friction outwards and inwards, by the chamber that drives, and which chamber is open.

use std::f64::consts::TAU;

use crate::bounds::{close, within};
use crate::rig::Rig;
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const FACTOR: f64 = 1.5;
const AMBIENT: f64 = 101_325.0;
/// Load factors that differ by direction: by a factor, and by the chambers that drive and resist, in 1/Pa.
const DIFFERENCES: [&[(&str, f64)]; 6] = [
    &[("friction.direction.factor", 0.5)],
    &[("friction.direction.factor", 1.7)],
    &[("friction.kappaDriving", 2e-6)],
    &[("friction.kappaResisting", 3e-6)],
    &[("friction.kappaDriving", 4e-6), ("friction.kappaResisting", -1e-6)],
    &[("friction.kappaDriving", -1.5e-6), ("friction.kappaResisting", 2e-6), ("friction.direction.factor", 1.3)],
];

fn with(rig: Rig, changes: &[(&str, f64)]) -> Rig {
    changes.iter().fold(rig, |rig, (name, value)| rig.set(name, *value))
}

/// Static friction of 11 N inwards is 16.5 N outwards; without air under pressure nothing else holds the carriage.
#[test]
fn break_away_differs_by_direction() {
    for law in ["CoulombStiction", "Stribeck", "Karnopp"] {
        for (limit, sign) in [(11.0 * FACTOR, 1.0), (11.0, -1.0)] {
            for (share, moves) in [(0.999, false), (1.001, true)] {
                let rig = Rig::cylinder(law).set("friction.direction.factor", FACTOR);
                let mut running = rig.set("externalForce", sign * share * limit).start().unwrap();
                running.advance(0.05).unwrap();
                assert_eq!(running.get("sticking") == 0.0, moves, "{law} under {share} of {limit} N, {sign}");
            }
        }
    }
}

/// While sliding, friction without its viscous part is the law's force, outwards times the factor; bristles have settled, and the
/// Stribeck effect is over.
#[test]
fn sliding_friction_differs_by_direction() {
    for law in ["Coulomb", "Stribeck", "LuGre", "ElastoPlastic"] {
        for (level, velocity) in [(FACTOR, 0.5), (1.0, -0.5)] {
            let rig = Rig::cylinder(law).set("friction.direction.factor", FACTOR).set("velocity0", velocity);
            let mut running = rig.start().unwrap();
            running.advance(5e-3).unwrap();
            let now = running.get("velocity");
            assert!(now * velocity > 0.1, "{law} moves on");
            let expected = level * 8.3f64.copysign(now) + 30.0 * now;
            close(running.get("frictionForce"), expected, 1e-6, format_args!("{law} at {now} m/s"));
            assert_eq!(running.get("friction.level"), level, "{law} at {now} m/s");
        }
    }
}

/// Damping beside the law acts outwards alone, or inwards alone.
#[test]
fn viscous_friction_differs_by_direction() {
    for (law, dry) in [("Coulomb", 8.3), ("Stribeck", 8.3), ("LuGre", 8.3), ("Dahl", 10.6)] {
        for (damping, velocity, by_law) in [(20.0, 0.5, 1.0), (20.0, -0.5, 0.0), (-20.0, 0.5, 0.0), (-20.0, -0.5, 1.0)]
        {
            let rig = Rig::cylinder(law).set("friction.direction.damping", damping).set("velocity0", velocity);
            let mut running = rig.start().unwrap();
            running.advance(5e-3).unwrap();
            let now = running.get("velocity");
            assert!(now * velocity > 0.1, "{law} moves on");
            let viscous = if law == "Dahl" { 0.0 } else { 30.0 };
            let expected = f64::copysign(dry, now) + (viscous + by_law * 20.0) * now;
            close(running.get("frictionForce"), expected, 1e-6, format_args!("{law} at {now} m/s, {damping}"));
        }
    }
}

/// A force between friction inwards and friction outwards slows a carriage down that moves outwards, and is too weak to start it
/// again: with a force difference `D` it comes to rest after `m/s2*ln(1 + s2*v0/D)` at `x0 + m/s2*(v0 - D/s2*ln(1 + s2*v0/D))`.
#[test]
fn carriage_that_comes_to_rest_is_held_by_the_friction_of_the_side_it_is_pushed_to() {
    const MASS_BY_DAMPING: f64 = 0.88 / 30.0;
    for (law, velocity, push) in [("Coulomb", 0.2, 10.0), ("Karnopp", 0.2, 10.0), ("Coulomb", -0.2, -5.0)] {
        let rig = Rig::cylinder(law).set("friction.direction.factor", FACTOR).set("velocity0", velocity);
        let rig = rig.set("chamberA.open", 1.0).set("chamberB.open", 1.0).set("externalForce", push);
        let rig = rig.set("friction.karnopp.Fs", 8.3).set("friction.karnopp.DV", 1e-9);
        let mut running = rig.set("cylinder.rodA", 0.006).set("solver.relativeTolerance", 1e-9).start().unwrap();
        let level = if velocity > 0.0 { FACTOR } else { 1.0 };
        let by_damping = (level * 8.3 - f64::abs(push)) / 30.0;
        let share = (f64::abs(velocity) / by_damping).ln_1p();
        let expected = 0.25 + velocity.signum() * MASS_BY_DAMPING * (f64::abs(velocity) - by_damping * share);
        running.advance(MASS_BY_DAMPING * share - 1e-4).unwrap();
        assert_eq!(running.get("sticking"), 0.0, "{law}");
        for time in [MASS_BY_DAMPING * share + 1e-4, 0.5] {
            running.advance(time).unwrap();
            close(running.get("position"), expected, 1e-8, format_args!("m under {law} and {push} N"));
            assert_eq!(running.get("sticking"), 1.0, "{law} under {push} N");
        }
        assert!(running.get("solver.events") < 5.0, "{law}: {} events", running.get("solver.events"));
    }
}

/// With two equal rods a cylinder with an open chamber A is the mirror image of one with an open chamber B.
#[test]
fn pulling_cylinder_is_the_mirror_image_of_a_pushing_one() {
    let cylinder = |open: &str, position: f64, rest: f64| {
        let rig = Rig::cylinder("LuGre").set(open, 1.0).set("cylinder.rodA", 0.006).set("position0", position);
        let rig = rig.set("load.stiffness", 80.0).set("load.rest", rest).set("piston.leakage", 1e-16);
        rig.set("solver.relativeTolerance", 1e-9).set("balance.enabled", 1.0).start().unwrap()
    };
    let (mut pushing, mut pulling) = (cylinder("chamberB.open", 0.1, 0.05), cylinder("chamberA.open", 0.4, 0.45));
    let mut travelled = 0.0f64;
    for step in 0..1500 {
        let time = f64::from(step) * 1e-3;
        let voltage = 2.5 * (TAU * time).sin();
        pushing.set("valveVoltage", 5.0 + voltage);
        pulling.set("valveVoltage", 5.0 - voltage);
        for running in [&mut pushing, &mut pulling] {
            running.advance(time + 1e-3).unwrap();
        }
        let position = pushing.get("position");
        travelled = travelled.max(position - 0.1);
        close(pulling.get("position"), 0.5 - position, 1e-8, format_args!("m at {time} s"));
        close(pulling.get("chamberB.pressure"), pushing.get("chamberA.pressure"), 1e-2, format_args!("Pa at {time} s"));
        close(pulling.get("chamberA.massFlow"), pushing.get("chamberB.massFlow"), 1e-9, "kg/s");
        assert_eq!(pulling.get("chamberA.pressure"), 101_325.0, "open");
        within(pulling.get("balance.massResidual").abs(), 1e-10, "kg");
    }
    assert!(travelled > 0.05, "{travelled} m");
}

/// A carriage with friction alone.
#[test]
fn cylinder_that_is_open_on_both_sides_pushes_nothing() {
    let rig = Rig::cylinder("Coulomb").set("chamberA.open", 1.0).set("chamberB.open", 1.0).set("valveVoltage", 10.0);
    let mut running = rig.set("consumption.enabled", 1.0).set("velocity0", 0.3).start().unwrap();
    running.advance(0.2).unwrap();
    assert_eq!(["velocity", "supply.consumed"].map(|name| running.get(name)), [0.0; 2]);
    within(running.get("pressureForce").abs(), 1e-12, "N");
    assert!(running.get("position") > 0.25);
}

/// Laws that may differ by direction.
fn laws() -> impl Iterator<Item = &'static str> {
    let takes = |law: &&str| Rig::cylinder(law).set("friction.direction.factor", FACTOR).start().is_ok();
    LAWS.items.iter().map(|(_, law, _)| *law).filter(takes)
}

/// Laws whose springs would give back more than they took are refused by name, with others to take instead.
#[test]
fn laws_with_springs_of_limited_force_refuse_a_factor() {
    let accepted: Vec<&str> = laws().collect();
    let takes =
        ["Coulomb", "CoulombStiction", "Stribeck", "Karnopp", "Polito", "Table", "Dahl", "LuGre", "ElastoPlastic"];
    assert!(takes.iter().all(|law| accepted.contains(law)), "{accepted:?}");
    for law in [
        "Leuven",
        "GMS",
        "MaxwellSlip",
        "StickSlipSpring",
        "StickSlipCreep",
        "Armstrong",
        "ResetIntegrator",
        "BlimanSorine",
    ] {
        let error =
            Rig::cylinder(law).set("friction.direction.factor", 1.3).start().err().unwrap_or_else(|| panic!("{law}"));
        assert_eq!((error.variable.as_str(), error.value), ("friction.direction.factor", 1.3));
        assert!(error.reason.contains("Stribeck") && error.reason.contains("LuGre"), "{error}");
        let rig = Rig::cylinder(law).set("friction.kappaResisting", 1e-6);
        let error = rig.start().err().unwrap_or_else(|| panic!("{law}"));
        assert_eq!((error.variable.as_str(), error.value), ("friction.kappaResisting", 1e-6));
    }
}

/// Under a sine about the closed valve no run ends early, whichever difference: the mode that slides has one force on both sides of the
/// velocity at which it ends.
#[test]
fn no_run_ends_at_a_reversal() {
    for law in laws() {
        for difference in DIFFERENCES {
            with(Rig::cylinder(law), difference).run_through_reversals(&(law, difference));
        }
    }
}

/// `lambda = 1 + kD*(p_driving - p0) + kR*(p_resisting - p0)`: chamber A drives outwards, chamber B inwards, in every law that may
/// differ by direction.
#[test]
fn load_factor_follows_the_roles_of_the_chambers() {
    let [driving, resisting] = [2e-6, 5e-6];
    for law in laws() {
        let rig = Rig::cylinder(law).set("friction.kappaDriving", driving).set("friction.kappaResisting", resisting);
        let mut running = rig.start().unwrap();
        let mut seen = [0; 2];
        for step in 0..1000 {
            let time = f64::from(step) * 1e-3;
            running.set("valveVoltage", 5.0 + 3.0 * (TAU * 2.0 * time).sin());
            running.advance(time + 1e-3).unwrap();
            let excess = ["chamberA.pressure", "chamberB.pressure"].map(|name| running.get(name) - AMBIENT);
            let velocity = running.get("velocity");
            if velocity.abs() < 1e-3 {
                continue;
            }
            let [of_driving, of_resisting] = if velocity > 0.0 { excess } else { [excess[1], excess[0]] };
            let expected = 1.0 + driving * of_driving + resisting * of_resisting;
            close(running.get("friction.level"), expected, 1e-12, format_args!("{law} at {time} s"));
            seen[usize::from(velocity > 0.0)] += 1;
        }
        assert!(seen.iter().all(|count| *count > 50), "{law}: {seen:?}");
    }
}

/// Two chambers under different pressures, and an external force that leaves a share of the break-away force: it is
/// `Fs*(1 + kD*(p_driving - p0))` of the chamber on whose side the push begins.
#[test]
fn break_away_is_that_of_the_chamber_that_drives() {
    for law in ["CoulombStiction", "Stribeck", "Karnopp"] {
        for (sign, driving) in [(1.0, 3e5), (-1.0, 2e5)] {
            for (share, moves) in [(0.99, false), (1.01, true)] {
                let rig = Rig::cylinder(law).set("friction.kappaDriving", 5e-6);
                let rig = rig.set("chamberA.pressure0", 3e5).set("chamberB.pressure0", 2e5).set("valve.leakage", 0.0);
                let limit = 11.0 * (1.0 + 5e-6 * (driving - AMBIENT));
                let of_pressures = rig.start().unwrap().get("pressureForce");
                let mut running = rig.set("externalForce", sign * share * limit - of_pressures).start().unwrap();
                running.advance(0.02).unwrap();
                let label = format!("{law} under {share} of {limit} N, {sign}");
                assert_eq!(running.get("sticking") == 0.0, moves, "{label}");
            }
        }
    }
}

/// Where both roles weigh alike, nobody can tell which chamber has which: as with `kappaA` and `kappaB`.
#[test]
fn equal_roles_are_the_load_by_both_chambers() {
    for law in laws() {
        let run = |names: [&str; 2]| {
            let rig = Rig::cylinder(law).set(names[0], 2e-6).set(names[1], 2e-6);
            let mut running = rig.set("solver.relativeTolerance", 1e-10).start().unwrap();
            let positions = (0..300).map(|step| {
                let time = f64::from(step) * 1e-3;
                running.set("valveVoltage", 5.0 + 2.0 * (TAU * 3.0 * time).sin());
                running.advance(time + 1e-3).unwrap();
                running.get("position")
            });
            positions.collect::<Vec<f64>>()
        };
        let roles = run(["friction.kappaDriving", "friction.kappaResisting"]);
        for (step, (one, other)) in roles.into_iter().zip(run(["friction.kappaA", "friction.kappaB"])).enumerate() {
            within((one - other).abs(), 1e-8, format_args!("m, {law} at step {step}"));
        }
    }
}

/// Below break-away a law that holds the carriage at the factor 1 holds it at others, to 1 um/s.
#[test]
fn carriage_below_break_away_rests_in_both_directions() {
    let speed = |law: &str, factor: f64, force: f64| {
        let rig = Rig::cylinder(law).set("chamberA.open", 1.0).set("chamberB.open", 1.0).set("cylinder.rodA", 0.006);
        let rig = rig.set("friction.direction.factor", factor).set("externalForce", force);
        let mut running = rig.start().unwrap();
        running.advance(0.5).unwrap();
        let before = running.get("position");
        running.advance(1.0).unwrap();
        (running.get("position") - before).abs() / 0.5
    };
    for law in laws() {
        // Regularised laws creep under any force.
        if speed(law, 1.0, 7.0) > 1e-6 {
            continue;
        }
        for factor in [0.5, 0.8, 1.2, 1.7] {
            for force in [7.0 * factor, -7.0] {
                let found = speed(law, factor, force);
                assert!(found <= 1e-6, "{law}: {found} m/s under {force} N at the factor {factor}");
            }
        }
    }
}

/// A closed path takes energy, however small, in whichever place of the force-deflection plane.
#[test]
fn closed_paths_give_no_work() {
    for law in laws() {
        // In its band of velocities Karnopp's friction is the force that acts, also where that is along the motion.
        let pressure = if law == "Karnopp" { AMBIENT } else { 3e5 };
        for difference in DIFFERENCES {
            for amplitude in [2e-6, 2e-5, 1e-3] {
                let rig = Rig::cylinder(law).choose("motion", "Imposed").set("chamberA.pressure0", pressure);
                let work = with(rig, difference).start().unwrap().work_of_closed_paths(amplitude);
                // The first path begins with springs that hold nothing. A reversal within a step is counted half.
                let rounding = 1e-3 * 20.0 * amplitude;
                assert!(
                    work.iter().all(|work| *work > -rounding),
                    "{law}: {work:?} J of {amplitude} m with {difference:?}"
                );
            }
        }
    }
}

/// Derivatives by the factor, and by the load of the driving chamber, through reversals, sliding and rest.
#[test]
fn derivatives_by_a_difference_are_those_of_differences() {
    let voltage = |k: u32| 5.0 + 2.0 * (TAU * f64::from(k) * 1e-3).sin();
    let plant = |law: &str, name: &str, value: f64| {
        let setup = Setup::new(&MODEL).set("friction.law", law).expect("a law");
        let setup = setup.set("solver.relativeTolerance", 1e-10).expect("legal");
        setup.set(name, value).expect("legal").start(0.0).expect("starts")
    };
    let laws = ["CoulombStiction", "Stribeck", "Table", "LuGre", "Dahl"];
    let differences = [("friction.direction.factor", 1.3, 1e-5), ("friction.kappaDriving", 2e-6, 1e-11)];
    for (law, (name, value, share)) in laws.iter().flat_map(|law| differences.map(|difference| (law, difference))) {
        let positions = |value: f64| {
            let mut plant = plant(law, name, value);
            let step = |k: u32| {
                plant.set("valveVoltage", voltage(k)).expect("legal");
                plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
                plant.get("position").expect("a variable")
            };
            (0..700).map(step).collect::<Vec<f64>>()
        };
        let pairs: Vec<_> = positions(value + share).into_iter().zip(positions(value - share)).collect();
        let mut plant = plant(law, name, value);
        plant.carry_sensitivities(&[name]).expect("a direction");
        let place = plant.table().computed().position(|variable| variable.name == "position").expect("computed");
        let largest = pairs.iter().fold(0.0f64, |most, (above, below)| most.max((above - below).abs() / (2.0 * share)));
        assert!(largest * value > 1e-3, "{law}: {largest} m by {name}");
        for (k, (above, below)) in (0..).zip(pairs) {
            plant.set("valveVoltage", voltage(k)).expect("legal");
            plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
            let slope = plant.sensitivities(0).expect("a derivative")[place];
            let difference = (above - below) / (2.0 * share);
            within(
                (slope - difference).abs(),
                1e-3 * largest,
                format_args!("{law} by {name} at step {k}: {slope}, {difference}"),
            );
        }
    }
}
