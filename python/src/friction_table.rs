//! Measured friction as parameters of the law `Table`.

use numpy::PyReadonlyArray1;
use pneumatic_servo_fit::friction_table::{columns, settings};
use pyo3::prelude::*;

use crate::failure::refused;

/// The places of velocity and force among the columns of a table.
#[pyfunction]
pub fn friction_columns(table: &str, names: Vec<String>) -> PyResult<(usize, usize)> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    columns(table, &names).map(|[velocity, force]| (velocity, force)).map_err(refused)
}

/// Parameters by name; a file with the lines of its rows begins the message about one of them.
#[pyfunction]
#[pyo3(signature = (velocity, force, origin = None))]
pub fn friction_table(
    velocity: PyReadonlyArray1<'_, f64>,
    force: PyReadonlyArray1<'_, f64>,
    origin: Option<(String, PyReadonlyArray1<'_, i64>)>,
) -> PyResult<Vec<(String, f64)>> {
    let (velocity, force) = (velocity.as_array().to_vec(), force.as_array().to_vec());
    let place = |row: usize| {
        origin.as_ref().map_or(String::new(), |(file, lines)| format!("{file}:{}: ", lines.as_array()[row]))
    };
    settings(&velocity, &force, &place).map_err(refused)
}
