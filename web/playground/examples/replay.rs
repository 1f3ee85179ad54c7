//! Runs models natively as a text on standard input asks, and prints the bits of their values, so that the page
//! can be compared with the library: `cargo run --package pneumatic-servo-playground --example replay`.
//!
//! ```text
//! model PneumaticServoCylinder
//! set friction.law 14
//! inputs valveVoltage supplyPressure
//! outputs position frictionForce
//! row 0 5 600000
//! row 0.001 5.1 600000
//! ```
//!
//! A `row` goes to its time, sets the inputs there and prints the outputs, as hexadecimal digits of their bits. Another
//! `model` starts another run.

use std::error::Error;
use std::io::{self, BufRead, Write};

use pneumatic_servo::model::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models;

/// A run under way.
struct Run {
    setup: Setup,
    plant: Option<Plant>,
    inputs: Vec<String>,
    outputs: Vec<String>,
}

impl Run {
    fn of(model: &str) -> Result<Self, Box<dyn Error>> {
        let model = models::find(model).ok_or_else(|| format!("there is no model {model}"))?;
        Ok(Self { setup: Setup::new(model), plant: None, inputs: Vec::new(), outputs: Vec::new() })
    }

    /// The outputs at a time, under inputs that hold from then on.
    fn row(&mut self, row: &[f64]) -> Result<Vec<f64>, Box<dyn Error>> {
        let (time, values) = row.split_first().ok_or("a row without a time")?;
        let plant = match &mut self.plant {
            Some(plant) => {
                plant.advance_to(*time)?;
                plant
            }
            none => {
                // A run starts with its first inputs, as on the page.
                for (name, value) in self.inputs.iter().zip(values) {
                    self.setup.change(name, *value)?;
                }
                none.insert(self.setup.start(*time)?)
            }
        };
        for (name, value) in self.inputs.iter().zip(values) {
            plant.set(name, *value)?;
        }
        Ok(self.outputs.iter().map(|name| plant.get(name)).collect::<Result<_, _>>()?)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let mut run = None;
    for line in io::stdin().lock().lines() {
        let line = line?;
        let mut words = line.split_whitespace();
        let command = words.next().unwrap_or_default();
        let words: Vec<&str> = words.collect();
        if command == "model" {
            run = Some(Run::of(words.first().unwrap_or(&""))?);
            continue;
        }
        let run = run.as_mut().ok_or("the first line names no model")?;
        match (command, &words[..]) {
            ("set", [name, value]) => run.setup.change(name, value.parse::<f64>()?)?,
            ("inputs", names) => run.inputs = names.iter().map(|&name| name.to_owned()).collect(),
            ("outputs", names) => run.outputs = names.iter().map(|&name| name.to_owned()).collect(),
            ("row", numbers) => {
                let row: Vec<f64> = numbers.iter().map(|number| number.parse()).collect::<Result<_, _>>()?;
                let bits: Vec<_> = run.row(&row)?.iter().map(|value| format!("{:016x}", value.to_bits())).collect();
                writeln!(out, "{}", bits.join(" "))?;
            }
            _ => return Err(format!("not understood: {line}").into()),
        }
    }
    Ok(())
}
