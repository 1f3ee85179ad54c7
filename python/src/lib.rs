//! The plant as an extension module of Python, `pneumatic_servo._native`.
//!
//! It knows variable tables and runs, no physics; what users see, with units and shapes, is the Python package around
//! it. The interpreter's lock is released while plants run.
//!
//! [`python_module!`] makes such a module of a user's crate, with its models in place of the library's.

mod abreast;
mod closed_loop;
mod experiment;
mod export;
mod failure;
mod fit;
mod fleet;
mod fmu;
mod friction_table;
mod gradient;
mod many;
mod model;
mod observer;
mod own;
mod recording;
mod signal;
mod simulation;
mod single;
mod slopes;
mod ssv;
mod table;
mod threads;
mod transition;
mod units;
mod value;
mod verdict;
mod watch;

use numpy::PyArray1;
pub use own::serve;
#[doc(hidden)]
pub use pneumatic_servo::model::Model;
#[doc(hidden)]
pub use pyo3;
use pyo3::prelude::*;

/// The module of the Python package.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    fill(module)
}

/// Adds what the Python package uses.
fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // NumPy's interface is loaded with the first array: here, where an interrupt meets nothing but an import.
    module.py().import("numpy")?;
    PyArray1::<f64>::zeros(module.py(), 0, false);
    experiment::fill(module)?;
    fit::fill(module)?;
    module.add_class::<fleet::Fleet>()?;
    module.add_class::<fmu::Fmu>()?;
    module.add_class::<fmu::FmuSimulation>()?;
    module.add_class::<fmu::FmuState>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<observer::Observer>()?;
    module.add_class::<simulation::SavedState>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_function(wrap_pyfunction!(abreast::transitions, module)?)?;
    module.add_function(wrap_pyfunction!(closed_loop::simulate_closed, module)?)?;
    module.add_function(wrap_pyfunction!(export::export_fmu, module)?)?;
    module.add_function(wrap_pyfunction!(export::export_system, module)?)?;
    module.add_function(wrap_pyfunction!(friction_table::friction_columns, module)?)?;
    module.add_function(wrap_pyfunction!(friction_table::friction_table, module)?)?;
    module.add_function(wrap_pyfunction!(gradient::gradient, module)?)?;
    module.add_function(wrap_pyfunction!(gradient::tangent, module)?)?;
    module.add_function(wrap_pyfunction!(many::simulate_many, module)?)?;
    module.add_function(wrap_pyfunction!(model::idle_warning, module)?)?;
    module.add_function(wrap_pyfunction!(model::meant, module)?)?;
    module.add_function(wrap_pyfunction!(model::models, module)?)?;
    module.add_function(wrap_pyfunction!(single::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(ssv::ssv, module)?)?;
    module.add("STANDARD_ATMOSPHERE", pneumatic_servo_fit::units::STANDARD_ATMOSPHERE)?;
    module.add("SIGNALS", pneumatic_servo_fit::record::UNITS.to_vec())?;
    module.add("ROTATING", pneumatic_servo_fit::machine_units::ROTATING.to_vec())?;
    module.add("GAINS", pneumatic_servo_fit::machine_units::GAINS.to_vec())?;
    module.add("COMMANDS", pneumatic_servo_fit::signals::COMMANDS.to_vec())?;
    module.add("ABOVE_AMBIENT", pneumatic_servo_fit::signals::ABOVE_AMBIENT)?;
    module.add("OWN_MODULE", fmu::OWN)?;
    module.add("FAILED", pneumatic_servo_fit::problem::FAILED)?;
    module.add("PRIOR", pneumatic_servo_fit::problem::PRIOR)?;
    module.add("REFINED", pneumatic_servo_fit::search::REFINED)?;
    module.add("STEP", pneumatic_servo_fit::problem::STEP)?;
    module.add("TOLERANCE", pneumatic_servo_fit::problem::TOLERANCE)?;
    module.add_function(wrap_pyfunction!(table::is_clock, module)?)?;
    module.add_function(wrap_pyfunction!(table::names_and_units, module)?)?;
    module.add_function(wrap_pyfunction!(table::proposed_columns, module)?)?;
    module.add_function(wrap_pyfunction!(table::scaled, module)?)?;
    module.add_function(wrap_pyfunction!(table::table_signals, module)?)?;
    module.add_function(wrap_pyfunction!(table::read_table, module)?)?;
    module.add_function(wrap_pyfunction!(table::seconds_since_first, module)?)?;
    module.add_function(wrap_pyfunction!(units::unit_scale, module)?)?;
    module.add_function(wrap_pyfunction!(units::calibrated_reading, module)?)?;
    module.add_function(wrap_pyfunction!(units::si_of, module)?)?;
    module.add_function(wrap_pyfunction!(units::units_of, module)?)?;
    module.add_function(wrap_pyfunction!(verdict::lights, module)?)?;
    module.add_function(wrap_pyfunction!(verdict::prediction_light, module)?)?;
    module.add_function(wrap_pyfunction!(verdict::residual_light, module)?)
}
