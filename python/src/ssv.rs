//! Settings as SSV, in the words of the crate that writes it for the FMUs.

use pneumatic_servo_ssp::{Parameter, ParameterSet, Version};
use pyo3::prelude::*;

use crate::failure::refused_setting;
use crate::model::Model;
use crate::value::{Setting, setup};

const TOOL: &str = concat!("pneumatic-servo ", env!("CARGO_PKG_VERSION"));

/// Settings of a model, parameters or start values of inputs, described by a text.
#[pyfunction]
pub fn ssv(model: &Model, name: &str, description: &str, settings: Vec<Setting>) -> PyResult<String> {
    // Refuses names that are not there.
    let table = setup(model.model, &settings)?.table();
    let parameters = settings.iter().filter_map(|setting| {
        let variable = table.find(&setting.name)?.variable;
        Some(Parameter::new(&setting.name, variable, setting.given.value()))
    });
    let parameters = parameters.collect::<Result<_, _>>().map_err(refused_setting)?;
    Ok(ParameterSet { version: Version::One, name, description, tool: TOOL, time: None, parameters }.text()?)
}
