//! Closed forms that hold for the quarter car, and its balance of energy.

use pneumatic_servo::conformance;
use pneumatic_servo::model::{Model, Plant, Setup};
use quarter_car::{MODEL, QuarterCar};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn start(settings: &[(&str, f64)]) -> Result<Plant, Box<dyn std::error::Error>> {
    let set = settings.iter().try_fold(Setup::new(&MODEL), |setup, (name, value)| setup.set(name, *value))?;
    Ok(set.tolerance(1e-9).start(0.0)?)
}

/// Car and wheel so heavy that their speeds stay: the tyre settles on the slip curve.
#[test]
fn steady_friction_is_that_of_the_slip_curve() -> Outcome {
    for (velocity, slip) in [(30.0, 0.02), (30.0, 0.2), (30.0, 1.0), (5.0, 0.5), (-12.0, 0.3)] {
        let heavy = [("mass", 1e12), ("wheel.inertia", 1e12), ("velocity0", velocity), ("slip0", slip)];
        let mut car = start(&heavy)?;
        car.advance_to(2.0)?;
        let sliding: f64 = velocity * slip;
        let steady = 0.8 + 0.4 * (-(sliding / 6.0).powi(2)).exp();
        let expected = steady * sliding.signum() + 0.002 * sliding;
        let found = car.get("frictionCoefficient")?;
        assert!((found - expected).abs() < 1e-8, "{found} instead of {expected} at {velocity} m/s, slip {slip}");
        assert!((car.get("slip")? - velocity.signum() * slip).abs() < 1e-9);
    }
    Ok(())
}

/// Without damping and with one friction coefficient, `z = mu/sigma0*(1 - exp(-sigma0*x/mu))` over the distance `x`, and the
/// work of friction is the kinetic energy: `m*v0^2/2 = F_n*mu*(x - z)`. After the first halt the tyre only springs back.
#[test]
fn locked_wheel_stops_after_the_distance_of_the_closed_form() -> Outcome {
    for velocity in [2.0, 10.0, 30.0] {
        let (mu, stiffness, load, mass) = (0.8, 180.0, 2943.0, 300.0);
        let plain = [("tyre.sigma1", 0.0), ("tyre.sigma2", 0.0), ("tyre.muS", mu), ("tyre.muC", mu)];
        let locked = [("velocity0", velocity), ("slip0", 1.0), ("brakeTorque", 1e4)];
        let mut car = start(&[&plain[..], &locked].concat())?;
        let mut farthest = 0.0_f64;
        for step in 1..=10_000 {
            car.advance_to(f64::from(step) * 5e-4)?;
            farthest = farthest.max(car.get("distance")?);
            assert_eq!((car.get("wheelSpeed")?, car.get("locked")?), (0.0, 1.0));
        }
        let half = 0.5 * mass * velocity * velocity / (load * mu);
        // A few turns of a contraction by the factor exp(-sigma0*x/mu).
        let distance = (0..50).fold(half, |x, _| half + mu / stiffness * (1.0 - f64::exp(-stiffness * x / mu)));
        // Between two samples of the halt, at 8 m/s2, there are a few micrometres.
        assert!((farthest - distance).abs() < 3e-6, "{farthest} m instead of {distance} m from {velocity} m/s");
    }
    Ok(())
}

