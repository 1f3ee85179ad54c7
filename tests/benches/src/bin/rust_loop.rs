//! The plant stepped by 1 ms with a fresh voltage each time, in Rust: prints nanoseconds per step, for
//! `tests/benches/python_package.py`.

use std::f64::consts::TAU;
use std::time::Instant;

use anyhow::Result;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const STEP: f64 = 1e-3;
const STEPS: u32 = 3000;
const REPETITIONS: usize = 15;

fn main() -> Result<()> {
    let best = (0..REPETITIONS).map(|_| seconds()).collect::<Result<Vec<_>>>()?;
    println!("{}", 1e9 * best.into_iter().fold(f64::INFINITY, f64::min) / f64::from(STEPS));
    Ok(())
}

/// The time of one run that reads the position after each step.
fn seconds() -> Result<f64> {
    let voltages: Vec<f64> = (0..STEPS).map(|k| 5.0 + 2.0 * (TAU * f64::from(k) * STEP).sin()).collect();
    let begin = Instant::now();
    let mut plant = Setup::new(&MODEL).start(0.0)?;
    let mut positions = Vec::with_capacity(voltages.len());
    for (k, voltage) in voltages.iter().enumerate() {
        plant.set("valveVoltage", *voltage)?;
        plant.advance_to(k as f64 * STEP + STEP)?;
        positions.push(plant.get("position")?);
    }
    anyhow::ensure!(positions.iter().all(|position| position.is_finite()), "a position is not finite");
    Ok(begin.elapsed().as_secs_f64())
}
