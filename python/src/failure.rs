//! Failures of the plant as exceptions of Python.

use std::fmt::Display;

use pneumatic_servo::model::SettingError;
use pneumatic_servo::sensitivity::{NoDerivative, TransitionError};
use pneumatic_servo::variables::ParameterError;
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::{PyErr, PyResult};

mod exceptions {
    pyo3::import_exception!(pneumatic_servo.errors, NoDerivative);
}
pyo3::import_exception!(pneumatic_servo.errors, Refused);
pyo3::import_exception!(pneumatic_servo.run_errors, SimulationError);

/// A variable or value that cannot be accepted: `ValueError`, with the plant's own words.
pub fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A value of a variable that cannot be accepted: `pneumatic_servo.errors.Refused`, which knows the variable's unit.
pub fn refused_value(error: ParameterError) -> PyErr {
    Refused::new_err((error.variable, error.value, error.reason))
}

/// A value of an input that cannot be accepted at a time in s.
pub fn refused_at(error: ParameterError, time: f64) -> PyErr {
    Refused::new_err((error.variable, error.value, error.reason, time))
}

/// A variable that cannot be set, or not to a value.
pub fn refused_setting(error: SettingError) -> PyErr {
    match error {
        SettingError::Refused(error) => refused_value(error),
        other => refused(other),
    }
}

/// A run that cannot go on: `pneumatic_servo.SimulationError`.
pub fn stopped(error: impl Display) -> PyErr {
    SimulationError::new_err(error.to_string())
}

/// A point beyond which there is no derivative: `pneumatic_servo.NoDerivative`.
pub fn underivable(error: NoDerivative) -> PyErr {
    exceptions::NoDerivative::new_err((error.time, error.event, error.reason))
}

/// A step that cannot be told as a linear map.
pub fn transition_error(error: TransitionError) -> PyErr {
    match error {
        TransitionError::Direction(error) => refused(error),
        TransitionError::Step(error) => stopped(error),
        TransitionError::NoDerivative(error) => underivable(error),
    }
}

/// Room for values that are not known yet, or `MemoryError`.
pub fn room(outputs: usize, rows: usize, runs: usize) -> PyResult<Vec<f64>> {
    let number = outputs.checked_mul(rows).and_then(|values| values.checked_mul(runs));
    let mut values = Vec::new();
    match number.map(|number| (number, values.try_reserve_exact(number))) {
        Some((number, Ok(()))) => values.resize(number, f64::NAN),
        _ => {
            return Err(PyMemoryError::new_err(format!(
                "{outputs} outputs in {rows} rows of {runs} runs do not fit into memory: record fewer outputs, or with a larger \
                 `every` fewer rows"
            )));
        }
    }
    Ok(values)
}
