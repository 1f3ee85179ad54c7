//! Values of variables as SSV, the parameter values of the standard SSP: what is packed into the FMUs, what the Python
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

/// A version of the standard. Both have the same namespaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// SSP 1.0, with the types of FMI 2.0.
    One,
    /// SSP 2.0, with the types of FMI 3.0.
    Two,
}

impl Version {
    /// Its number, as files state it.
    pub fn number(self) -> &'static str {
        self.choose("1.0", "2.0")
    }

    /// One of two notations.
    pub fn choose<T>(self, one: T, two: T) -> T {
        match self {
            Self::One => one,
            Self::Two => two,
        }
    }
}

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
