//! `UnitDefinitions`: the units that the table uses, in terms of the SI base units.

use std::io;

use pneumatic_servo::variables::{BaseUnit, Unit, Variable};

use crate::ssp::units::used;
use crate::xml::{Element, Xml};

const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// Writes the section.
pub fn write(xml: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    Element::new("UnitDefinitions")
        .contain(xml, |xml| used(variables).into_iter().try_for_each(|unit| write_unit(xml, unit)))
}

fn write_unit(xml: &mut Xml, unit: Unit) -> io::Result<()> {
    Element::new("Unit").with("name", unit.name).contain(xml, |xml| {
        base_unit("BaseUnit", unit.base).write(xml)?;
        unit.display.iter().try_for_each(|display| {
            let offset = (display.offset != 0.0).then(|| crate::xml::real(display.offset));
            Element::new("DisplayUnit")
                .with("name", display.name)
                .with_number("factor", display.factor)
                .with_some("offset", offset)
                .write(xml)
        })
    })
}

/// The exponents of the SI base units, as the element of FMI or of SSP, which are alike.
pub fn base_unit(name: &'static str, exponents: BaseUnit) -> Element {
    BASE.iter()
        .zip(exponents)
        .filter(|(_, exponent)| *exponent != 0)
        .fold(Element::new(name), |element, (base, exponent)| element.with(base, &exponent.to_string()))
}
