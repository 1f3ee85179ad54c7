//! Closes a position loop around the cylinder, with the library's controller and with one of your own:
//! `cargo run --release --example closed_loop`.

use std::error::Error;
use std::f64::consts::PI;

use pneumatic_servo::model::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::{pneumatic_servo_cylinder, position_controller};

const PERIOD: f64 = 1e-3;

/// Inputs of a controller at a sample: the reference and the measured values, in m and m/s.
struct Sample {
    reference: f64,
    position: f64,
    velocity: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut library = Setup::new(&position_controller::MODEL).start(0.0)?;
    let error = track(|sample| answer(&mut library, sample))?;
    println!("PositionController: rms error {:.2} mm", 1e3 * error);

    let error = track(|sample| Ok(5.0 + 12.0 * (sample.reference - sample.position) - 0.8 * sample.velocity))?;
    println!("proportional, with damping: rms error {:.2} mm", 1e3 * error);
    Ok(())
}

/// The voltage that the model of a controller gives after the sample.
fn answer(controller: &mut Plant, sample: &Sample) -> Result<f64, Box<dyn Error>> {
    controller.set("referencePosition", sample.reference)?;
    controller.set("position", sample.position)?;
    controller.set("velocity", sample.velocity)?;
    controller.step(PERIOD)?;
    Ok(controller.get("valveVoltage")?)
}

/// Lets the carriage follow a sine for 4 s; the rms error in m after the first second.
fn track(mut controller: impl FnMut(&Sample) -> Result<f64, Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let setup = Setup::new(&pneumatic_servo_cylinder::MODEL).set("supplyPressure", 6e5)?.set("position0", 0.15)?;
    let mut plant = setup.start(0.0)?;
    let mut squares = Vec::new();
    for step in 0..4000 {
        let time = f64::from(step) * PERIOD;
        let reference = 0.25 - 0.1 * (PI * time).cos();
        let sample = Sample { reference, position: plant.get("position")?, velocity: plant.get("velocity")? };
        if time >= 1.0 {
            squares.push((reference - sample.position).powi(2));
        }
        plant.set("valveVoltage", controller(&sample)?.clamp(0.0, 10.0))?;
        plant.step(PERIOD)?;
    }
    Ok((squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}
