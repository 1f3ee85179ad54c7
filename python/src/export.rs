//! Configured machines as FMUs, in the words of the crate that rewrites FMUs.

use std::borrow::Cow;
use std::collections::BTreeMap;

use pneumatic_servo_export::{Experiment, Interface, Machine, Preset, export};
use pyo3::prelude::*;

use crate::failure::refused;
use crate::own;
use crate::value::{Given, Setting};

/// The bytes of an FMU of a configured machine, and files for other tools by name.
///
/// `kept`: inputs, outputs and parameters by name; `experiment`: start, stop, step in s, tolerance.
#[pyfunction]
#[allow(clippy::type_complexity, clippy::too_many_arguments, reason = "the arguments of the function in Python")]
pub fn export_fmu(
    py: Python<'_>,
    source: &[u8],
    name: String,
    settings: Vec<Setting>,
    preset: &str,
    kept: (Option<Vec<String>>, Option<Vec<String>>, Option<Vec<String>>),
    experiment: (Option<f64>, Option<f64>, Option<f64>, Option<f64>),
    sections: String,
) -> PyResult<(Cow<'static, [u8]>, BTreeMap<String, String>)> {
    let ((inputs, outputs, parameters), (start, stop, step, tolerance)) = (kept, experiment);
    let machine = Machine {
        name,
        values: values(settings),
        interface: Interface { preset: Preset::named(preset).map_err(refused)?, inputs, outputs, parameters },
        experiment: Experiment { start, stop, step, tolerance },
        sections,
    };
    let models: Vec<_> = own::all().collect();
    let found = py.detach(|| export(source, &models, &machine)).map_err(refused)?;
    Ok((found.fmu.into(), found.beside))
}

/// The bytes of an SSP of configured machines; names of settings begin with the component.
#[pyfunction]
pub fn export_system(
    py: Python<'_>,
    source: &[u8],
    name: &str,
    settings: Vec<Setting>,
) -> PyResult<Cow<'static, [u8]>> {
    let (models, values): (Vec<_>, _) = (own::all().collect(), values(settings));
    let found = py.detach(|| pneumatic_servo_export::export_system(source, &models, name, &values));
    Ok(found.map_err(refused)?.into())
}

fn values(settings: Vec<Setting>) -> BTreeMap<String, pneumatic_servo_variant::Given> {
    let value = |Setting { name, given }| {
        let given = match given {
            Given::Number(number) => pneumatic_servo_variant::Given::Number(number),
            Given::Flag(flag) => pneumatic_servo_variant::Given::Flag(flag),
            Given::Item(item) => pneumatic_servo_variant::Given::Item(item),
        };
        (name, given)
    };
    settings.into_iter().map(value).collect()
}
