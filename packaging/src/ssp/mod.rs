//! `PneumaticServoDrive.ssp`: cylinder and controller, connected and parameterised, as a system of the standard SSP 1.0.

pub mod units;

use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Unit, Variable};
use quick_xml::events::{BytesDecl, Event};

use crate::archive::Archive;
use crate::moment::Moment;
use crate::parameter_sets::{self, ParameterSet};
use crate::xml::{Element, Xml};

/// The name of the system.
pub const NAME: &str = "PneumaticServoDrive";
/// Namespace of what the files of SSP share.
pub const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
/// Namespace of parameter values.
pub const PARAMETER_VALUES: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const DESCRIPTION: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
/// What the files say they were made by.
pub const TOOL: &str = concat!("pneumatic-servo-fmu ", env!("CARGO_PKG_VERSION"));

/// Components: name and model. A host that steps one after the other and exchanges values after each round gives all of
/// them the values of the same instant, in any order.
const COMPONENTS: [(&str, &str); 2] = [("controller", "PositionController"), ("plant", "PneumaticServoCylinder")];

/// Connections as start and end, each `component.variable`, or the name of a connector of the system. Variables that are
/// not connected are no connectors: some hosts set those to 0, which for the supply pressure means none.
const CONNECTIONS: [(&str, &str); 9] = [
    ("referencePosition", "controller.referencePosition"),
    ("externalForce", "plant.externalForce"),
    ("controller.valveVoltage", "plant.valveVoltage"),
    ("plant.position", "controller.position"),
    ("plant.velocity", "controller.velocity"),
    ("plant.position", "position"),
    ("plant.velocity", "velocity"),
    ("plant.frictionForce", "frictionForce"),
    ("controller.valveVoltage", "valveVoltage"),
];

/// The set of parameters that the system has unless a host takes another.
const DEFAULT_SET: &str = "Dry";
/// End in s of the default experiment: that of the reference trajectory.
const STOP_TIME: &str = "8.0";

/// The model behind a component.
pub fn model_of(component: &str) -> Option<&'static Model> {
    let (_, model) = COMPONENTS.iter().find(|(name, _)| *name == component)?;
    models::ALL.iter().find(|candidate| candidate.name == *model)
}

/// Writes the system from the FMUs of a folder into that folder; `sources` has parameter sets and reference.
///
/// # Errors
/// When a file cannot be read or written.
pub fn write(fmus: &Path, sources: &Path, moment: Moment) -> Result<PathBuf> {
    let sets = parameter_sets::of(NAME, sources)?;
    let mut archive = Archive::default();
    archive.add("SystemStructure.ssd", description(Variant::System, &sets, moment)?)?;
    archive.add("Components.ssd", description(Variant::Components, &sets, moment)?)?;
    for (_, model) in COMPONENTS {
        archive.add(&format!("resources/{model}.fmu"), read(&fmus.join(format!("{model}.fmu")))?)?;
    }
    for set in &sets {
        archive.add(&format!("resources/{}.ssv", set.name), set.ssv(moment)?)?;
    }
    archive.add("resources/reference.csv", read(&sources.join("reference.csv"))?)?;
    let file = fmus.join(format!("{NAME}.ssp"));
    archive.write(&file, moment)?;
    Ok(file)
}

fn read(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))
}

/// A connection with what it connects.
struct Connection {
    start: End,
    end: End,
}

/// One end of a connection.
struct End {
    /// Nothing for a connector of the system.
    component: Option<&'static str>,
    connector: &'static str,
    /// Of the component at this end or the other.
    variable: &'static Variable,
}

impl Connection {
    fn all() -> Result<Vec<Self>> {
        CONNECTIONS.iter().map(|(start, end)| Self::between(start, end)).collect()
    }

    fn between(start: &'static str, end: &'static str) -> Result<Self> {
        let split = |name: &'static str| match name.split_once('.') {
            Some((component, connector)) => (Some(component), connector),
            None => (None, name),
        };
        let variable = |(component, connector): (Option<&str>, &str)| {
            let model = model_of(component?)?;
            (model.variables)().iter().find(|variable| variable.name == connector)
        };
        let (from, to) = (split(start), split(end));
        let inner = variable(from).or_else(|| variable(to)).with_context(|| format!("{start} - {end}: no variable"))?;
        let end_of = |(component, connector)| -> Result<End> {
            let variable = match component {
                Some(_) => variable((component, connector)).with_context(|| format!("no variable {connector}"))?,
                None => inner,
            };
            Ok(End { component, connector, variable })
        };
        Ok(Self { start: end_of(from)?, end: end_of(to)? })
    }
}

/// How the system is described.
#[derive(Clone, Copy, PartialEq)]
enum Variant {
    /// With connectors of its own; a set of parameters is bound to it.
    System,
    /// For hosts that know components alone (libcosim, Ecos): without connectors of the system, and with all sets of
    /// parameters bound to the components, of which the host takes one by name.
    Components,
}

