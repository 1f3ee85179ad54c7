//! One run with its inputs applied and its outputs recorded.

use pneumatic_servo::co_simulation::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::variables::{ParameterError, Place, Table, Variable};
use pyo3::prelude::*;

use crate::failure::refused;
use crate::signal::{Reader, Signal};

/// The communication points of a run: `start + index * step`, each step ending exactly at its point plus its size.
#[derive(Clone, Copy)]
pub struct Grid {
    /// Time in s of the first point.
    pub start: f64,
    /// Size in s.
    pub step: f64,
    /// How many steps.
    pub count: usize,
    /// A row is recorded at the start and after every so many steps.
    pub every: usize,
}

impl Grid {
    /// The communication point of an index, in s.
    pub fn point(&self, index: usize) -> f64 {
        self.start + index as f64 * self.step
    }

    /// How many rows a complete run has.
    pub fn rows(&self) -> usize {
        self.count / self.every + 1
    }
}

/// An input with its place and its signal.
pub struct Driven<'a> {
    place: usize,
    variable: &'static Variable,
    reader: Reader<'a>,
}

impl<'a> Driven<'a> {
    /// An input of a table.
    pub fn find(table: &Table, name: &str, signal: Signal<'a>) -> PyResult<Self> {
        let refuse = || refused(format!("{name} is not an input{}", resembling(table, name)));
        let entry = table.find(name).ok_or_else(refuse)?;
        let Place::Input(place) = entry.place else { return Err(refuse()) };
        Ok(Self { place, variable: entry.variable, reader: Reader::new(&entry.variable.name, signal) })
    }

    /// The value at a time in s, which the variable may have.
    fn at(&mut self, time: f64) -> PyResult<f64> {
        let value = self.reader.at(time)?;
        self.variable.check(value).map_err(|error| at_time(&error, time))?;
        Ok(value)
    }
}

fn at_time(error: &ParameterError, time: f64) -> PyErr {
    refused(format!("at t = {time} s {error}"))
}

fn resembling(table: &Table, name: &str) -> String {
    let similar = table.similar(name);
    if similar.is_empty() { String::new() } else { format!("; did you mean {}?", similar.join(" or ")) }
}

/// The places of variables to record.
pub fn places(table: &Table, names: &[String]) -> PyResult<Vec<Place>> {
    let find = |name: &String| {
        let entry = table.find(name);
        entry.map(|entry| entry.place).ok_or_else(|| {
            let hint = resembling(table, name);
            refused(format!("there is no variable {name}{hint}"))
        })
    };
    names.iter().map(find).collect()
}

/// How far a run came.
pub struct Reached {
    /// Rows that are recorded.
    pub rows: usize,
    /// Why it did not come further.
    pub failure: Option<String>,
}

/// Starts a plant with the inputs' first values and runs it over a grid.
///
/// The slot of output `o` in row `r` is `record[o * rows + r]`. Before every step `look` is asked, with the index of
/// the step, whether to go on.
///
/// # Errors
/// A parameter or an input that is refused, or what a function of Python raises; the rows until then are recorded.
pub fn record(
    mut setup: Setup,
    mut driven: Vec<Driven<'_>>,
    grid: Grid,
    outputs: &[Place],
    slots: &mut [f64],
    reached: &mut Reached,
    mut look: impl FnMut(usize) -> PyResult<bool>,
) -> PyResult<()> {
    for input in &mut driven {
        let value = input.at(grid.start)?;
        setup.change(&input.variable.name, value).map_err(refused)?;
    }
    let mut plant = setup.start(grid.start).map_err(refused)?;
    let rows = grid.rows();
    read(&mut plant, outputs, slots, rows, 0);
    reached.rows = 1;
    for index in 0..grid.count {
        if !look(index)? {
            return Ok(());
        }
        let point = grid.point(index);
        if index > 0 {
            for input in &mut driven {
                plant.set_input(input.place, input.at(point)?);
            }
        }
        if let Err(error) = plant.advance_to(point + grid.step) {
            reached.failure = Some(error.to_string());
            return Ok(());
        }
        if (index + 1) % grid.every == 0 {
            read(&mut plant, outputs, slots, rows, reached.rows);
            reached.rows += 1;
        }
    }
    Ok(())
}

fn read(plant: &mut Plant, outputs: &[Place], slots: &mut [f64], rows: usize, row: usize) {
    for (output, place) in outputs.iter().enumerate() {
        slots[output * rows + row] = plant.value(*place);
    }
}
