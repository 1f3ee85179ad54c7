//! The description in the words of FMI 2.0.

mod structure;
mod variables;

use std::io;

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Enumeration, Role, Variable};
use pneumatic_servo_ssp::xml::{Element, Xml};

use super::structure::Structure;
use super::{Attribute, Stamp, default_experiment, enumerations, is_exchanged, kind, log_categories, root, units};

/// Writes the whole.
pub fn write(
    xml: &mut Xml,
    model: &Model,
    variables: &[Variable],
    stamp: &Stamp,
    structure: &Structure,
) -> io::Result<()> {
    let indicators = is_exchanged(model).then(|| model.indicators().len().to_string());
    root("2.0", "guid", model, stamp).with_some("numberOfEventIndicators", indicators).contain(xml, |xml| {
        if is_exchanged(model) {
            with_sources(xml, kind("ModelExchange", model, COMMON, MODEL_EXCHANGE), &stamp.sources)?;
        }
        with_sources(xml, kind("CoSimulation", model, COMMON, CO_SIMULATION), &stamp.sources)?;
        units::write(xml, variables)?;
        enumerations::write(xml, variables, write_type)?;
        log_categories(xml)?;
        default_experiment(xml, model)?;
        match variables.iter().position(|variable| variable.role == Role::Time) {
            // FMI 2.0 does not ask for the independent variable, and one of the name `time` hides Modelica's own in the block
            // that OpenModelica makes around an FMU.
            Some(time) => {
                variables::write(xml, &[&variables[..time], &variables[time + 1..]].concat())?;
                structure::write(xml, &structure.without(time + 1))
            }
            None => {
                variables::write(xml, variables)?;
                structure::write(xml, structure)
            }
        }
    })
}

/// Writes a way of running the model, and the source files for it.
fn with_sources(xml: &mut Xml, element: Element, sources: &[String]) -> io::Result<()> {
    if sources.is_empty() {
        return element.write(xml);
    }
    element.contain(xml, |xml| {
        Element::new("SourceFiles")
            .contain(xml, |xml| sources.iter().try_for_each(|file| Element::new("File").with("name", file).write(xml)))
    })
}

const COMMON: &[Attribute] = &[
    ("needsExecutionTool", "false"),
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canNotUseMemoryManagementFunctions", "false"),
    ("canGetAndSetFMUstate", "true"),
    ("canSerializeFMUstate", "true"),
    ("providesDirectionalDerivative", "true"),
];
const MODEL_EXCHANGE: &[Attribute] = &[("completedIntegratorStepNotNeeded", "false")];
const CO_SIMULATION: &[Attribute] = &[
    ("canHandleVariableCommunicationStepSize", "true"),
    ("canInterpolateInputs", "true"),
    ("maxOutputDerivativeOrder", "1"),
    ("canRunAsynchronuously", "false"),
];

fn write_type(xml: &mut Xml, enumeration: &Enumeration) -> io::Result<()> {
    Element::new("SimpleType")
        .with("name", enumeration.name)
        .with("description", enumeration.description)
        .contain(xml, |xml| Element::new("Enumeration").contain(xml, |xml| enumerations::items(xml, enumeration)))
}
