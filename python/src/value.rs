//! Values as Python programs write them.

use pneumatic_servo::model::{SettingError, Setup, Value};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString};

use crate::failure::refused;

/// A number, the name of an item of an enumeration, or true or false.
#[derive(Clone, Debug)]
pub enum Given {
    /// A number, in the SI unit of the variable.
    Number(f64),
    /// The name of an item.
    Item(String),
    /// True or false.
    Flag(bool),
}

/// A variable's name with its value.
pub type Setting = (String, Given);

impl<'a, 'py> FromPyObject<'a, 'py> for Given {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if value.is_instance_of::<PyString>() {
            return Ok(Self::Item(value.extract()?));
        }
        // NumPy's true and false are no bool of Python, but numbers to it they are no more than those.
        if value.is_instance_of::<PyBool>() || value.get_type().name()?.to_str()?.starts_with("bool") {
            return Ok(Self::Flag(value.is_truthy()?));
        }
        let refuse = |_| PyTypeError::new_err(format!("{} is no number, text, true or false", value.as_any()));
        value.extract().map(Self::Number).map_err(refuse)
    }
}

impl Given {
    /// The value as the plant takes it.
    pub fn value(&self) -> Value<'_> {
        match self {
            Self::Number(value) => Value::Number(*value),
            Self::Item(name) => Value::Item(name),
            Self::Flag(flag) => Value::Flag(*flag),
        }
    }
}

/// Applies settings to a setup.
pub fn apply(setup: &mut Setup, settings: &[Setting]) -> Result<(), SettingError> {
    settings.iter().try_for_each(|(name, given)| setup.change(name, given.value()))
}

/// A model with settings applied.
pub fn setup(model: &'static pneumatic_servo::model::Model, settings: &[Setting]) -> PyResult<Setup> {
    let mut setup = Setup::of(model);
    apply(&mut setup, settings).map_err(refused)?;
    Ok(setup)
}
