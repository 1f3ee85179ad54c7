//! Tables in text files.

use std::collections::{BTreeMap, BTreeSet};

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pneumatic_servo_fit::signals::{Chosen, proposed};
use pneumatic_servo_fit::tables::{Table, clock, names, read};
use pneumatic_servo_fit::units;
use pyo3::prelude::*;

use crate::failure::refused;

/// Columns of a table.
type Columns<'py> = Vec<Bound<'py, PyArray1<f64>>>;

/// Names as written and without units, units, a column in each row, lines, the line of the names, faults, clocks and gaps by place.
type Read<'py> = (
    Vec<String>,
    Vec<String>,
    Vec<Option<String>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i64>>,
    usize,
    BTreeMap<usize, String>,
    BTreeMap<usize, usize>,
    BTreeSet<usize>,
);

/// File, names, units, values with a row for each row, lines, the line of the names, faults, clocks and gaps.
type Given<'py> = (
    String,
    Vec<String>,
    Vec<Option<String>>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, i64>,
    usize,
    BTreeMap<usize, String>,
    BTreeMap<usize, usize>,
    BTreeSet<usize>,
);

/// The table in the bytes of a file.
#[pyfunction]
pub fn read_table<'py>(py: Python<'py>, file: &str, data: &[u8]) -> PyResult<Read<'py>> {
    let table = py.detach(|| read(file, data)).map_err(refused)?;
    let shape = (table.columns.len(), table.lines.len());
    let columns = Array2::from_shape_vec(shape, table.columns.concat()).expect("a value for each row of a column");
    Ok((
        table.header,
        table.names,
        table.units,
        columns.into_pyarray(py),
        table.lines.into_pyarray(py),
        table.first,
        table.faults,
        table.clocks,
        table.gaps,
    ))
}

/// The names in a header without the units behind them, and the units.
#[pyfunction]
pub fn names_and_units(header: Vec<String>) -> (Vec<String>, Vec<Option<String>>) {
    let of = |text: &String| {
        let (name, unit) = names::name_and_unit(text);
        (name.to_owned(), unit.map(str::to_owned))
    };
    header.iter().map(of).unzip()
}

/// Whether a text is a time of the clock.
#[pyfunction]
pub fn is_clock(text: &str) -> bool {
    clock::is_clock(text)
}

/// Seconds of times of the clock since the first of them; nothing if some text is none.
#[pyfunction]
pub fn seconds_since_first(texts: Vec<String>) -> PyResult<Option<Vec<f64>>> {
    clock::seconds_since_first(texts.iter().map(String::as_str)).map_err(refused)
}

/// Signals by usual names of columns, with the places of these and the units that are written.
#[pyfunction]
pub fn proposed_columns(
    names: Vec<String>,
    units: Vec<Option<String>>,
    signals: Vec<String>,
) -> Vec<(String, usize, Option<String>)> {
    let signals: Vec<&str> = signals.iter().map(String::as_str).collect();
    proposed(&names, &units, &signals).into_iter().map(|one| (one.signal, one.place, one.unit)).collect()
}

/// Values in an SI unit, by factor and offset.
#[pyfunction]
pub fn scaled<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    factor: f64,
    offset: f64,
) -> Bound<'py, PyArray1<f64>> {
    units::scaled(&values.as_array().to_vec(), (factor, offset)).into_pyarray(py)
}

/// Chosen columns of a table in SI units on one clock, and those that were read at other times; row by row where none is the time.
///
/// A chosen column is signal, place, unit, SI unit, and whether it is turned.
#[pyfunction]
pub fn table_signals<'py>(
    py: Python<'py>,
    table: Given<'py>,
    chosen: Vec<(String, usize, String, String, bool)>,
) -> PyResult<(Columns<'py>, Vec<String>)> {
    let (file, names, units, values, lines, first, faults, clocks, gaps) = table;
    let columns = values.as_array().columns().into_iter().map(|column| column.to_vec()).collect();
    let lines = lines.as_array().to_vec();
    let table = Table { header: names.clone(), names, units, columns, lines, first, faults, clocks, gaps };
    let of = |(signal, place, unit, si, is_turned)| Chosen { signal, place, unit, si, is_turned };
    let chosen: Vec<Chosen> = chosen.into_iter().map(of).collect();
    let found = table.signals(&file, &chosen).map_err(refused)?;
    Ok((found.samples.into_iter().map(|values| values.into_pyarray(py)).collect(), found.others))
}
