//! The units of variables, in terms of the SI base units: what FMI and SSP write alike.

use pneumatic_servo::variables::{BaseUnit, Kind, Unit, Variable};

use crate::xml::Element;

const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

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

/// The exponents of the SI base units, as an element of FMI or of SSP.
pub fn base_unit(name: &'static str, exponents: BaseUnit) -> Element {
    BASE.iter()
        .zip(exponents)
        .filter(|(_, exponent)| *exponent != 0)
        .fold(Element::new(name), |element, (base, exponent)| element.with(base, &exponent.to_string()))
}
