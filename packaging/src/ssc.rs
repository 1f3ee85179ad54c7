//! What all files of the standard SSP 1.0 share: namespaces, the name of the tool, units.

use std::io;

use pneumatic_servo::variables::Unit;

use crate::units;
use crate::xml::{Element, Xml};

/// Namespace of what the files of SSP share.
pub const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
/// Namespace of parameter values.
pub const PARAMETER_VALUES: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
/// What the files say they were made by.
pub const TOOL: &str = concat!("pneumatic-servo-fmu ", env!("CARGO_PKG_VERSION"));

/// Writes a section of units, unless there is nothing in it.
pub fn write_units(xml: &mut Xml, section: &'static str, units: &[Unit]) -> io::Result<()> {
    if units.is_empty() {
        return Ok(());
    }
    Element::new(section).contain(xml, |xml| {
        units.iter().try_for_each(|unit| {
            Element::new("ssc:Unit")
                .with("name", unit.name)
                .contain(xml, |xml| units::base_unit("ssc:BaseUnit", unit.base).write(xml))
        })
    })
}
