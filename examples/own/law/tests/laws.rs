//! Closed forms of the laws, in models of the library.

use own_law::catalogue::Friction;
use own_law::{BENCH, CYLINDER};
use pneumatic_servo::conformance::law::MOST;
use pneumatic_servo::conformance::{Claims, found_dependencies, law, repeats};
use pneumatic_servo::models;
use pneumatic_servo::prelude::*;
use pneumatic_servo::variables::Kind;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A bench under a law, moved as prescribed.
fn moved(law: &str, velocity: f64) -> Result<Setup, Box<dyn std::error::Error>> {
    let setup = Setup::new(&BENCH).set("friction.law", law)?.set("bench.drive", "PrescribedMotion")?;
    Ok(setup.set("driveVelocity", velocity)?)
}

#[test]
fn contact_breaks_away_at_the_static_friction_and_slides_at_the_curve() -> Outcome {
    let mut bench =
        Setup::new(&BENCH).set("friction.law", "HyperbolicStribeck")?.set("bench.drive", "Free")?.start(0.0)?;
    bench.set("appliedForce", 10.999)?;
    bench.step(1.0)?;
    assert_eq!((bench.get("sticking")?, bench.get("position")?), (1.0, 0.0));
    bench.set("appliedForce", 11.001)?;
    bench.step(1e-3)?;
    assert_eq!(bench.get("sticking")?, 0.0);
    for (velocity, force) in [(0.01, 8.3 + 1.35 + 0.3), (0.03, 8.3 + 0.27 + 0.9), (-0.01, -9.95)] {
        let mut bench = moved("HyperbolicStribeck", velocity)?.start(0.0)?;
        bench.step(0.01)?;
        let found = bench.get("frictionForce")?;
        assert!((found - force).abs() < 1e-12, "{found} N at {velocity} m/s, not {force} N");
    }
    Ok(())
}

/// From rest the force follows the way: `F = lambda*F_c*(1 - exp(-s/z_c))`. The solver's tolerance of 1e-6 remains.
#[test]
fn bristle_yields_over_the_same_distance_at_any_load() -> Outcome {
    for level in [0.5, 1.0, 3.0] {
        let mut bench = moved("LoadedDahl", 1e-3)?.set("friction.level", level)?.start(0.0)?;
        for step in 1..=50 {
            bench.step(1e-3)?;
            let expected = level * 10.0 * (1.0 - (-f64::from(step) * 1e-6 / 1e-5f64).exp());
            let found = bench.get("frictionForce")?;
            assert!((found - expected).abs() < 1e-5 * level * 10.0, "{found} N, not {expected} N, at level {level}");
        }
    }
    Ok(())
}

/// Values worked out by hand: at three quarters of the velocity of creep the root is 0.6 of all.
#[test]
fn smoothed_friction_is_that_of_the_equation() -> Outcome {
    for (velocity, force) in [(0.75e-3, 8.3 * 0.6 + 0.0225), (-0.75e-3, -8.3 * 0.6 - 0.0225)] {
        let mut bench = moved("RootedCoulomb", velocity)?.start(0.0)?;
        bench.step(0.01)?;
        let found = bench.get("frictionForce")?;
        assert!((found - force).abs() < 1e-12, "{found} N at {velocity} m/s, not {force} N");
    }
    Ok(())
}

/// From rest each bristle follows the way by itself. The solver's tolerance of 1e-6 remains.
#[test]
fn bristles_yield_one_after_the_other() -> Outcome {
    let mut bench = moved("TwoBristles", 1e-3)?.start(0.0)?;
    for step in 1..=100 {
        bench.step(1e-3)?;
        let way = f64::from(step) * 1e-6;
        let expected = 4.0 * (1.0 - (-way / 1e-5).exp()) + 6.0 * (1.0 - (-way / 5e-5).exp());
        let found = bench.get("frictionForce")?;
        assert!((found - expected).abs() < 1e-4, "{found} N, not {expected} N, after {way} m");
    }
    Ok(())
}

