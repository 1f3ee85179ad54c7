//! One run.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::failure::room;
use crate::model::Model;
use crate::recording::{Driven, Grid, Log, Logged, Noticed, Reached, Rows, places, record};
use crate::signal::Signal;
use crate::slopes::{SlopeParts, Slopes};
use crate::value::{Setting, setup};
use crate::watch::{STEPS_PER_LOOK, Watch};

/// An input as the Python package hands it over.
#[derive(FromPyObject)]
pub enum Course<'py> {
    /// The same value all the time.
    Constant(f64),
    /// Times in s and values.
    Table(PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>),
    /// A function of time.
    Function(Py<PyAny>),
}

impl Course<'_> {
    /// As it is read.
    pub fn signal(&self) -> PyResult<Signal<'_>> {
        Ok(match self {
            Self::Constant(value) => Signal::Constant(*value),
            Self::Table(times, values) => Signal::Table { times: times.as_slice()?, values: values.as_slice()? },
            Self::Function(function) => Signal::Function(function),
        })
    }
}

/// What `simulate` returns: values `[output, row]`, rows recorded, why it stopped early, an exception that ended it, what was
/// noticed, the smallest and largest value of each input, and sensitivities and the log of the solver, if any are asked for.
type Outcome<'py> = (
    Bound<'py, PyArray2<f64>>,
    usize,
    Option<String>,
    Option<PyErr>,
    Vec<Noticed>,
    Vec<(f64, f64)>,
    Option<SlopeParts<'py>>,
    Option<Logged<'py>>,
);

/// Runs a model once. `grid` is start and step in s, number of steps, and steps per row; `sensitivities` names what the outputs
/// are differentiated by; with `lines` inputs run on straight lines from each communication point to the next; `counters`
/// of the solver, and events, are logged if given.
#[expect(clippy::too_many_arguments, reason = "Python's keywords name them")]
#[pyfunction]
#[pyo3(signature = (model, settings, inputs, grid, outputs, sensitivities, progress, lines=false, counters=None))]
pub fn simulate<'py>(
    py: Python<'py>,
    model: &Model,
    settings: Vec<Setting>,
    inputs: Vec<(String, Course<'py>)>,
    grid: (f64, f64, usize, usize),
    outputs: Vec<String>,
    sensitivities: Vec<String>,
    progress: Option<Py<PyAny>>,
    lines: bool,
    counters: Option<Vec<String>>,
) -> PyResult<Outcome<'py>> {
    let grid = Grid { has_lines: lines, ..Grid::from(grid) };
    let setup = setup(model.model, &settings)?;
    let signals = inputs.iter().map(|(name, course)| Ok((name, course.signal()?)));
    let (mut driven, places) = (Driven::all(setup.table(), signals)?, places(setup.table(), &outputs)?);
    let log = counters.map(|counters| Log::new(setup.table(), &counters)).transpose()?;
    let mut slots = room(places.len(), grid.rows(), 1)?;
    let slopes = (!sensitivities.is_empty()).then(|| Slopes::new(sensitivities, places.len(), grid.rows()));
    let mut slopes = slopes.transpose()?;
    let mut reached = Reached { log, ..Reached::default() };
    let mut watch = Watch::new(progress);
    let ended = py.detach(|| {
        let rows = Rows { outputs: &places, slots: &mut slots, slopes: slopes.as_mut() };
        record(setup, &mut driven, grid, rows, &mut reached, |index, _| {
            if index % STEPS_PER_LOOK == 0 {
                watch.look(index)?;
            }
            Ok(true)
        })
    });
    watch.tell(py, if ended.is_ok() { grid.count } else { 0 })?;
    let values = Array2::from_shape_vec((places.len(), grid.rows()), slots).expect("one slot per output and row");
    let noticed = reached.noticed.iter().copied().map(Noticed::from).collect();
    let extremes = driven.iter().map(|input| input.extremes).collect();
    let told = slopes.map(|slopes| slopes.tell(py, places.len()));
    let Reached { rows, failure, log, .. } = reached;
    Ok((values.into_pyarray(py), rows, failure, ended.err(), noticed, extremes, told, log.map(|log| log.tell(py))))
}
