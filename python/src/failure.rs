//! Failures of the plant as exceptions of Python.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

pyo3::import_exception!(pneumatic_servo.errors, SimulationError);

/// A variable or value that cannot be accepted: `ValueError`, with the plant's own words.
pub fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A run that cannot go on: `pneumatic_servo.SimulationError`.
pub fn stopped(error: impl Display) -> PyErr {
    SimulationError::new_err(error.to_string())
}