#[test]
fn energy_goes_to_the_brake_and_to_the_tyre() -> Outcome {
    let mut car = start(&[])?;
    let energy = |car: &mut Plant| -> Result<f64, Box<dyn std::error::Error>> {
        Ok(0.5 * 300.0 * car.get("velocity")?.powi(2) + 0.5 * car.get("wheelSpeed")?.powi(2))
    };
    // Power that leaves: of the tyre `F*v_r`, of the brake `T*|w|`.
    let power = |car: &mut Plant, torque: f64| -> Result<f64, Box<dyn std::error::Error>> {
        let (velocity, wheel) = (car.get("velocity")?, car.get("wheelSpeed")?);
        let friction = 2943.0 * car.get("frictionCoefficient")?;
        Ok(friction * (velocity - 0.3 * wheel) + torque * wheel.abs())
    };
    let (first, mut spent) = (energy(&mut car)?, 0.0);
    const STEP: f64 = 1e-4;
    for step in 0..20_000 {
        let torque = if step < 5_000 { 1400.0 } else { 500.0 };
        car.set("brakeTorque", torque)?;
        let before = power(&mut car, torque)?;
        car.advance_to(f64::from(step + 1) * STEP)?;
        spent += 0.5 * STEP * (before + power(&mut car, torque)?);
    }
    let missing = energy(&mut car)? + spent - first;
    // The trapezoids cost a few parts in a million where the wheel locks and rolls.
    assert!(missing.abs() < 2e-5 * first, "{missing} J of {first} J");
    assert!(energy(&mut car)? < 0.9 * first);
    Ok(())
}

#[test]
fn wheel_locks_stands_and_rolls_again_when_the_brake_yields() -> Outcome {
    let mut car = start(&[])?;
    car.set("brakeTorque", 1400.0)?;
    car.advance_to(1.0)?;
    assert_eq!((car.get("wheelSpeed")?, car.get("wheelAcceleration")?, car.get("locked")?), (0.0, 0.0, 1.0));
    assert_eq!(car.get("slip")?, 1.0);
    // The tyre turns the wheel with R*mu*F_n.
    let torque = 0.3 * 2943.0 * car.get("frictionCoefficient")?;
    car.set("brakeTorque", 1.001 * torque)?;
    assert_eq!(car.get("locked")?, 1.0);
    car.set("brakeTorque", 0.99 * torque)?;
    car.advance_to(1.5)?;
    assert_eq!(car.get("locked")?, 0.0);
    assert!(car.get("wheelSpeed")? > 1.0 && car.get("slip")? < 0.99);
    Ok(())
}

/// Rolling freely, skidding, and with a wheel that the brake holds.
#[test]
fn quarter_car_keeps_what_models_promise() -> Outcome {
    let with = |settings: &[(&str, f64)]| {
        settings.iter().try_fold(Setup::new(&MODEL), |setup, (name, value)| setup.set(name, *value))
    };
    // Without the damping of the bristles the tyre does not turn the wheel at once.
    let locked = [("slip0", 1.0), ("tyre.sigma1", 0.0), ("brakeTorque", 1e3)];
    conformance::model(&[with(&[])?, with(&[("slip0", 0.5), ("brakeTorque", 500.0)])?, with(&locked)?]);
    Ok(())
}

#[test]
fn static_friction_below_that_of_sliding_is_refused_by_name() {
    let refused = start(&[("tyre.muS", 0.5)]).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(refused.contains("tyre.muS = 0.5 is refused: it must not be below tyre.muC = 0.8"), "{refused}");
}

/// Compiled for more states than it has, the car runs with the same bits.
#[test]
fn places_to_spare_change_no_bit() -> Outcome {
    const SPACIOUS: Model = Model::of::<QuarterCar, 2, 7>(MODEL.name, MODEL.description, MODEL.experiment);
    let (mut car, mut spacious) = (Setup::new(&MODEL).start(0.0)?, Setup::new(&SPACIOUS).start(0.0)?);
    for step in 1..=500 {
        for car in [&mut car, &mut spacious] {
            car.set("brakeTorque", if step < 200 { 1400.0 } else { 500.0 })?;
            car.advance_to(f64::from(step) * 0.01)?;
        }
        for name in ["distance", "velocity", "wheelSpeed", "deflection", "frictionCoefficient", "locked"] {
            assert_eq!(car.get(name)?.to_bits(), spacious.get(name)?.to_bits(), "{name} after {step} steps");
        }
    }
    Ok(())
}
