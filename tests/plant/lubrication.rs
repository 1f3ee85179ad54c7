//! Stribeck velocity and viscous friction that follow the pressures of the chamber that drives and of the one that resists.

use std::f64::consts::TAU;

use crate::bounds::{close, within};
use crate::rig::{Rig, Running};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const AMBIENT: f64 = 101_325.0;
const STRIBECK: [&str; 2] = ["friction.stribeckVelocity.kappaDriving", "friction.stribeckVelocity.kappaResisting"];
const VISCOUS: [&str; 2] = ["friction.viscous.kappaDriving", "friction.viscous.kappaResisting"];
/// Increases in 1/Pa of the Stribeck velocity by the driving and by the resisting pressure, and of the viscous friction.
const INCREASES: [[[f64; 2]; 2]; 3] =
    [[[8e-6, -1e-6], [3e-6, 1e-6]], [[0.0, 5e-6], [0.0; 2]], [[0.0; 2], [-1.5e-6, 4e-6]]];

fn with(rig: Rig, increases: [[f64; 2]; 2]) -> Rig {
    let names = [STRIBECK, VISCOUS].into_iter().flatten();
    names.zip(increases.into_iter().flatten()).fold(rig, |rig, (name, value)| rig.set(name, value))
}

/// The laws that follow.
fn laws() -> impl Iterator<Item = &'static str> {
    let takes = |law: &&str| with(Rig::cylinder(law), INCREASES[0]).start().is_ok();
    LAWS.items.iter().map(|(_, law, _)| *law).filter(takes)
}

/// Factors on the Stribeck velocity and on the viscous friction at the pressures of a run, in a direction of motion.
fn factors(running: &mut Running, direction: f64, increases: [[f64; 2]; 2]) -> [f64; 2] {
    let [a, b] = ["chamberA.pressure", "chamberB.pressure"].map(|name| running.get(name) - AMBIENT);
    let [driving, resisting] = if direction > 0.0 { [a, b] } else { [b, a] };
    increases.map(|[by_driving, by_resisting]| 1.0 + by_driving * driving + by_resisting * resisting)
}

/// `F = Fc + (Fs - Fc)*exp(-(v/(q*vs))^2) + r*sigma2*v` at a constant speed, at two pressures in each role: bristles have settled, and
/// the film of RevisedLuGre leaves `(1 - h)*Fs` of the static friction, `h = (1 - Fc/Fs)*(v/vb)^(2/3)`.
#[test]
fn steady_friction_follows_the_pressures_of_both_roles() {
    let ([statics, coulomb, viscous], speed) = ([11.0, 8.3, 30.0], 6e-3);
    for law in laws() {
        let film =
            if law == "RevisedLuGre" { (1.0 - coulomb / statics) * f64::cbrt((speed / 0.05f64).powi(2)) } else { 0.0 };
        let settled = if law == "RevisedLuGre" { 4.0 } else { 0.1 };
        // Bristles follow the pressures, which change by 3 % per second, in milliseconds, and a film in seconds.
        let bound = if law == "Stribeck" { 1e-12 } else { 1e-4 };
        for increases in INCREASES {
            for (direction, pressures) in [(1.0, [2e5, 5e5]), (1.0, [5e5, 2e5]), (-1.0, [2e5, 5e5]), (-1.0, [5e5, 2e5])]
            {
                let rig = with(Rig::cylinder(law), increases).choose("motion", "Imposed").set("valve.leakage", 0.0);
                let rig = rig.set("chamberA.pressure0", pressures[0]).set("chamberB.pressure0", pressures[1]);
                let rig = rig.set("imposedPosition", 0.25).set("imposedVelocity", direction * speed);
                let mut running = rig.start().unwrap();
                running.advance(settled).unwrap();
                let [stribeck, of_viscous] = factors(&mut running, direction, increases);
                let excess = (1.0 - film) * statics - coulomb;
                let dry = coulomb + excess * (-(speed / (stribeck * 0.01)).powi(2)).exp();
                let expected = direction * (dry + of_viscous * viscous * speed);
                let label = format!("{law}, {increases:?}, {direction}, {pressures:?}");
                close(running.get("frictionForce"), expected, bound, label);
                assert_eq!(running.get("friction.level"), 1.0);
            }
        }
    }
}

/// The force at rest is the law's, and so is the break-away force.
#[test]
fn break_away_does_not_follow() {
    for (share, moves) in [(0.999, false), (1.001, true)] {
        let rig =
            with(Rig::cylinder("Stribeck"), INCREASES[0]).set("chamberA.pressure0", 3e5).set("valve.leakage", 0.0);
        let of_pressures = rig.start().unwrap().get("pressureForce");
        let mut running = rig.set("externalForce", share * 11.0 - of_pressures).start().unwrap();
        running.advance(0.02).unwrap();
        assert_eq!(running.get("sticking") == 0.0, moves, "{share} of the static friction");
    }
}

