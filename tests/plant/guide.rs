//! A guide that is pressed on by the load that it moves: friction that depends on the acceleration, in closed form.

use std::f64::consts::TAU;

use crate::bounds::{close, within};
use crate::rig::Rig;
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const COEFFICIENT: &str = "friction.guide.coefficient";
const LEVER: &str = "friction.guide.lever";
const MASS: f64 = 0.88;
/// Laws that are stuck or slide, with 11 N of static friction but for Coulomb, 8.3 N of Coulomb friction and 30 N.s/m.
const LAWS_OF_GUIDES: [&str; 4] = ["Coulomb", "CoulombStiction", "Stribeck", "Table"];

fn guided(law: &str, ratio: f64) -> Rig {
    Rig::cylinder(law).set(COEFFICIENT, 0.1).set(LEVER, 10.0 * ratio)
}

/// `c*|T|` against the motion, with what the load takes, `T = m*a - X`, while the piston drives it and while it brakes it, and the load
/// cell between them reads both.
#[test]
fn guide_takes_its_share_of_what_the_load_takes() {
    for ratio in [0.1, 0.5, 0.9] {
        let rig = guided("Coulomb", ratio).set("mass.carriage", 0.5);
        let mut running = rig.start().unwrap();
        let mut seen = [[0; 2]; 2];
        for step in 0..1000 {
            let time = f64::from(step) * 1e-3;
            let load = 15.0 * (TAU * 7.0 * time).sin();
            running.set("valveVoltage", 5.0 + 3.0 * (TAU * 3.0 * time).sin());
            running.set("externalForce", load);
            running.advance(time + 1e-3).unwrap();
            let [velocity, acceleration] = ["velocity", "acceleration"].map(|name| running.get(name));
            let taken = MASS * acceleration - load;
            let of_guide = running.get("rodForce") - (0.5 * acceleration - load);
            if velocity == 0.0 {
                within(of_guide.abs(), ratio * load.abs() + 1e-12, format_args!("at rest at {time} s"));
                continue;
            }
            let of_seals = 8.3f64.copysign(velocity) + 30.0 * velocity;
            let label = format!("{ratio} at {time} s");
            close(running.get("frictionForce"), of_seals + of_guide, 1e-11, &label);
            close(of_guide, ratio * taken.abs() * velocity.signum(), 1e-11, &label);
            seen[usize::from(velocity > 0.0)][usize::from(taken * velocity > 0.0)] += 1;
        }
        assert!(seen.as_flattened().iter().all(|count| *count > 20), "{ratio}: {seen:?}");
    }
}

/// A load that is moved is felt as `1 + c` times its mass, one that is braked as `1 - c` times.
#[test]
fn mass_is_felt_more_while_driven_and_less_while_braked() {
    for (ratio, velocity) in [(0.3, 0.1), (0.3, -0.1), (0.8, 0.1)] {
        for pressure in [101_325.0, 7e5] {
            let rig = guided("Coulomb", ratio).set("velocity0", velocity).set("chamberA.pressure0", pressure);
            let mut running = rig.start().unwrap();
            let given = running.get("pressureForce") - (8.3f64.copysign(velocity) + 30.0 * velocity);
            let felt = if given * velocity > 0.0 { 1.0 + ratio } else { 1.0 - ratio };
            let label = format!("{ratio}, {velocity} m/s, {pressure} Pa");
            close(running.get("acceleration"), given / (MASS * felt), 1e-11, label);
        }
    }
}

/// Under 20 N of pressure a load that pushes back with `x` is moved below `(20 - Fs)/(1 + c)`, and moves the piston back beyond
/// `(20 + Fs)/(1 - c)`, the more beyond it the closer the guide is to locking itself.
#[test]
fn load_is_held_between_what_moves_it_and_what_it_moves() {
    let (area, force) = (std::f64::consts::PI / 4.0 * 0.016f64.powi(2), 20.0);
    for law in LAWS_OF_GUIDES {
        let statics = if law == "Coulomb" { 8.3 } else { 11.0 };
        for ratio in [0.2, 0.7, 0.98] {
            let [low, high] = [(force - statics) / (1.0 + ratio), (force + statics) / (1.0 - ratio)];
            for (load, way) in [(0.999 * low, 1.0), (1.001 * low, 0.0), (0.999 * high, 0.0), (1.001 * high, -1.0)] {
                let rig = guided(law, ratio).set("valve.leakage", 0.0).set("externalForce", -load);
                let rig = rig.set("chamberA.pressure0", 101_325.0 + force / area);
                let mut running = rig.start().unwrap();
                running.advance(2e-3).unwrap();
                let moved = running.get("position") - 0.25;
                let label = format!("{law}, {ratio}: {moved} m under {load} N, of {low} and {high}");
                assert_eq!(if moved == 0.0 { 0.0 } else { moved.signum() }, way, "{label}");
                assert_eq!(running.get("sticking") == 1.0, way == 0.0, "{label}");
            }
        }
    }
}

