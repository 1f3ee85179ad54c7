//! `ModelVariables`: one `ScalarVariable` per row of the table, in its order.

use std::io;

use pneumatic_servo::variables::{Kind, Role, Variable};

use super::structure::index_of;
use crate::xml::{Element, Xml, real};

/// Writes the section.
pub fn write(xml: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    Element::new("ModelVariables")
        .contain(xml, |xml| variables.iter().try_for_each(|variable| write_variable(xml, variables, variable)))
}

fn write_variable(xml: &mut Xml, variables: &[Variable], variable: &Variable) -> io::Result<()> {
    let (causality, variability, initial) = attributes(variable);
    Element::new("ScalarVariable")
        .with("name", &variable.name)
        .with("valueReference", &variable.reference.to_string())
        .with_some("description", Some(&variable.description).filter(|text| !text.is_empty()))
        .with("causality", causality)
        .with("variability", variability)
        .with_some("initial", initial)
        .contain(xml, |xml| value(variables, variable).write(xml))
}

/// Causality, variability and initial. The time and inputs must not have the last; FMI fixes it for them.
fn attributes(variable: &Variable) -> (&'static str, &'static str, Option<&'static str>) {
    let varies = if matches!(variable.kind, Kind::Real(_)) { "continuous" } else { "discrete" };
    match variable.role {
        Role::Time => ("independent", "continuous", None),
        Role::Input => ("input", varies, None),
        Role::Fixed => ("parameter", "fixed", Some("exact")),
        Role::Tunable => ("parameter", "tunable", Some("exact")),
        Role::Output => ("output", varies, Some("calculated")),
        Role::Local => ("local", varies, Some("calculated")),
    }
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

/// Whether the variable is a continuous state. Events may set any of them.
fn is_state(variables: &[Variable], variable: &Variable) -> bool {
    variables.iter().any(|other| other.derivative_of == Some(variable.reference))
}

/// The index of the state of which the variable is the time derivative.
fn derivative(variables: &[Variable], variable: &Variable) -> Option<String> {
    let state = variable.derivative_of?;
    index_of(variables, state).map(|index| index.to_string())
}

/// An integer as text.
fn whole(value: f64) -> String {
    format!("{value:.0}")
}
