//! One run with its inputs applied and its outputs recorded.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pneumatic_servo::model::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::variables::{Notice, Place, Table, Variable};
use pyo3::prelude::*;

use crate::failure::{refused, refused_at, refused_setting, refused_value};
use crate::signal::{Reader, Signal};
use crate::slopes::Slopes;

/// The communication points of a run: `start + index * step`, each step ending exactly at its point plus its size.
#[derive(Clone, Copy)]
pub struct Grid {
    /// Time in s of the first point.
    pub start: f64,
    /// Size in s.
    pub step: f64,
    /// How many steps.
    pub count: usize,
    /// Steps between two recorded rows; the start and the end are always recorded.
    pub every: usize,
    /// Whether inputs run on straight lines from each point to the next; otherwise they are held.
    pub has_lines: bool,
}

/// Start and step in s, number of steps, and steps per row: as Python hands it over.
impl From<(f64, f64, usize, usize)> for Grid {
    fn from((start, step, count, every): (f64, f64, usize, usize)) -> Self {
        Self { start, step, count, every, has_lines: false }
    }
}

impl Grid {
    /// The communication point of an index, in s.
    pub fn point(&self, index: usize) -> f64 {
        self.start + index as f64 * self.step
    }

    /// How many rows a complete run has.
    pub fn rows(&self) -> usize {
        self.count.div_ceil(self.every) + 1
    }
}

/// An input with its place and its signal.
pub struct Driven<'a> {
    /// Its place among the inputs.
    pub place: usize,
    variable: &'static Variable,
    reader: Reader<'a>,
    /// The smallest and the largest value until now.
    pub extremes: (f64, f64),
}

impl<'a> Driven<'a> {
    /// Inputs of a table by their names, each with its signal.
    pub fn all<'b>(
        table: &'static Table,
        signals: impl Iterator<Item = PyResult<(&'b String, Signal<'a>)>>,
    ) -> PyResult<Vec<Self>> {
        signals.map(|it| it.and_then(|(name, signal)| Self::find(table, name, signal))).collect()
    }

    fn find(table: &'static Table, name: &str, signal: Signal<'a>) -> PyResult<Self> {
        let refuse = || refused(format!("{name} is not an input{}", resembling(table, name)));
        let entry = table.find(name).ok_or_else(refuse)?;
        let Place::Input(place) = entry.place else { return Err(refuse()) };
        let reader = Reader::new(&entry.variable.name, signal);
        Ok(Self { place, variable: entry.variable, reader, extremes: (f64::INFINITY, f64::NEG_INFINITY) })
    }

    /// The value at a time in s, which the variable may have.
    pub fn at(&mut self, time: f64) -> PyResult<f64> {
        let value = self.reader.at(time)?;
        self.variable.check(value).map_err(|error| refused_at(error, time))?;
        Ok(value)
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        &self.variable.name
    }

    /// Sets a plant's input to its value at a time in s; tells whether it is smaller or larger than all before.
    fn apply(&mut self, plant: &mut Plant, time: f64) -> PyResult<bool> {
        let value = self.at(time)?;
        plant.set_input(self.place, value).map_err(|error| refused_at(error, time))?;
        Ok(self.is_extreme(value))
    }

    /// Whether a value is smaller or larger than all before.
    fn is_extreme(&mut self, value: f64) -> bool {
        let (low, high) = self.extremes;
        self.extremes = (low.min(value), high.max(value));
        self.extremes != (low, high)
    }
}

fn resembling(table: &Table, name: &str) -> String {
    let similar = table.similar(name);
    if similar.is_empty() { String::new() } else { format!("; did you mean {}?", similar.join(" or ")) }
}

/// The place of a variable.
pub fn place(table: &Table, name: &str) -> PyResult<Place> {
    let entry = table.find(name);
    entry.map(|entry| entry.place).ok_or_else(|| {
        let hint = resembling(table, name);
        refused(format!("there is no variable {name}{hint}"))
    })
}

/// The places of variables to record.
pub fn places(table: &Table, names: &[String]) -> PyResult<Vec<Place>> {
    names.iter().map(|name| place(table, name)).collect()
}

/// What a plant finds unusual about a value: variable, value and remark.
#[derive(IntoPyObject)]
pub struct Noticed(&'static str, f64, &'static str);

impl From<Notice> for Noticed {
    fn from(notice: Notice) -> Self {
        Self(notice.variable, notice.value, notice.remark)
    }
}

/// How far a run came, and what was unusual about it.
#[derive(Default)]
pub struct Reached {
    /// Rows that are recorded.
    pub rows: usize,
    /// Why it did not come further.
    pub failure: Option<String>,
    /// What the plant noticed first of each variable.
    pub noticed: Vec<Notice>,
    /// The log of the solver, if it is asked for.
    pub log: Option<Log>,
}

/// Work of the solver.
#[derive(Default)]
pub struct Log {
    places: Vec<Place>,
    /// Counters of the solver at each row, one after the other.
    counts: Vec<f64>,
    /// Times in s and names of the events.
    events: Vec<(f64, &'static str)>,
}

impl Log {
    /// A log of the counters of these names.
    ///
    /// # Errors
    /// `ValueError` for a model without a solver.
    pub fn new(table: &Table, counters: &[String]) -> PyResult<Self> {
        Ok(Self { places: places(table, counters)?, ..Self::default() })
    }

