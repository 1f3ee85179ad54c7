//! The observer as a model: what it tells is what an observer tells, and it refuses what cannot be observed.

#![cfg(feature = "sensitivities")]

use pneumatic_servo::model::{Method, Observed, Observer, Setup};
use pneumatic_servo::models::{friction_observer, pneumatic_servo_cylinder};
use pneumatic_servo::variables::{Choice, find};

const PERIOD: f64 = 1e-3;
const SHOWN: [&str; 4] = ["position", "velocity", "chamberA.pressure", "frictionForce"];

fn voltage(step: u32) -> f64 {
    5.0 + 1.5 * libm::sin(30.0 * f64::from(step) * PERIOD)
}

/// From voltage, position and a pressure, with an unknown force: each estimate and deviation has the bits of the observer's, also
/// after it has been saved and restored on the way.
#[test]
fn model_tells_what_an_observer_tells() -> Result<(), Box<dyn std::error::Error>> {
    [Method::Extended, Method::Unscented].into_iter().try_for_each(model_tells)
}

fn model_tells(method: Method) -> Result<(), Box<dyn std::error::Error>> {
    let plant =
        Setup::new(&pneumatic_servo_cylinder::MODEL).set("friction.law", "LuGre")?.set("supplyPressure", 6e5)?;
    let measured = [("position", 20e-6), ("chamberA.pressure", 500.0)];
    let observed =
        Observed { measured: &measured, period: PERIOD, process: &[("externalForce", 30.0)], initial: &[], method };
    let mut observer = Observer::new(&plant, observed)?;
    let mut model = Setup::new(&friction_observer::MODEL)
        .set("friction.law", "LuGre")?
        .set("supplyPressure", 6e5)?
        .set("valveVoltage", voltage(0))?
        .set("noise.chamberA.pressure", 500.0)?
        .set("process.externalForce", 30.0)?
        .set("observer.method", f64::from(method.id()))?
        .start(0.0)?;
    let mut plant = plant.set("valveVoltage", voltage(0))?.start(0.0)?;
    let mut saved = None;
    for step in 0..150 {
        // A sample sees what is set at its communication point, and tells it behind.
        model.set("valveVoltage", voltage(step))?;
        for (name, _) in measured {
            model.set(&format!("measured.{name}"), plant.get(name)?)?;
        }
        if step == 100 {
            saved = Some(model.save());
        }
        model.step(PERIOD)?;
        if step > 0 {
            let mut inputs = plant_inputs(&observer);
            inputs[0] = voltage(step - 1);
            observer.update(&inputs, &measured.map(|(name, _)| plant.get(name).ok()))?;
        }
        for name in SHOWN {
            let place = find(observer.setup().table(), name)?.place;
            assert_eq!(model.get(name)?, observer.value(place), "{name} at {step}");
            assert_eq!(
                model.get(&format!("deviation.{name}"))?,
                observer.deviation(place),
                "deviation of {name} at {step}"
            );
        }
        plant.set("valveVoltage", voltage(step))?;
        plant.step(PERIOD)?;
    }
    assert!((model.get("velocity")? - plant.get("velocity")?).abs() < 0.02, "it follows the plant");
    let ended = SHOWN.map(|name| model.get(name).map(f64::to_bits));
    model.restore(&saved.expect("a state on the way"))?;
    let mut plant = Setup::new(&pneumatic_servo_cylinder::MODEL)
        .set("friction.law", "LuGre")?
        .set("supplyPressure", 6e5)?
        .set("valveVoltage", voltage(0))?
        .start(0.0)?;
    for step in 0..150 {
        if step >= 100 {
            model.set("valveVoltage", voltage(step))?;
            for (name, _) in measured {
                model.set(&format!("measured.{name}"), plant.get(name)?)?;
            }
            model.step(PERIOD)?;
        }
        plant.set("valveVoltage", voltage(step))?;
        plant.step(PERIOD)?;
    }
    assert_eq!(SHOWN.map(|name| model.get(name).map(f64::to_bits)), ended);
    Ok(())
}

/// The inputs that an observer starts from.
fn plant_inputs(observer: &Observer) -> Vec<f64> {
    observer.setup().inputs().to_vec()
}

#[test]
fn observer_without_a_measurement_is_refused() -> Result<(), Box<dyn std::error::Error>> {
    let setup = Setup::new(&friction_observer::MODEL).set("noise.position", 0.0)?;
    assert_eq!(setup.start(0.0).map(|_| ()).map_err(|error| error.variable), Err("noise.position".to_owned()));
    Ok(())
}
