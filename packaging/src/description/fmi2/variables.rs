//! `ModelVariables`: one `ScalarVariable` per row of the table, in its order.

use std::io;

use pneumatic_servo::variables::{Kind, Variable};
use pneumatic_servo_ssp::xml::{Element, Xml, real};

use crate::description::structure::index_of;
use crate::description::variability::{describe, is_state, whole};

/// Writes the section.
pub fn write(xml: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    Element::new("ModelVariables")
        .contain(xml, |xml| variables.iter().try_for_each(|variable| write_variable(xml, variables, variable)))
}

fn write_variable(xml: &mut Xml, variables: &[Variable], variable: &Variable) -> io::Result<()> {
    describe(Element::new("ScalarVariable"), &variable.name, &variable.description, variable)
        .contain(xml, |xml| value(variables, variable).write(xml))
}

/// The element that says the type, with the attributes that belong to it.
fn value(variables: &[Variable], variable: &Variable) -> Element {
    match variable.kind {
        Kind::Real(unit) => Element::new("Real")
            .with("unit", unit.name)
            .with_some("displayUnit", variable.display)
            .with_some("min", variable.min.map(real))
            .with_some("max", variable.max.map(real))
            .with_some("nominal", variable.nominal.map(real))
            .with_some("start", variable.start.map(real))
            .with_some("derivative", derivative(variables, variable))
            .with_some("reinit", is_state(variables, variable).then_some("true")),
        Kind::Integer => Element::new("Integer")
            .with_some("min", variable.min.map(whole))
            .with_some("max", variable.max.map(whole))
            .with_some("start", variable.start.map(whole)),
        Kind::Boolean => {
            Element::new("Boolean").with_some("start", variable.start.map(|value| (value != 0.0).to_string()))
        }
        Kind::Enumeration(of) => {
            Element::new("Enumeration").with("declaredType", of.name).with_some("start", variable.start.map(whole))
        }
    }
}

/// The index of the state of which the variable is the time derivative.
fn derivative(variables: &[Variable], variable: &Variable) -> Option<String> {
    let state = variable.derivative_of?;
    index_of(variables, state).map(|index| index.to_string())
}