/// Laws without both, and those whose modes depend on them, refuse by the name of the parameter, with laws to take instead.
#[test]
fn other_laws_refuse() {
    let takes: Vec<&str> = laws().collect();
    assert_eq!(takes, ["Stribeck", "LuGre", "ElastoPlastic", "RevisedLuGre"]);
    for (_, law, _) in LAWS.items.iter().filter(|(_, law, _)| !takes.contains(law)) {
        for name in [STRIBECK, VISCOUS].into_iter().flatten() {
            let error = Rig::cylinder(law).set(name, 1e-6).start().err().unwrap_or_else(|| panic!("{law}"));
            assert_eq!((error.variable.as_str(), error.value), (name, 1e-6));
            assert!(takes.iter().all(|law| error.reason.contains(law)), "{error}");
        }
    }
}

/// A factor may fall as far as it stays above 0: where the pressures would take it there, the run ends and says by which parameter.
#[test]
fn factors_that_fall_to_0_end_a_run_by_name() {
    for name in [STRIBECK, VISCOUS].into_iter().flatten() {
        // 4 bar above ambient take all of it.
        let rig = Rig::cylinder("Stribeck").set(name, -2.5e-6).set("chamberB.pressure0", 3e5).set("valveVoltage", 10.0);
        let mut running = rig.set("supplyPressure", 8e5).start().unwrap();
        let ended = (1..500).find_map(|step| running.advance(f64::from(step) * 1e-3).err()).expect("an end");
        let group = name.rsplit_once('.').expect("a group").0;
        assert!(ended.to_string().contains(group), "{ended}");
        let highest = running.get("chamberA.pressure").max(running.get("chamberB.pressure"));
        assert!(highest < AMBIENT + 4e5 && highest > AMBIENT + 3.5e5, "{highest} Pa");
    }
}

/// Under a sine about the closed valve no run ends early.
#[test]
fn no_run_ends_at_a_reversal() {
    for law in laws() {
        for increases in INCREASES {
            with(Rig::cylinder(law), increases).run_through_reversals(&(law, increases));
        }
    }
}

/// A closed path takes energy, however small.
#[test]
fn closed_paths_give_no_work() {
    for law in laws() {
        for increases in INCREASES {
            for amplitude in [2e-6, 2e-5, 1e-3] {
                let rig = Rig::cylinder(law).choose("motion", "Imposed").set("chamberA.pressure0", 3e5);
                let work = with(rig, increases).start().unwrap().work_of_closed_paths(amplitude);
                // A reversal within a step is counted half.
                let rounding = 1e-3 * 20.0 * amplitude;
                assert!(work.iter().all(|work| *work > -rounding), "{law}: {work:?} J of {amplitude} m, {increases:?}");
            }
        }
    }
}

/// Derivatives by each increase, from 0 and from elsewhere, through reversals and rest.
#[test]
fn derivatives_by_an_increase_are_those_of_differences() {
    let voltage = |k: u32| 5.0 + 2.0 * (TAU * f64::from(k) * 1e-3).sin();
    let plant = |law: &str, name: &str, value: f64| {
        let setup = Setup::new(&MODEL).set("friction.law", law).expect("a law");
        let setup = setup.set("solver.relativeTolerance", 1e-10).expect("legal");
        setup.set(name, value).expect("legal").start(0.0).expect("starts")
    };
    let names = [(STRIBECK[0], 0.0), (STRIBECK[1], 3e-6), (VISCOUS[0], 2e-6), (VISCOUS[1], 0.0)];
    for (law, (name, value)) in laws().flat_map(|law| names.map(|name| (law, name))) {
        let positions = |value: f64| {
            let mut plant = plant(law, name, value);
            let step = |k: u32| {
                plant.set("valveVoltage", voltage(k)).expect("legal");
                plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
                plant.get("position").expect("a variable")
            };
            (0..700).map(step).collect::<Vec<f64>>()
        };
        let share = 1e-9;
        let pairs: Vec<_> = positions(value + share).into_iter().zip(positions(value - share)).collect();
        let mut plant = plant(law, name, value);
        plant.carry_sensitivities(&[name]).expect("a direction");
        let place = plant.table().computed().position(|variable| variable.name == "position").expect("computed");
        let largest = pairs.iter().fold(0.0f64, |most, (above, below)| most.max((above - below).abs() / (2.0 * share)));
        assert!(largest > 1.0, "{law}: {largest} m.Pa by {name}");
        for (k, (above, below)) in (0..).zip(pairs) {
            plant.set("valveVoltage", voltage(k)).expect("legal");
            plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
            let slope = plant.sensitivities(0).expect("a derivative")[place];
            let difference = (above - below) / (2.0 * share);
            let label = format!("{law} by {name} at step {k}: {slope}, {difference}");
            within((slope - difference).abs(), 2e-3 * largest, label);
        }
    }
}
