//! The plant as an extension module of Python, `pneumatic_servo._native`.
//!
//! It knows variable tables and runs, no physics; what users see, with units and shapes, is the Python package around
//! it. The interpreter's lock is released while plants run.

mod abreast;
mod failure;
mod fleet;
mod gradient;
mod many;
mod model;
mod recording;
mod signal;
mod simulation;
mod single;
mod slopes;
mod ssv;
mod threads;
mod transition;
mod value;
mod watch;

#[pyo3::pymodule]
mod _native {
    use numpy::PyArray1;
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::abreast::transitions;
    #[pymodule_export]
    use crate::fleet::Fleet;
    #[pymodule_export]
    use crate::gradient::{gradient, tangent};
    #[pymodule_export]
    use crate::many::simulate_many;
    #[pymodule_export]
    use crate::model::{Model, models};
    #[pymodule_export]
    use crate::simulation::{SavedState, Simulation};
    #[pymodule_export]
    use crate::single::simulate;
    #[pymodule_export]
    use crate::ssv::ssv;

    /// NumPy's interface is loaded with the first array: here, where an interrupt meets nothing but an import.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.py().import("numpy")?;
        PyArray1::<f64>::zeros(module.py(), 0, false);
        Ok(())
    }
}
