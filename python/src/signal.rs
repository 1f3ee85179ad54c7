//! Inputs over time, as the host of an FMU applies them: each value is taken at a communication point and held over
//! the step that begins there.

use pyo3::prelude::*;

use crate::failure::refused;

/// An input over time.
#[derive(Clone, Copy)]
pub enum Signal<'a> {
    /// The same value all the time.
    Constant(f64),
    /// Straight lines between points, the end values beyond them; of points at the same time the last counts.
    Table {
        /// Times in s, not empty, never falling.
        times: &'a [f64],
        /// As many values.
        values: &'a [f64],
    },
    /// A function of time in Python.
    Function(&'a Py<PyAny>),
}

/// Reads a signal at times that do not fall.
pub struct Reader<'a> {
    /// Of the input.
    name: &'a str,
    signal: Signal<'a>,
    /// Index of the first point of the table that is later than the last time asked for.
    next: usize,
}

impl<'a> Reader<'a> {
    /// Reads the signal of an input from the beginning.
    pub fn new(name: &'a str, signal: Signal<'a>) -> Self {
        Self { name, signal, next: 0 }
    }

    /// The value at a time in s.
    pub fn at(&mut self, time: f64) -> PyResult<f64> {
        match self.signal {
            Signal::Constant(value) => Ok(value),
            Signal::Table { times, values } => Ok(self.between(time, times, values)),
            Signal::Function(function) => Python::attach(|py| {
                let value = function.call1(py, (time,))?;
                value.extract(py).map_err(|_| {
                    refused(format!("at t = {time} s {} = {value} is refused: it must be a number", self.name))
                })
            }),
        }
    }

    fn between(&mut self, time: f64, times: &[f64], values: &[f64]) -> f64 {
        while times.get(self.next).is_some_and(|point| *point <= time) {
            self.next += 1;
        }
        let Some(last) = self.next.checked_sub(1) else { return values[0] };
        if last + 1 == times.len() || times[last] == time {
            return values[last];
        }
        let share = (time - times[last]) / (times[last + 1] - times[last]);
        values[last] + share * (values[last + 1] - values[last])
    }
}
