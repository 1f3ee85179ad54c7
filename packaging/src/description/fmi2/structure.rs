//! `ModelStructure`: unknowns in three lists, by the index of their variables.

use pneumatic_servo_ssp::xml::{Element, Xml};
use std::io;

use crate::description::structure::{Structure, Unknown};

/// Writes the section.
pub fn write(xml: &mut Xml, structure: &Structure) -> io::Result<()> {
    Element::new("ModelStructure").contain(xml, |xml| {
        list(xml, "Outputs", &structure.outputs)?;
        list(xml, "Derivatives", &structure.derivatives)?;
        list(xml, "InitialUnknowns", &structure.initial_unknowns)
    })
}

/// Writes a list, unless it is empty.
fn list(xml: &mut Xml, name: &'static str, unknowns: &[Unknown]) -> io::Result<()> {
    if unknowns.is_empty() {
        return Ok(());
    }
    Element::new(name).contain(xml, |xml| unknowns.iter().try_for_each(|unknown| element(unknown).write(xml)))
}

fn element(unknown: &Unknown) -> Element {
    let indices: Vec<String> = unknown.dependencies.iter().map(usize::to_string).collect();
    Element::new("Unknown")
        .with("index", &unknown.index.to_string())
        .with("dependencies", &indices.join(" "))
        .with("dependenciesKind", &vec!["dependent"; indices.len()].join(" "))
}
