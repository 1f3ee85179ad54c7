//! `UnitDefinitions`: the units that the table uses, in terms of the SI base units.

use std::io;

use pneumatic_servo::variables::{Unit, Variable};
use pneumatic_servo_ssp::units::{base_unit, used};
use pneumatic_servo_ssp::xml::{Element, Xml};

/// Writes the section.
pub fn write<'a>(xml: &mut Xml, variables: impl IntoIterator<Item = &'a Variable>) -> io::Result<()> {
    Element::new("UnitDefinitions")
        .contain(xml, |xml| used(variables).into_iter().try_for_each(|unit| write_unit(xml, unit)))
}

fn write_unit(xml: &mut Xml, unit: Unit) -> io::Result<()> {
    Element::new("Unit").with("name", unit.name).contain(xml, |xml| {
        base_unit("BaseUnit", unit.base).write(xml)?;
        unit.display.iter().try_for_each(|display| {
            let offset = (display.offset != 0.0).then(|| pneumatic_servo_ssp::xml::real(display.offset));
            Element::new("DisplayUnit")
                .with("name", display.name)
                .with_number("factor", display.factor)
                .with_some("offset", offset)
                .write(xml)
        })
    })
}
