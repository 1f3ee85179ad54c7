//! Comparison of the friction laws under the same slow sine at the valve: `cargo run --release --example compare_laws`.

use std::error::Error;
use std::f64::consts::TAU;

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

const STEP: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:<20} {:>11} {:>11} {:>13} {:>9}", "law", "travel (mm)", "at rest (s)", "friction (N)", "steps");
    for (_, law, _) in LAWS.items {
        let mut plant = Setup::new(&MODEL).set("friction.law", *law)?.start(0.0)?;
        let (mut low, mut high, mut rest, mut largest) = (f64::MAX, f64::MIN, 0.0, 0.0_f64);
        for step in 1..=4000 {
            plant.set("valveVoltage", 5.0 + 0.8 * (0.5 * TAU * plant.time()).sin())?;
            plant.advance_to(f64::from(step) * STEP)?;
            let position = plant.get("position")?;
            (low, high) = (low.min(position), high.max(position));
            rest += STEP * plant.get("sticking")?;
            largest = largest.max(plant.get("frictionForce")?.abs());
        }
        let steps = plant.get("solver.steps")?;
        println!("{law:<20} {:>11.2} {rest:>11.3} {largest:>13.2} {steps:>9}", 1e3 * (high - low));
    }
    Ok(())
}