/// From rest the film passes on the force of the bristle, later. The solver's tolerance of 1e-6 remains.
#[test]
fn force_behind_a_film_lags() -> Outcome {
    let mut bench = moved("LaggedBristle", 1e-3)?.start(0.0)?;
    let (rate, lag) = (1e-3 / 1e-4, 0.02);
    for step in 1..=100 {
        bench.step(1e-3)?;
        let time = f64::from(step) * 1e-3;
        let left = ((-rate * time).exp() - rate * lag * (-time / lag).exp()) / (1.0 - rate * lag);
        let expected = 8.3 * (1.0 - left) + 0.03;
        let found = bench.get("frictionForce")?;
        assert!((found - expected).abs() < 1e-4, "{found} N, not {expected} N, after {time} s");
    }
    Ok(())
}

/// Dependencies on named states, of a sensor of the force for example, are in the table, which packing writes as the structure of the
/// model. No law declares them.
#[test]
fn coupled_states_need_no_declaration() -> Outcome {
    let under = |law: &str| Ok::<_, Box<dyn std::error::Error>>(Setup::new(&CYLINDER).set("friction.law", law)?);
    for law in ["LaggedBristle", "TwoBristles", "WarmBristle", "RateAndState"] {
        found_dependencies(&under(law)?.set("valveVoltage", 6.5)?);
    }
    let setup = under("LaggedBristle")?;
    let table = setup.table();
    let reference = |name: &str| table.find(name).expect("a variable").variable.reference;
    let rate = table.find("der(friction.laggedBristle.film)").expect("a rate").variable;
    assert!(table.dependencies(rate).contains(&reference("friction.laggedBristle.bristle")));
    Ok(())
}

/// From the age of the reference velocity: `theta = L/v + (L/v_0 - L/v)*exp(-v*t/L)`, and friction in steady sliding is
/// `F_c + (a - b)*ln(v/v_0)` and the viscous part.
#[test]
fn age_follows_the_closed_form() -> Outcome {
    for velocity in [1e-4f64, 1e-2, -1e-2] {
        let mut bench = moved("RateAndState", velocity)?.start(0.0)?;
        let (distance, reference, speed) = (1e-5, 1e-3, velocity.abs());
        assert_eq!(bench.get("friction.rateAndState.theta")?, distance / reference);
        for step in 1..=50 {
            bench.step(1e-3)?;
            let decay = (-speed * f64::from(step) * 1e-3 / distance).exp();
            let expected = distance / speed + (distance / reference - distance / speed) * decay;
            let found = bench.get("friction.rateAndState.theta")?;
            assert!((found - expected).abs() < 1e-5 * expected, "{found} s, not {expected} s, at step {step}");
        }
        bench.advance_to(1.0)?;
        let steady = 8.3 + (1.5 - 1.8) * (speed / reference).ln() + 30.0 * speed;
        let found = bench.get("frictionForce")? * velocity.signum();
        assert!((found - steady).abs() < 1e-4, "{found} N, not {steady} N, at {velocity} m/s");
    }
    Ok(())
}

/// In steady sliding `C*w*(1 + beta*w) = F_c*v`.
#[test]
fn contact_fades_as_it_warms() -> Outcome {
    let mut bench = moved("WarmBristle", 0.5)?.start(0.0)?;
    bench.advance_to(2.0)?;
    let warming = ((1.0 + 4.0 * 0.02 * 8.3 * 0.5 / 0.2_f64).sqrt() - 1.0) / (2.0 * 0.02);
    let found = bench.get("friction.warmBristle.temperature")? - 293.15;
    assert!((found - warming).abs() < 1e-4, "{found} K, not {warming} K");
    let (force, faded) = (bench.get("frictionForce")?, 8.3 / (1.0 + 0.02 * warming) + 15.0);
    assert!((force - faded).abs() < 1e-4, "{force} N, not {faded} N");
    Ok(())
}