/// From `c = 1` on no acceleration is consistent with a load that brakes; just below, runs go on through reversals.
#[test]
fn guide_that_jams_is_refused_by_name() {
    for ratio in [1.0, 3.0] {
        let error = guided("Stribeck", ratio).start().err().expect("refused");
        assert_eq!((error.variable.as_str(), error.value), (COEFFICIENT, 0.1));
        assert!(error.reason.contains(LEVER) && error.reason.contains("jams"), "{error}");
    }
    for (_, law, _) in LAWS.items {
        let started = guided(law, 0.5).start();
        assert_eq!(started.is_ok(), LAWS_OF_GUIDES.contains(law), "{law}");
        if let Err(error) = started {
            assert_eq!(error.variable, COEFFICIENT);
            assert!(LAWS_OF_GUIDES.iter().all(|law| error.reason.contains(law)), "{error}");
        }
    }
    let led = guided("Stribeck", 0.5).choose("motion", "Imposed");
    assert_eq!(led.start().err().expect("refused").variable, COEFFICIENT);
    assert!(led.set("coupling.compliance", 1e-5).start().is_ok());
}

/// Friction never drives, the energy balance closes, and no run ends early.
#[test]
fn guide_takes_energy_alone() {
    for (law, ratio) in LAWS_OF_GUIDES.into_iter().flat_map(|law| [0.3, 0.99].map(|ratio| (law, ratio))) {
        let rig = guided(law, ratio).set("balance.enabled", 1.0).set("incline", 0.3).set("load.stiffness", 50.0);
        let mut running = rig.set("load.rest", 0.2).start().unwrap();
        for step in 0..600 {
            let time = f64::from(step) * 1e-3;
            running.set("valveVoltage", 5.0 + 2.5 * (TAU * 4.0 * time).sin());
            running.advance(time + 1e-3).unwrap_or_else(|error| panic!("{law}, {ratio}: {error}"));
            let power = running.get("frictionForce") * running.get("velocity");
            assert!(power >= 0.0, "{law}, {ratio}: {power} W at {time} s");
            let residual = running.get("balance.energyResidual").abs();
            within(residual, 5e-4, format_args!("J, {law}, {ratio} at {time} s"));
        }
    }
}

/// Through reversals, rest, and a load that is driven and braked.
#[test]
fn derivatives_by_the_guide_are_those_of_differences() {
    let voltage = |k: u32| 5.0 + 2.0 * (TAU * f64::from(k) * 1e-3).sin();
    let plant = |law: &str, value: f64| {
        let setup = Setup::new(&MODEL).set("friction.law", law).expect("a law").set(LEVER, 2.0).expect("legal");
        let setup = setup.set("solver.relativeTolerance", 1e-10).expect("legal");
        setup.set(COEFFICIENT, value).expect("legal").start(0.0).expect("starts")
    };
    for law in ["CoulombStiction", "Stribeck"] {
        let positions = |value: f64| {
            let mut plant = plant(law, value);
            let step = |k: u32| {
                plant.set("valveVoltage", voltage(k)).expect("legal");
                plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
                plant.get("position").expect("a variable")
            };
            (0..700).map(step).collect::<Vec<f64>>()
        };
        let (value, share) = (0.15, 1e-5);
        let pairs: Vec<_> = positions(value + share).into_iter().zip(positions(value - share)).collect();
        let mut plant = plant(law, value);
        plant.carry_sensitivities(&[COEFFICIENT]).expect("a direction");
        let place = plant.table().computed().position(|variable| variable.name == "position").expect("computed");
        let largest = pairs.iter().fold(0.0f64, |most, (above, below)| most.max((above - below).abs() / (2.0 * share)));
        assert!(largest > 1e-3, "{law}: {largest} m");
        for (k, (above, below)) in (0..).zip(pairs) {
            plant.set("valveVoltage", voltage(k)).expect("legal");
            plant.advance_to(f64::from(k + 1) * 1e-3).expect("advances");
            let slope = plant.sensitivities(0).expect("a derivative")[place];
            let difference = (above - below) / (2.0 * share);
            let label = format!("{law} at step {k}: {slope}, {difference}");
            within((slope - difference).abs(), 1e-3 * largest, label);
        }
    }
}
