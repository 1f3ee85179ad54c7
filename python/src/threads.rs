//! Threads on which plants run side by side.

use pyo3::PyResult;
use pyo3::exceptions::PyRuntimeError;

/// Threads of this call's own: they end with it, so that a process may fork between calls.
pub fn pool(workers: usize) -> PyResult<rayon::ThreadPool> {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(workers);
    builder.build().map_err(|error| PyRuntimeError::new_err(format!("cannot start {workers} threads: {error}")))
}
