//! Communication steps as linear maps.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pneumatic_servo::model::Plant;
use pneumatic_servo::sensitivity::{Transition, TransitionError};
use pyo3::prelude::*;

use crate::failure::{stopped, transition_error};

type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// A column without a derivative: its place, time in s, event and reason.
type Lost = (usize, f64, String, String);
/// Names of states before and behind a step, the matrices A, B, C, D, P, Q, and the columns that are lost.
pub type TransitionParts<'py> = (Vec<String>, Vec<String>, Vec<Matrix<'py>>, Vec<Lost>);

/// What is asked of a step.
pub struct Asked {
    /// Parameters with columns of their own.
    pub parameters: Vec<String>,
    /// Variables whose change at the end is told.
    pub outputs: Vec<String>,
}

impl Asked {
    /// Takes a plant over a step of a size in s, and tells what that does to small changes.
    pub fn of(&self, plant: &mut Plant, size: f64) -> Result<Transition, TransitionError> {
        let [by, of] =
            [&self.parameters, &self.outputs].map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
        plant.transition(size, &by, &of)
    }

    /// A transition of a model with a number of inputs, for Python.
    pub fn tell<'py>(&self, py: Python<'py>, it: Transition, inputs: usize) -> TransitionParts<'py> {
        let (outputs, parameters) = (self.outputs.len(), self.parameters.len());
        let (states, next) = (it.states.len(), it.next_states.len());
        let matrix = |rows: Vec<Vec<f64>>, shape: (usize, usize)| {
            let values = rows.into_iter().flatten().collect();
            Array2::from_shape_vec(shape, values).expect("a number for each row and column").into_pyarray(py)
        };
        let matrices = vec![
            matrix(it.a, (next, states)),
            matrix(it.b, (next, inputs)),
            matrix(it.c, (outputs, states)),
            matrix(it.d, (outputs, inputs)),
            matrix(it.p, (next, parameters)),
            matrix(it.q, (outputs, parameters)),
        ];
        let lost = it.lost.into_iter().map(|(column, lost)| (column, lost.time, lost.event, lost.reason)).collect();
        (it.states, it.next_states, matrices, lost)
    }
}

/// A failure of the plant or simulation of a number.
pub fn transition_error_of(what: &str, index: usize, error: TransitionError) -> PyErr {
    match error {
        TransitionError::Step(error) => stopped(format!("{what} {index}: {error}")),
        other => transition_error(other),
    }
}
