//! The description in the words of FMI 3.0: arrays are variables, event indicators too.

mod structure;
mod variables;

use std::io;

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Enumeration, Variable};
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
    let (table, indicators) = (model.table(), model.indicator_variables());
    root("3.0", "instantiationToken", model, stamp).contain(xml, |xml| {
        if is_exchanged(model) {
            kind("ModelExchange", model, COMMON, MODEL_EXCHANGE).write(xml)?;
        }
        kind("CoSimulation", model, COMMON, CO_SIMULATION).write(xml)?;
        units::write(xml, table.iter().chain(&indicators))?;
        enumerations::write(xml, table, write_type)?;
        log_categories(xml)?;
        default_experiment(xml, model)?;
        variables::write(xml, table, variables, &indicators)?;
        structure::write(xml, structure, table, &indicators)
    })
}

const COMMON: &[Attribute] = &[
    ("needsExecutionTool", "false"),
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canGetAndSetFMUState", "true"),
    ("canSerializeFMUState", "true"),
    ("providesDirectionalDerivatives", "true"),
    ("providesAdjointDerivatives", "true"),
    ("providesPerElementDependencies", "true"),
];
const MODEL_EXCHANGE: &[Attribute] = &[("needsCompletedIntegratorStep", "true")];
const CO_SIMULATION: &[Attribute] = &[
    ("canHandleVariableCommunicationStepSize", "true"),
    ("maxOutputDerivativeOrder", "1"),
    ("mightReturnEarlyFromDoStep", "true"),
    ("hasEventMode", "true"),
];

/// Without a description, which is optional: FMPy 0.3.19 and 0.3.20 cannot read it here, and other tools depend on these releases.
fn write_type(xml: &mut Xml, enumeration: &Enumeration) -> io::Result<()> {
    Element::new("EnumerationType")
        .with("name", enumeration.name)
        .contain(xml, |xml| enumerations::items(xml, enumeration))
}
