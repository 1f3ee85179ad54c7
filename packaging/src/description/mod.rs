//! `modelDescription.xml`, made from the variable table.

mod structure;
mod types;
mod units;
mod variables;

use std::io;

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo_fmu::fmi2;
use quick_xml::events::{BytesDecl, Event};

pub use self::types::used as enumerations;
use crate::xml::{Element, Xml};

/// What changes from build to build.
pub struct Stamp {
    /// Identifies the description and the library that belongs to it.
    pub guid: String,
    /// When it was generated, in ISO 8601.
    pub date: String,
}

/// The description of a model.
///
/// # Errors
/// When a variable refers to one that the table does not have.
pub fn xml(model: &Model, stamp: &Stamp) -> Result<String> {
    let variables = (model.variables)();
    let structure = structure::Structure::new(variables).with_context(|| format!("the table of {}", model.name))?;
    let mut xml = Xml::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    root(model, stamp).contain(&mut xml, |xml| {
        model_exchange(xml, model)?;
        co_simulation(xml, model)?;
        units::write(xml, variables)?;
        types::write(xml, variables)?;
        log_categories(xml)?;
        default_experiment(xml, model)?;
        variables::write(xml, variables)?;
        structure.write(xml)
    })?;
    let mut text = String::from_utf8(xml.into_inner()).context("the description is not UTF-8")?;
    text.push('\n');
    Ok(text)
}

fn root(model: &Model, stamp: &Stamp) -> Element {
    Element::new("fmiModelDescription")
        .with("fmiVersion", "2.0")
        .with("modelName", model.name)
        .with("guid", &stamp.guid)
        .with("description", model.description)
        .with("version", env!("CARGO_PKG_VERSION"))
        .with("license", env!("CARGO_PKG_LICENSE"))
        .with("generationTool", concat!("pneumatic-servo-fmu ", env!("CARGO_PKG_VERSION")))
        .with("generationDateAndTime", &stamp.date)
        .with("variableNamingConvention", "structured")
        .with_some("numberOfEventIndicators", is_exchanged(model).then(|| (model.indicators)().len().to_string()))
}

/// Whether there is anything to exchange: a model without continuous states needs no solver.
fn is_exchanged(model: &Model) -> bool {
    (model.variables)().number_of_states() > 0
}

fn model_exchange(xml: &mut Xml, model: &Model) -> io::Result<()> {
    if !is_exchanged(model) {
        return Ok(());
    }
    Element::new("ModelExchange")
        .with("modelIdentifier", model.name)
        .with("needsExecutionTool", "false")
        .with("completedIntegratorStepNotNeeded", "false")
        .with("canBeInstantiatedOnlyOncePerProcess", "false")
        .with("canNotUseMemoryManagementFunctions", "false")
        .with("canGetAndSetFMUstate", "true")
        .with("canSerializeFMUstate", "true")
        .with("providesDirectionalDerivative", "true")
        .write(xml)
}

fn co_simulation(xml: &mut Xml, model: &Model) -> io::Result<()> {
    Element::new("CoSimulation")
        .with("modelIdentifier", model.name)
        .with("needsExecutionTool", "false")
        .with("canHandleVariableCommunicationStepSize", "true")
        .with("canInterpolateInputs", "true")
        .with("maxOutputDerivativeOrder", "1")
        .with("canRunAsynchronuously", "false")
        .with("canBeInstantiatedOnlyOncePerProcess", "false")
        .with("canNotUseMemoryManagementFunctions", "false")
        .with("canGetAndSetFMUstate", "true")
        .with("canSerializeFMUstate", "true")
        .with("providesDirectionalDerivative", "true")
        .write(xml)
}

fn log_categories(xml: &mut Xml) -> io::Result<()> {
    Element::new("LogCategories").contain(xml, |xml| {
        fmi2::LOG_CATEGORIES.iter().try_for_each(|category| {
            Element::new("Category").with("name", category.name).with("description", category.description).write(xml)
        })
    })
}

fn default_experiment(xml: &mut Xml, model: &Model) -> io::Result<()> {
    Element::new("DefaultExperiment")
        .with("startTime", "0")
        .with_number("stopTime", model.experiment.stop_time)
        .with_number("tolerance", TOLERANCE)
        .with_number("stepSize", model.experiment.step_size)
        .write(xml)
}

/// The default of `solver.relativeTolerance`.
const TOLERANCE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use pneumatic_servo::models;

    /// Viewers show structured names as a tree, in which a variable cannot be a branch too.
    #[test]
    fn no_variable_has_the_name_of_a_group() {
        for model in models::ALL {
            let names: BTreeSet<&str> = (model.variables)().iter().map(|variable| variable.name.as_str()).collect();
            let plain = names.iter().filter(|name| !name.starts_with("der("));
            for group in plain.filter_map(|name| name.rsplit_once('.')).map(|(group, _)| group) {
                assert!(!names.contains(group), "{}: {group} is a variable and a group", model.name);
            }
        }
    }
}
