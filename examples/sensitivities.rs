//! Sensitivities of the end of a run by parameters, states and inputs: `sensitivities [<law> <duration in s> <name> ...]`.

use std::env;
use std::error::Error;
use std::f64::consts::TAU;

use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo::variables::Place;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments: Vec<String> = env::args().skip(1).collect();
    if arguments.is_empty() {
        arguments = ["Stribeck", "0.5", "valve.C", "friction.stribeck.Fs"].map(str::to_owned).into();
    }
    let [law, duration, names @ ..] = &arguments[..] else {
        return Err("usage: sensitivities [<law> <duration in s> <name> ...]".into());
    };
    let duration: f64 = duration.parse()?;
    let mut plant = Setup::new(&MODEL).set("friction.law", law.as_str())?.start(0.0)?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    plant.carry_sensitivities(&names)?;
    let steps = (duration / 1e-3).round() as u32;
    for step in 0..steps {
        plant.set("valveVoltage", 5.0 + 2.0 * (TAU * f64::from(step) * 1e-3).sin())?;
        plant.advance_to(f64::from(step + 1) * 1e-3)?;
    }
    println!("position: {} m", plant.get("position")?);
    let Some(Place::Computed(position)) = plant.table().find("position").map(|entry| entry.place) else {
        return Err("the position is computed".into());
    };
    for (direction, name) in names.iter().enumerate() {
        println!("by {name}: {:e}", plant.sensitivities(direction)?[position]);
    }
    for event in plant.crossings() {
        println!("{:.6} s {}, later by {:?}", event.time, event.event, event.delays);
    }
    Ok(())
}