/// An SSD file.
fn description(variant: Variant, sets: &[ParameterSet], moment: Moment) -> Result<String> {
    let mut connections = Connection::all()?;
    if variant == Variant::Components {
        connections.retain(|connection| connection.start.component.is_some() && connection.end.component.is_some());
    }
    let ends = || connections.iter().flat_map(|connection| [&connection.start, &connection.end]);
    let mut xml = Xml::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let root = Element::new("ssd:SystemStructureDescription")
        .with("xmlns:ssc", COMMON)
        .with("xmlns:ssd", DESCRIPTION)
        .with("version", "1.0")
        .with("name", NAME)
        .with("description", "Pneumatic servo cylinder with a position controller")
        .with("license", env!("CARGO_PKG_LICENSE"))
        .with("generationTool", TOOL)
        .with("generationDateAndTime", &moment.iso());
    root.contain(&mut xml, |xml| {
        Element::new("ssd:System").with("name", NAME).contain(xml, |xml| {
            if variant == Variant::System {
                connectors(xml, &connections, None)?;
                Element::new("ssd:ParameterBindings").contain(xml, |xml| {
                    let source = format!("resources/{DEFAULT_SET}.ssv");
                    Element::new("ssd:ParameterBinding").with("source", &source).write(xml)
                })?;
            }
            Element::new("ssd:Elements").contain(xml, |xml| {
                COMPONENTS.iter().enumerate().try_for_each(|(place, (name, model))| {
                    Element::new("ssd:Component")
                        .with("name", name)
                        .with("type", "application/x-fmu-sharedlibrary")
                        .with("source", &format!("resources/{model}.fmu"))
                        .with("implementation", "CoSimulation")
                        .contain(xml, |xml| {
                            connectors(xml, &connections, Some(name))?;
                            geometry(place).write(xml)?;
                            if variant == Variant::Components { bindings(xml, name, sets, moment) } else { Ok(()) }
                        })
                })
            })?;
            Element::new("ssd:Connections")
                .contain(xml, |xml| connections.iter().try_for_each(|connection| connect(xml, connection)))
        })?;
        let used: Vec<Unit> = units::used(ends().map(|end| end.variable));
        units::write(xml, "ssd:Units", &used)?;
        Element::new("ssd:DefaultExperiment").with("startTime", "0.0").with("stopTime", STOP_TIME).write(xml)
    })?;
    Ok(String::from_utf8(xml.into_inner()).context("the system is not UTF-8")? + "\n")
}

/// The connectors of a component or of the system, each once. Where a connection starts within a component there is an
/// output, and where one ends an input; for the system, seen from inside, it is the other way round.
fn connectors(xml: &mut Xml, connections: &[Connection], component: Option<&str>) -> io::Result<()> {
    let (starts, ends) = if component.is_some() { ("output", "input") } else { ("input", "output") };
    let mut known: Vec<&str> = Vec::new();
    Element::new("ssd:Connectors").contain(xml, |xml| {
        let all = connections.iter().flat_map(|connection| [(&connection.start, starts), (&connection.end, ends)]);
        for (end, kind) in all.filter(|(end, _)| end.component == component) {
            if known.contains(&end.connector) {
                continue;
            }
            known.push(end.connector);
            Element::new("ssd:Connector")
                .with("name", end.connector)
                .with("kind", kind)
                .with("description", &end.variable.description)
                .contain(xml, |xml| {
                    let unit = if let Kind::Real(unit) = end.variable.kind { unit.name } else { "1" };
                    Element::new("ssc:Real").with("unit", unit).write(xml)
                })?;
        }
        Ok(())
    })
}

/// The sets with values for a component, written out.
fn bindings(xml: &mut Xml, component: &str, sets: &[ParameterSet], moment: Moment) -> io::Result<()> {
    let prefix = format!("{component}.");
    let mut sets = sets.iter().filter(|set| set.has(&prefix)).peekable();
    if sets.peek().is_none() {
        return Ok(());
    }
    Element::new("ssd:ParameterBindings").contain(xml, |xml| {
        sets.try_for_each(|set| {
            Element::new("ssd:ParameterBinding").contain(xml, |xml| {
                Element::new("ssd:ParameterValues").contain(xml, |xml| set.write(xml, &prefix, moment))
            })
        })
    })
}

/// Side by side.
fn geometry(place: usize) -> Element {
    let left = 20.0 + 60.0 * place as f64;
    Element::new("ssd:ElementGeometry")
        .with_number("x1", left)
        .with_number("y1", 20.0)
        .with_number("x2", left + 40.0)
        .with_number("y2", 60.0)
}

fn connect(xml: &mut Xml, connection: &Connection) -> io::Result<()> {
    Element::new("ssd:Connection")
        .with_some("startElement", connection.start.component)
        .with("startConnector", connection.start.connector)
        .with_some("endElement", connection.end.component)
        .with("endConnector", connection.end.connector)
        .write(xml)
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::variables::Role;

    use super::*;

    #[test]
    fn connections_lead_from_outputs_to_inputs_of_the_same_unit() -> Result<()> {
        for Connection { start, end } in Connection::all()? {
            assert!(start.component.is_none() || start.variable.role == Role::Output, "{}", start.connector);
            assert!(end.component.is_none() || end.variable.role == Role::Input, "{}", end.connector);
            assert!(matches!(start.variable.kind, Kind::Real(_)), "{}", start.connector);
            assert_eq!(start.variable.kind, end.variable.kind, "{} - {}", start.connector, end.connector);
        }
        Ok(())
    }

    #[test]
    fn every_input_is_connected_once() -> Result<()> {
        let connections = Connection::all()?;
        for Connection { end, .. } in &connections {
            let same =
                |other: &&Connection| (other.end.component, other.end.connector) == (end.component, end.connector);
            assert_eq!(connections.iter().filter(same).count(), 1, "{}", end.connector);
        }
        Ok(())
    }

    #[test]
    fn the_default_set_is_one_of_the_sets_and_the_reference_ends_with_the_experiment() -> Result<()> {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
        assert!(parameter_sets::of(NAME, &sources)?.iter().any(|set| set.name == DEFAULT_SET));
        let reference = std::fs::read_to_string(sources.join("reference.csv"))?;
        let last = reference.lines().last().and_then(|line| line.split(',').next()).context("an empty reference")?;
        assert_eq!(last.parse::<f64>()?, STOP_TIME.parse::<f64>()?);
        Ok(())
    }
}
