//! Values as Python programs write them.

use pneumatic_servo::model::{SettingError, Setup, Value};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString};

use crate::failure::{refused, refused_setting};

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
#[derive(Clone)]
pub struct Setting {
    /// The name.
    pub name: String,
    /// The value.
    pub given: Given,
}

impl<'a, 'py> FromPyObject<'a, 'py> for Setting {
    type Error = PyErr;

    /// Takes a pair of name and value.
    fn extract(pair: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let (name, value): (Bound<'py, PyAny>, Bound<'py, PyAny>) = pair.extract()?;
        let Ok(name) = name.extract::<String>() else {
            return Err(refused(format!("{} is no name of a variable", name.repr()?)));
        };
        let given = Given::of(&name, &value)?;
        Ok(Self { name, given })
    }
}

impl Setting {
    /// The value of a variable that is set by numbers only.
    pub fn number(&self) -> PyResult<f64> {
        match &self.given {
            Given::Number(value) if value.is_finite() => Ok(*value),
            other => Err(refused(format!("{} = {} is refused: it must be a finite number", self.name, other.value()))),
        }
    }
}

impl Given {
    /// The value of a variable, whose name stands in the message if it is none.
    pub fn of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        if value.is_instance_of::<PyString>() {
            return Ok(Self::Item(value.extract()?));
        }
        // NumPy's true and false are no bool of Python, but numbers to it they are no more than those.
        if value.is_instance_of::<PyBool>() || value.get_type().name()?.to_str()?.starts_with("bool") {
            return Ok(Self::Flag(value.is_truthy()?));
        }
        value.extract().map(Self::Number).map_err(|_| {
            refused(format!("{name} = {value} is refused: it must be a single number, a text, true or false"))
        })
    }

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
    settings.iter().try_for_each(|setting| setup.change(&setting.name, setting.given.value()))
}

/// A model with settings applied.
pub fn setup(model: &'static pneumatic_servo::model::Model, settings: &[Setting]) -> PyResult<Setup> {
    let mut setup = Setup::new(model);
    apply(&mut setup, settings).map_err(refused_setting)?;
    Ok(setup)
}

/// The size of a step in s, from a number or one with its unit.
///
/// # Errors
/// `ValueError` or `TypeError` if it is neither.
pub fn seconds(size: &Bound<'_, PyAny>) -> PyResult<f64> {
    match size.extract() {
        Ok(size) => Ok(size),
        Err(_) => size.py().import("pneumatic_servo.values")?.call_method1("seconds", ("size", size))?.extract(),
    }
}
