//! The enumerations that the table uses, in the words of both versions of FMI.

use std::io;

use pneumatic_servo::variables::{Enumeration, Kind, Variable};
use pneumatic_servo_ssp::xml::{Element, Xml};

/// Writes the section, unless there is nothing in it.
pub fn write(
    xml: &mut Xml,
    variables: &[Variable],
    write_type: impl Fn(&mut Xml, &Enumeration) -> io::Result<()>,
) -> io::Result<()> {
    let enumerations = used(variables);
    if enumerations.is_empty() {
        return Ok(());
    }
    Element::new("TypeDefinitions")
        .contain(xml, |xml| enumerations.into_iter().try_for_each(|enumeration| write_type(xml, enumeration)))
}

/// Writes the items of an enumeration.
pub fn items(xml: &mut Xml, enumeration: &Enumeration) -> io::Result<()> {
    enumeration.items.iter().try_for_each(|(id, name, description)| {
        Element::new("Item")
            .with("name", name)
            .with("value", &id.to_string())
            .with("description", description)
            .write(xml)
    })
}

/// Each enumeration once, in the order in which the table first uses it.
pub fn used(variables: &[Variable]) -> Vec<&'static Enumeration> {
    let mut enumerations: Vec<&'static Enumeration> = Vec::new();
    for variable in variables {
        if let Kind::Enumeration(of) = variable.kind
            && !enumerations.iter().any(|known| known.name == of.name)
        {
            enumerations.push(of);
        }
    }
    enumerations
}
