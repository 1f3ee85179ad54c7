//! The units of a file of SSP.

use std::io;

use pneumatic_servo::variables::{Kind, Unit, Variable};

use crate::description::base_unit;
use crate::xml::{Element, Xml};

/// Each unit once, in the order in which the variables first use it.
pub fn used<'a>(variables: impl IntoIterator<Item = &'a Variable>) -> Vec<Unit> {
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

/// Writes the section, unless there is nothing in it.
pub fn write(xml: &mut Xml, section: &'static str, units: &[Unit]) -> io::Result<()> {
    if units.is_empty() {
        return Ok(());
    }
    Element::new(section).contain(xml, |xml| {
        units.iter().try_for_each(|unit| {
            Element::new("ssc:Unit")
                .with("name", unit.name)
                .contain(xml, |xml| base_unit("ssc:BaseUnit", unit.base).write(xml))
        })
    })
}
