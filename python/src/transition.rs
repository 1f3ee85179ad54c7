//! Communication steps as linear maps.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pneumatic_servo::sensitivity::Transition;
use pyo3::prelude::*;

type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// A column without a derivative: its place, time in s, event and reason.
type Lost = (usize, f64, String, String);
/// Names of states before and behind a step, the matrices A, B, C, D, P, Q, and the columns that are lost.
pub type Told<'py> = (Vec<String>, Vec<String>, Vec<Matrix<'py>>, Vec<Lost>);

/// A transition for Python, with so many inputs, outputs and parameters.
pub fn tell(py: Python<'_>, it: Transition, [inputs, outputs, parameters]: [usize; 3]) -> Told<'_> {
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
