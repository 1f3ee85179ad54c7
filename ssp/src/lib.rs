//! Values of variables as SSV, the parameter values of the standard SSP 1.0: what is packed into the FMUs, what the Python
//! package saves and what the page offers are written here.

mod parameter_set;
pub mod units;
pub mod xml;

use std::io;

use pneumatic_servo::variables::Unit;

pub use parameter_set::{Parameter, ParameterSet};

use xml::{Element, Xml};

/// Namespace of what the files of SSP share.
pub const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
/// Namespace of parameter values.
pub const PARAMETER_VALUES: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";

/// Writes a section of units, unless there is nothing in it.
///
/// # Errors
/// When the text cannot be written.
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