/// Named states are variables in the group of their law, with units, rates and dependencies.
#[test]
fn named_states_are_variables_of_their_law() -> Outcome {
    for model in [&BENCH, &CYLINDER] {
        let table = model.table();
        let variable = |name: &str| table.find(name).map(|entry| entry.variable).ok_or(name.to_owned());
        let (bristle, warmth) =
            (variable("friction.warmBristle.bristle")?, variable("friction.warmBristle.temperature")?);
        let rate = variable("der(friction.warmBristle.temperature)")?;
        assert_eq!([bristle.kind, warmth.kind], [units::METRE, units::KELVIN].map(Kind::Real));
        assert_eq!((rate.kind, rate.derivative_of), (Kind::Real(units::KELVIN_PER_SECOND), Some(warmth.reference)));
        assert!(table.dependencies(rate).contains(&bristle.reference), "{:?}", rate.depends_on);
        assert!(table.dependencies(variable("frictionForce")?).contains(&warmth.reference));
        let theta = variable("der(friction.rateAndState.theta)")?;
        assert!(!table.dependencies(theta).contains(&warmth.reference), "{:?}", theta.depends_on);
    }
    let mut cylinder = Setup::new(&CYLINDER).set("friction.law", "WarmBristle")?.start(0.0)?;
    cylinder.set("valveVoltage", 7.0)?;
    cylinder.advance_to(0.3)?;
    assert!(cylinder.get("friction.warmBristle.temperature")? > 293.2);
    assert_eq!(cylinder.get("friction.rateAndState.theta")?, 0.0, "a state of another law");
    Ok(())
}

/// A law of the library gives the same bits beside laws of your own.
#[test]
fn laws_of_the_library_keep_their_bits() -> Outcome {
    let ended = |model: &'static Model, law: &str| -> Result<[u64; 2], Box<dyn std::error::Error>> {
        let mut plant = Setup::new(model).set("friction.law", law)?.start(0.0)?;
        for step in 0..200 {
            plant.set("valveVoltage", 5.0 + 0.02 * f64::from(step))?;
            plant.step(1e-3)?;
        }
        Ok([plant.get("position")?.to_bits(), plant.get("frictionForce")?.to_bits()])
    };
    for law in ["Stribeck", "LuGre", "GMS"] {
        assert_eq!(ended(&CYLINDER, law)?, ended(&models::pneumatic_servo_cylinder::MODEL, law)?, "{law}");
    }
    Ok(())
}

/// The new laws keep what every law promises, in the friction bench; all are odd. A bristle stores at most `lambda*F_c*z_c/2`,
/// the others no energy.
#[test]
fn new_laws_keep_what_laws_promise() {
    let stored = 0.5 * MOST * 10.0 * 1e-5;
    law::<Friction>("HyperbolicStribeck", Claims { odd: true, stored: Some(0.0) });
    law::<Friction>("LoadedDahl", Claims { odd: true, stored: Some(stored) });
    law::<Friction>("RootedCoulomb", Claims { odd: true, stored: Some(0.0) });
    let of_both = 0.5 * MOST * (4.0 * 1e-5 + 6.0 * 5e-5);
    law::<Friction>("TwoBristles", Claims { odd: true, stored: Some(of_both) });
    // A lag may return energy for a while: no bound is claimed.
    law::<Friction>("LaggedBristle", Claims { odd: true, stored: None });
    law::<Friction>("RateAndState", Claims { odd: true, stored: Some(0.0) });
    law::<Friction>("WarmBristle", Claims { odd: true, stored: None });
}

/// The laws move the cylinder, and saved states repeat to the bit.
#[test]
fn cylinder_runs_under_the_new_laws_and_repeats_from_saved_states() -> Outcome {
    for law in [
        "HyperbolicStribeck",
        "LoadedDahl",
        "RootedCoulomb",
        "TwoBristles",
        "LaggedBristle",
        "RateAndState",
        "WarmBristle",
    ] {
        let setup = Setup::new(&CYLINDER).set("friction.law", law)?.set("valveVoltage", 6.5)?;
        let mut plant = setup.start(0.0)?;
        plant.advance_to(0.3)?;
        assert!(plant.get("position")? > 0.26, "{law}: {} m", plant.get("position")?);
        repeats(&setup, 0.1);
    }
    Ok(())
}
