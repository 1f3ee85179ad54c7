//! `ModelVariables`: one element per variable or array of the table, in its order, then the event indicators.

use std::io;

use pneumatic_servo::variables::{Kind, Table, Variable, array_name};
use pneumatic_servo_ssp::xml::{Element, Xml, real};

use crate::description::variability::{describe, is_state, whole};

/// Writes the section.
pub fn write(xml: &mut Xml, table: &Table, variables: &[Variable], indicators: &[Variable]) -> io::Result<()> {
    Element::new("ModelVariables").contain(xml, |xml| {
        let mut rest = variables;
        while !rest.is_empty() {
            let (array, others) = rest.split_at(table.length_at(rest[0].reference).unwrap_or(1));
            write_array(xml, table, array)?;
            rest = others;
        }
        indicators.iter().try_for_each(|indicator| write_array(xml, table, std::slice::from_ref(indicator)))
    })
}

/// Writes a variable, given by its elements.
fn write_array(xml: &mut Xml, variables: &[Variable], elements: &[Variable]) -> io::Result<()> {
    let first = &elements[0];
    let description = first.description.strip_suffix(" (element 1)").unwrap_or(&first.description);
    let starts = |text: &dyn Fn(f64) -> String| {
        let starts: Option<Vec<String>> = elements.iter().map(|element| element.start.map(text)).collect();
        starts.map(|starts| starts.join(" "))
    };
    let element = |kind, name: &str| describe(Element::new(kind), name, description, first);
    let typed = |name: &str| match first.kind {
        Kind::Real(unit) => element("Float64", name)
            .with("unit", unit.name)
            .with_some("displayUnit", first.display)
            .with_some("min", first.min.map(real))
            .with_some("max", first.max.map(real))
            .with_some("nominal", first.nominal.map(real))
            .with_some("start", starts(&real))
            .with_some("derivative", first.derivative_of.map(|state| state.to_string()))
            .with_some("reinit", is_state(variables, first).then_some("true")),
        Kind::Integer => element("Int32", name)
            .with_some("min", first.min.map(whole))
            .with_some("max", first.max.map(whole))
            .with_some("start", starts(&whole)),
        Kind::Boolean => element("Boolean", name).with_some("start", starts(&|value| (value != 0.0).to_string())),
        Kind::Enumeration(of) => {
            element("Enumeration", name).with("declaredType", of.name).with_some("start", starts(&whole))
        }
    };
    match array_name(&first.name).filter(|_| elements.len() > 1) {
        Some(name) => typed(name)
            .contain(xml, |xml| Element::new("Dimension").with("start", &elements.len().to_string()).write(xml)),
        None => typed(&first.name).write(xml),
    }
}
