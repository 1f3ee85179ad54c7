//! `UnitDefinitions`: the units that the table uses, in terms of the SI base units.

use std::io;

use pneumatic_servo::variables::{BaseUnit, Kind, Unit, Variable};

use super::xml::{Element, Xml};

const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// Writes the section.
pub fn write(xml: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    Element::new("UnitDefinitions")
        .contain(xml, |xml| used(variables).into_iter().try_for_each(|unit| write_unit(xml, unit)))
}

/// Each unit once, in the order in which the table first uses it.
fn used(variables: &[Variable]) -> Vec<Unit> {
    let mut units: Vec<Unit> = Vec::new();
    for variable in variables {
        if let Kind::Real(unit) = variable.kind
            && !units.iter().any(|known| known.name == unit.name)
        {
            units.push(unit);
        }
    }
    units
}

fn write_unit(xml: &mut Xml, unit: Unit) -> io::Result<()> {
    Element::new("Unit").with("name", unit.name).contain(xml, |xml| {
        base_unit(unit.base).write(xml)?;
        unit.display.iter().try_for_each(|display| {
            let offset = (display.offset != 0.0).then(|| super::xml::real(display.offset));
            Element::new("DisplayUnit")
                .with("name", display.name)
                .with_number("factor", display.factor)
                .with_some("offset", offset)
                .write(xml)
        })
    })
}

fn base_unit(exponents: BaseUnit) -> Element {
    BASE.iter()
        .zip(exponents)
        .filter(|(_, exponent)| *exponent != 0)
        .fold(Element::new("BaseUnit"), |element, (name, exponent)| element.with(name, &exponent.to_string()))
}
