//! Looks after a long run from the thread that Python waits in: shows its progress, and stops it on an interrupt.

use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// How often it looks: often enough for a person, too seldom to cost anything.
pub const INTERVAL: Duration = Duration::from_millis(50);

/// Steps between two looks at the clock, which costs a thirtieth of a step.
pub const STEPS_PER_LOOK: usize = 16;

/// A function of Python that is told how much is done, and when it was told last.
pub struct Watch {
    progress: Option<Py<PyAny>>,
    last: Instant,
}

impl Watch {
    /// Watches from now on.
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        Self { progress, last: Instant::now() }
    }

    /// Looks if the interval has passed.
    ///
    /// # Errors
    /// The exception that a signal has raised, or that showing the progress has.
    pub fn look(&mut self, done: usize) -> PyResult<()> {
        if self.last.elapsed() < INTERVAL {
            return Ok(());
        }
        self.last = Instant::now();
        Python::attach(|py| {
            py.check_signals()?;
            self.tell(py, done)
        })
    }

    /// Tells how much is done.
    pub fn tell(&self, py: Python<'_>, done: usize) -> PyResult<()> {
        let Some(progress) = &self.progress else { return Ok(()) };
        progress.call1(py, (done,)).map(|_| ())
    }
}
