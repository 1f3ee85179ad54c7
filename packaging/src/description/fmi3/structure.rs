//! `ModelStructure`: unknowns one after the other, by value references; they depend on arrays as a whole.

use std::collections::BTreeSet;
use std::io;

use pneumatic_servo::variables::{Table, Variable};
use pneumatic_servo_ssp::xml::{Element, Xml};

use crate::description::structure::{Structure, Unknown};

/// Writes the section.
pub fn write(xml: &mut Xml, structure: &Structure, table: &Table, indicators: &[Variable]) -> io::Result<()> {
    Element::new("ModelStructure").contain(xml, |xml| {
        list(xml, "Output", &structure.outputs, table)?;
        list(xml, "ContinuousStateDerivative", &structure.derivatives, table)?;
        list(xml, "InitialUnknown", &structure.initial_unknowns, table)?;
        // Without a list of dependencies they may depend on everything, as some law or mode lets them.
        indicators.iter().try_for_each(|indicator| {
            Element::new("EventIndicator").with("valueReference", &indicator.reference.to_string()).write(xml)
        })
    })
}

fn list(xml: &mut Xml, name: &'static str, unknowns: &[Unknown], table: &Table) -> io::Result<()> {
    unknowns.iter().try_for_each(|unknown| {
        let references: Vec<String> = dependencies(unknown, table).iter().map(u32::to_string).collect();
        Element::new(name)
            .with("valueReference", &table[unknown.index - 1].reference.to_string())
            .with("dependencies", &references.join(" "))
            .with("dependenciesKind", &vec!["dependent"; references.len()].join(" "))
            .write(xml)
    })
}

/// Value references of the variables that an unknown depends on; an array for each of its elements.
fn dependencies(unknown: &Unknown, table: &Table) -> BTreeSet<u32> {
    let array_of = |index: &usize| {
        let reference = table[index - 1].reference;
        table.array_at(reference).map_or(reference, |(array, _)| array)
    };
    unknown.dependencies.iter().map(array_of).collect()
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::variables::units;

    use super::*;

    #[test]
    fn what_depends_on_elements_depends_on_their_array() {
        let [first, second] = Variable::parameter(7, "k", units::METRE, 1.0).array([1.0, 2.0]);
        let level = Variable::output(3, "level", units::METRE);
        let table = Table::new(vec![Variable::time(), level, first, second]);
        let unknown = Unknown { index: 2, dependencies: vec![1, 3, 4] };
        assert_eq!(dependencies(&unknown, &table), BTreeSet::from([0, 7]));
    }
}
