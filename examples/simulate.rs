//! Runs the cylinder with a sine at the valve and writes a table: `cargo run --release --example simulate > run.csv`.
//!
//! The first argument is the friction law, `Stribeck` if there is none.

use std::error::Error;
use std::f64::consts::TAU;

use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const STEP: f64 = 1e-3;
const COLUMNS: [&str; 5] = ["valveVoltage", "position", "chamberA.pressure", "chamberB.pressure", "frictionForce"];

fn main() -> Result<(), Box<dyn Error>> {
    let law = std::env::args().nth(1).unwrap_or("Stribeck".to_owned());
    let mut plant = Setup::new(&MODEL).set("friction.law", law.as_str())?.set("supplyPressure", 6e5)?.start(0.0)?;

    println!("time,{}", COLUMNS.join(","));
    for step in 0..=3000 {
        let time = f64::from(step) * STEP;
        plant.advance_to(time)?;
        plant.set("valveVoltage", 5.0 + 2.0 * (TAU * time).sin())?;
        let mut row = time.to_string();
        for name in COLUMNS {
            row.push_str(&format!(",{}", plant.get(name)?));
        }
        println!("{row}");
    }
    Ok(())
}
