//! Models of a user's crate in the Python package.

use std::sync::OnceLock;

use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;

static OWN: OnceLock<&'static [&'static Model]> = OnceLock::new();

/// The user's models, then the models of the library that have other names.
pub fn all() -> impl Iterator<Item = &'static Model> {
    let own = OWN.get().copied().unwrap_or_default();
    let others = models::ALL.iter().filter(|model| own.iter().all(|it| it.name != model.name));
    own.iter().copied().chain(others)
}

/// Makes a crate an extension module of Python, through which the package `pneumatic_servo` has the crate's models.
///
/// ```ignore
/// pneumatic_servo_python::python_module!(my_laws, &[&CYLINDER, &BENCH]);
/// ```
///
/// `import my_laws` before `pneumatic_servo` then replaces models of the library with the same names: everything
/// in the package knows the laws of their catalogue. The crate is a `cdylib` with the name of the module.
#[macro_export]
macro_rules! python_module {
    ($name:ident, $models:expr) => {
        /// The module, as Python loads it.
        #[$crate::pyo3::pymodule]
        #[pyo3(crate = "pneumatic_servo_python::pyo3")]
        fn $name(module: &$crate::pyo3::Bound<'_, $crate::pyo3::types::PyModule>) -> $crate::pyo3::PyResult<()> {
            static MODELS: &[&$crate::Model] = $models;
            $crate::serve(module, MODELS)
        }
    };
}

/// Name of the module that the package takes for its own.
const NATIVE: &str = "pneumatic_servo._native";
/// The environment variable by which child processes know it.
const VARIABLE: &str = "PNEUMATIC_SERVO_MODULE";

/// Fills a module and puts it in the place of the package's own, in this process and those that it starts.
///
/// # Errors
/// `ImportError` when the package has been imported before.
pub fn serve(module: &Bound<'_, PyModule>, own: &'static [&'static Model]) -> PyResult<()> {
    let (py, name) = (module.py(), module.name()?);
    let modules = py.import("sys")?.getattr("modules")?;
    if modules.contains(NATIVE)? {
        return Err(PyImportError::new_err(format!(
            "import {name} before pneumatic_servo, which has its models already"
        )));
    }
    OWN.get_or_init(|| own);
    crate::fill(module)?;
    modules.set_item(NATIVE, module)?;
    py.import("os")?.getattr("environ")?.set_item(VARIABLE, name)
}