    /// As Python takes it.
    pub fn tell(self, py: Python<'_>) -> Logged<'_> {
        let shape = (self.counts.len() / self.places.len(), self.places.len());
        let counts = Array2::from_shape_vec(shape, self.counts).expect("one count per row and counter");
        (counts.into_pyarray(py), self.events)
    }
}

/// Counters `[row, counter]`, and times in s and names of events.
pub type Logged<'py> = (Bound<'py, PyArray2<f64>>, Vec<(f64, &'static str)>);

impl Reached {
    /// Begins the log that is asked for, of a plant that has started.
    pub fn begin_log(&mut self, plant: &mut Plant) {
        if let Some(log) = &mut self.log {
            log.counts.clear();
            plant.log_events();
        }
    }

    /// Logs the work until a row.
    pub fn count(&mut self, plant: &Plant) {
        if let Some(Log { places, counts, .. }) = &mut self.log {
            counts.extend(places.iter().map(|place| plant.value(*place)));
        }
    }

    /// Ends the log.
    pub fn end_log(&mut self, plant: &Plant) {
        if let Some(log) = &mut self.log {
            log.events = plant.logged_events();
        }
    }

    /// Takes over what a plant notices of variables that are not known yet.
    pub fn notice(&mut self, plant: &Plant) {
        for notice in plant.notices() {
            if self.noticed.iter().all(|known| known.variable != notice.variable) {
                self.noticed.push(notice);
            }
        }
    }
}

/// What a run records.
pub struct Rows<'a> {
    /// Variables.
    pub outputs: &'a [Place],
    /// The slot of output `o` in row `r` is `slots[o * rows + r]`.
    pub slots: &'a mut [f64],
    /// How they change with others, if that is asked for.
    pub slopes: Option<&'a mut Slopes>,
}

impl Rows<'_> {
    fn read(&mut self, plant: &mut Plant, rows: usize, row: usize) {
        for (output, place) in self.outputs.iter().enumerate() {
            self.slots[output * rows + row] = plant.value(*place);
        }
        if let Some(slopes) = &mut self.slopes {
            slopes.read(plant, self.outputs, row);
        }
    }
}

/// Starts a plant with the inputs' first values and runs it over a grid. Before every step `look` is asked, with the index of
/// the step and the plant, whether to go on.
///
/// # Errors
/// A parameter or an input that is refused, or what a function of Python raises; the rows until then are recorded.
pub fn record(
    setup: Setup,
    driven: &mut [Driven<'_>],
    grid: Grid,
    mut rows: Rows<'_>,
    reached: &mut Reached,
    look: impl FnMut(usize, &mut Plant) -> PyResult<bool>,
) -> PyResult<()> {
    let mut plant = started(setup, driven, grid)?;
    if let Some(slopes) = &rows.slopes {
        slopes.begin(&mut plant)?;
    }
    reached.notice(&plant);
    reached.begin_log(&mut plant);
    let outcome = go(&mut plant, driven, grid, &mut rows, reached, look);
    reached.end_log(&plant);
    if let Some(slopes) = rows.slopes {
        slopes.end(&plant, grid.start);
    }
    outcome
}

/// A plant that starts with the inputs' first values.
///
/// # Errors
/// A parameter or an input that is refused, or what a function of Python raises.
pub fn started(mut setup: Setup, driven: &mut [Driven<'_>], grid: Grid) -> PyResult<Plant> {
    for input in &mut *driven {
        let value = input.at(grid.start)?;
        input.is_extreme(value);
        setup.change(&input.variable.name, value).map_err(refused_setting)?;
    }
    setup.start(grid.start).map_err(refused_value)
}

/// Runs a plant that has started over a grid.
fn go(
    plant: &mut Plant,
    driven: &mut [Driven<'_>],
    grid: Grid,
    rows: &mut Rows<'_>,
    reached: &mut Reached,
    mut look: impl FnMut(usize, &mut Plant) -> PyResult<bool>,
) -> PyResult<()> {
    rows.read(plant, grid.rows(), 0);
    reached.count(plant);
    reached.rows = 1;
    for index in 0..grid.count {
        if !look(index, plant)? {
            return Ok(());
        }
        let (point, next) = (grid.point(index), grid.point(index + 1));
        let mut is_news = false;
        for input in &mut *driven {
            if grid.has_lines {
                let slope = (input.at(next)? - plant.value(Place::Input(input.place))) / grid.step;
                plant.slope_input(input.place, slope);
            } else if index > 0 {
                is_news |= input.apply(plant, point)?;
            }
        }
        // What is noticed of an input depends on how small or large it is.
        if is_news {
            reached.notice(plant);
        }
        if let Err(error) = plant.advance_to(point + grid.step) {
            reached.failure = Some(error.to_string());
            return Ok(());
        }
        if grid.has_lines {
            for input in &mut *driven {
                input.apply(plant, next)?;
            }
        }
        if (index + 1) % grid.every == 0 || index + 1 == grid.count {
            rows.read(plant, grid.rows(), reached.rows);
            reached.count(plant);
            reached.rows += 1;
        }
    }
    Ok(())
}
