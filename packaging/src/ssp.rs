//! `PneumaticServoDrive.ssp`: cylinder and controller, connected and parameterised, as a system of the standard SSP: by
//! SSP 1.0 of the FMUs for FMI 2.0, and by SSP 2.0 of the FMUs for FMI 3.0.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Kind, Unit, Variable};
pub use pneumatic_servo_ssp::Version;
use pneumatic_servo_ssp::xml::{Element, Xml, document};
use pneumatic_servo_ssp::{COMMON, units, write_units};

use crate::archive::Archive;
use crate::description::{self, TOOL};
use crate::files;
use crate::parameter_sets::{self, ParameterSet};
use crate::timestamp::Timestamp;

/// The name of the system.
pub const NAME: &str = "PneumaticServoDrive";
const DESCRIPTION: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
const OMSIMULATOR: &str = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
/// Components: name and model. A host that steps one after the other and exchanges values after each round gives all of
/// them the values of the same instant, in any order.
const COMPONENTS: [(&str, &str); 2] = [("controller", "PositionController"), ("plant", "PneumaticServoCylinder")];

/// Connections as start and end, each `component.variable`, or the name of a connector of the system. Variables that are
/// not connected are no connectors: some hosts set those to 0, which for the supply pressure means none.
const CONNECTIONS: [(&str, &str); 12] = [
    ("referencePosition", "controller.referencePosition"),
    ("externalForce", "plant.externalForce"),
    ("controller.valveVoltage", "plant.valveVoltage"),
    ("plant.position", "controller.position"),
    ("plant.velocity", "controller.velocity"),
    ("plant.position", "position"),
    ("plant.velocity", "velocity"),
    ("plant.frictionForce", "frictionForce"),
    ("plant.chamberA.pressure", "pressureA"),
    ("plant.chamberB.pressure", "pressureB"),
    ("plant.sticking", "sticking"),
    ("controller.valveVoltage", "valveVoltage"),
];

/// The set of parameters that the system has unless a host takes another.
const DEFAULT_SET: &str = "Dry";
/// End in s of the default experiment and of the reference trajectory.
const STOP_TIME: &str = "8.0";

/// The communication step in s that hosts are to take: the sample time of the controller.
const STEP: &str = "0.001";

/// The model behind a component.
fn model_of(component: &str) -> Option<&'static Model> {
    let (_, model) = COMPONENTS.iter().find(|(name, _)| *name == component)?;
    models::find(model)
}

/// The parameter or input of a component, `component.variable`.
fn find(name: &str) -> Result<Variable> {
    let (component, variable) = name.split_once('.').unwrap_or_default();
    let model = model_of(component).with_context(|| format!("{NAME} has no component for {name}"))?;
    parameter_sets::settable(model, variable).cloned()
}

/// The sets of parameters, with the start values of the inputs of the system: a host that drives none of them leaves the
/// carriage where it is.
fn sets(sources: &Path) -> Result<Vec<ParameterSet>> {
    let mut sets = parameter_sets::of_owner(NAME, sources, find)?;
    for Connection { start, .. } in Connection::all()?.iter().filter(|connection| connection.start.component.is_none())
    {
        sets.iter_mut().for_each(|set| set.add_start(start.connector, start.variable));
    }
    Ok(sets)
}

/// The version of SSP for FMUs of a version of FMI: SSP 1.0 knows FMI 2.0 alone.
fn version_for(fmi: description::Version) -> Version {
    match fmi {
        description::Version::Fmi2 => Version::One,
        description::Version::Fmi3 => Version::Two,
    }
}

/// The file of the system within a folder of FMUs, beside the FMUs of a version of FMI.
pub fn file(fmus: &Path, fmi: description::Version) -> PathBuf {
    fmus.join(fmi.folder()).join(format!("{NAME}.ssp"))
}

/// Writes the system beside the FMUs of a version; `sources` has parameter sets and reference.
///
/// # Errors
/// When a file cannot be read or written.
pub fn write(fmus: &Path, fmi: description::Version, sources: &Path, timestamp: Timestamp) -> Result<PathBuf> {
    let (sets, version) = (sets(sources)?, version_for(fmi));
    let mut archive = Archive::default();
    archive.add("SystemStructure.ssd", description(Variant::System, version, timestamp)?)?;
    for set in &sets {
        let variant = Variant::Components(set);
        archive.add(&format!("{}.ssd", variant.file()), description(variant, version, timestamp)?)?;
    }
    let file = file(fmus, fmi);
    for (_, model) in COMPONENTS {
        let fmu = file.with_file_name(format!("{model}.fmu"));
        archive.add(&format!("resources/{model}.fmu"), files::read(fmu)?)?;
    }
    for set in &sets {
        archive.add(&format!("resources/{}.ssv", set.name), set.ssv(version, timestamp)?)?;
    }
    archive.add("resources/reference.csv", files::read(sources.join("reference.csv"))?)?;
    archive.write(&file, timestamp)?;
    Ok(file)
}

/// A connection with its connectors.
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
            model.table().iter().find(|variable| variable.name == connector)
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

/// Description of the system. Hosts distinguish descriptions by their names, and of several sets of parameters bound at a
/// place some take the first and some the last: one name each, one set each.
#[derive(Clone, Copy)]
enum Variant<'a> {
    /// With connectors of its own; the default set of parameters is bound to it.
    System,
    /// For hosts that know components alone (libcosim, Ecos): without connectors of the system, and with a set of
    /// parameters bound to the components.
    Components(&'a ParameterSet),
}

impl Variant<'_> {
    /// The name of the file without its ending.
    fn file(self) -> String {
        match self {
            Self::System => "SystemStructure".to_owned(),
            Self::Components(set) if set.name == DEFAULT_SET => "Components".to_owned(),
            Self::Components(set) => format!("Components{}", set.name),
        }
    }

    /// The name of the description.
    fn name(self) -> String {
        match self {
            Self::System => NAME.to_owned(),
            Self::Components(_) => format!("{NAME}{}", self.file()),
        }
    }
}

/// An SSD file.
fn description(variant: Variant, version: Version, timestamp: Timestamp) -> Result<String> {
    let mut connections = Connection::all()?;
    if let Variant::Components(_) = variant {
        connections.retain(|connection| connection.start.component.is_some() && connection.end.component.is_some());
    }
    let ends = || connections.iter().flat_map(|connection| [&connection.start, &connection.end]);
    let root = Element::new("ssd:SystemStructureDescription")
        .with("xmlns:ssc", COMMON)
        .with("xmlns:ssd", DESCRIPTION)
        .with("xmlns:oms", OMSIMULATOR)
        .with("version", version.number())
        .with("name", &variant.name())
        .with("description", "Pneumatic servo cylinder with a position controller")
        .with("license", env!("CARGO_PKG_LICENSE"))
        .with("generationTool", TOOL)
        .with("generationDateAndTime", &timestamp.iso());
    Ok(document(|xml| {
        root.contain(xml, |xml| {
            Element::new("ssd:System").with("name", NAME).contain(xml, |xml| {
                if let Variant::System = variant {
                    connectors(xml, version, &connections, None)?;
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
                                connectors(xml, version, &connections, Some(name))?;
                                geometry(place).write(xml)?;
                                match variant {
                                    Variant::System => Ok(()),
                                    Variant::Components(set) => binding(xml, version, name, set, timestamp),
                                }
                            })
                    })
                })?;
                Element::new("ssd:Connections")
                    .contain(xml, |xml| connections.iter().try_for_each(|connection| connect(xml, connection)))?;
                simulation_information(xml)
            })?;
            let used: Vec<Unit> = units::used(ends().map(|end| end.variable));
            write_units(xml, "ssd:Units", &used)?;
            Element::new("ssd:DefaultExperiment").with("startTime", "0.0").with("stopTime", STOP_TIME).write(xml)
        })
    })?)
}

/// The connectors of a component or of the system, each once. Where a connection starts within a component there is an
/// output, and where one ends an input; for the system, seen from inside, it is the other way round.
fn connectors(xml: &mut Xml, version: Version, connections: &[Connection], component: Option<&str>) -> io::Result<()> {
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
                    match end.variable.kind {
                        Kind::Real(unit) => {
                            Element::new(version.choose("ssc:Real", "ssc:Float64")).with("unit", unit.name)
                        }
                        Kind::Boolean => Element::new("ssc:Boolean"),
                        Kind::Integer | Kind::Enumeration(_) => {
                            Element::new(version.choose("ssc:Integer", "ssc:Int32"))
                        }
                    }
                    .write(xml)
                })?;
        }
        Ok(())
    })
}

/// The values of a set for a component, written out.
fn binding(
    xml: &mut Xml,
    version: Version,
    component: &str,
    set: &ParameterSet,
    timestamp: Timestamp,
) -> io::Result<()> {
    let prefix = format!("{component}.");
    if !set.has(&prefix) {
        return Ok(());
    }
    Element::new("ssd:ParameterBindings").contain(xml, |xml| {
        Element::new("ssd:ParameterBinding").contain(xml, |xml| {
            Element::new("ssd:ParameterValues").contain(xml, |xml| set.write(xml, version, &prefix, timestamp))
        })
    })
}

/// Simulation information for OMSimulator: steps of a fixed size.
fn simulation_information(xml: &mut Xml) -> io::Result<()> {
    Element::new("ssd:Annotations").contain(xml, |xml| {
        Element::new("ssc:Annotation").with("type", "org.openmodelica").contain(xml, |xml| {
            Element::new("oms:Annotations").contain(xml, |xml| {
                Element::new("oms:SimulationInformation").contain(xml, |xml| {
                    Element::new("oms:FixedStepMaster")
                        .with("description", "oms-ma")
                        .with("stepSize", STEP)
                        .with("absoluteTolerance", "0.0001")
                        .with("relativeTolerance", "0.0001")
                        .write(xml)
                })
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
            assert!(matches!(start.variable.kind, Kind::Real(_) | Kind::Boolean), "{}", start.connector);
            assert_eq!(start.variable.kind, end.variable.kind, "{} - {}", start.connector, end.connector);
        }
        Ok(())
    }

    /// A connector of the system has the name of the variable that it shows; pressures are named without the chamber.
    #[test]
    fn connectors_of_the_system_show_the_variables_that_they_are_named_after() -> Result<()> {
        let mut outputs = 0;
        for Connection { start, end } in Connection::all()? {
            for (outer, inner) in [(&start, &end), (&end, &start)] {
                if outer.component.is_some() {
                    continue;
                }
                let expected = match outer.connector {
                    "pressureA" => "chamberA.pressure",
                    "pressureB" => "chamberB.pressure",
                    name => name,
                };
                assert_eq!((inner.connector, inner.variable.name.as_str()), (expected, expected));
            }
            outputs += usize::from(end.component.is_none());
        }
        assert_eq!(outputs, 7);
        Ok(())
    }

    #[test]
    fn connections_between_components_are_of_the_same_name() -> Result<()> {
        for Connection { start, end } in Connection::all()? {
            assert!(start.component.is_none() || end.component.is_none() || start.connector == end.connector);
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
        let sets = sets(&sources)?;
        assert_eq!(sets.iter().map(|set| set.name.as_str()).collect::<Vec<_>>(), [DEFAULT_SET, "Lubricated"]);
        let reference = std::fs::read_to_string(sources.join("reference.csv"))?;
        let last = reference.lines().last().and_then(|line| line.split(',').next()).context("an empty reference")?;
        assert_eq!(last.parse::<f64>()?, STOP_TIME.parse::<f64>()?);
        Ok(())
    }

    #[test]
    fn every_description_has_a_name_of_its_own_and_one_set_of_parameters_at_a_place() -> Result<()> {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
        let timestamp = Timestamp::of_source(&sources)?;
        let sets = sets(&sources)?;
        let variants = [Variant::System].into_iter().chain(sets.iter().map(Variant::Components)).collect::<Vec<_>>();
        let names: std::collections::BTreeSet<_> = variants.iter().map(|variant| variant.name()).collect();
        assert_eq!(names.len(), variants.len());
        for variant in variants {
            let text = description(variant, Version::One, timestamp)?;
            assert_eq!(text.matches("<ssd:ParameterBinding").count(), 2, "one section, one binding: {text}");
            assert_eq!(text.matches("<oms:FixedStepMaster").count(), 1);
        }
        Ok(())
    }

    #[test]
    fn descriptions_are_called_after_their_sets() -> Result<()> {
        let sets = sets(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription"))?;
        let of = |variant: Variant| [variant.file(), variant.name()];
        assert_eq!(of(Variant::System), ["SystemStructure", "PneumaticServoDrive"]);
        assert_eq!(of(Variant::Components(&sets[0])), ["Components", "PneumaticServoDriveComponents"]);
        let lubricated = ["ComponentsLubricated", "PneumaticServoDriveComponentsLubricated"];
        assert_eq!(of(Variant::Components(&sets[1])), lubricated);
        Ok(())
    }

    /// The system has all connections; hosts that know components alone are given those from one to the other, and the values
    /// of the plant at the plant.
    #[test]
    fn descriptions_have_the_connections_and_values_that_their_hosts_know() -> Result<()> {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
        let (timestamp, sets) = (Timestamp::of_source(&sources)?, sets(&sources)?);
        let inner = [
            r#"<ssd:Connection startElement="controller" startConnector="valveVoltage" endElement="plant" endConnector="valveVoltage"/>"#,
            r#"<ssd:Connection startElement="plant" startConnector="position" endElement="controller" endConnector="position"/>"#,
            r#"<ssd:Connection startElement="plant" startConnector="velocity" endElement="controller" endConnector="velocity"/>"#,
        ];
        let outer = [
            r#"<ssd:Connection startConnector="referencePosition" endElement="controller" endConnector="referencePosition"/>"#,
            r#"<ssd:Connection startElement="plant" startConnector="chamberA.pressure" endConnector="pressureA"/>"#,
        ];
        let system = description(Variant::System, Version::One, timestamp)?;
        assert_eq!(system.matches("<ssd:Connection ").count(), 12, "{system}");
        assert!(inner.iter().chain(&outer).all(|connection| system.contains(connection)), "{system}");
        assert!(!system.contains("ssv:"), "its values are in a file of their own");
        let components = description(Variant::Components(&sets[0]), Version::One, timestamp)?;
        assert_eq!(components.matches("<ssd:Connection ").count(), 3, "{components}");
        assert!(inner.iter().all(|connection| components.contains(connection)), "{components}");
        let (_, parts) = components.split_once("<ssd:Component name=\"controller\"").context("a controller")?;
        let (controller, plant) = parts.split_once("<ssd:Component name=\"plant\"").context("a plant")?;
        assert!(!controller.contains("ssv:"), "{controller}");
        assert!(plant.contains("<ssv:Parameter name=\"friction.stribeck.Fs\">"), "{plant}");
        Ok(())
    }

    #[test]
    fn system_holds_its_descriptions_fmus_values_and_reference() -> Result<()> {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
        let folder = files::scratch("ssp");
        let fmi = description::Version::Fmi3;
        for (_, model) in COMPONENTS {
            files::write(&folder.join(fmi.folder()).join(format!("{model}.fmu")), model)?;
        }
        let file = write(&folder, fmi, &sources, Timestamp::of_source(&sources)?)?;
        assert_eq!(file, folder.join("fmi3/PneumaticServoDrive.ssp"));
        let mut archive = zip::ZipArchive::new(std::fs::File::open(&file)?)?;
        let mut names = archive.file_names().collect::<Result<Vec<_>, _>>()?;
        names.sort();
        let expected = [
            "Components.ssd",
            "ComponentsLubricated.ssd",
            "SystemStructure.ssd",
            "resources/Dry.ssv",
            "resources/Lubricated.ssv",
            "resources/PneumaticServoCylinder.fmu",
            "resources/PositionController.fmu",
            "resources/reference.csv",
        ];
        assert_eq!(names, expected);
        let text = io::read_to_string(archive.by_name("resources/PositionController.fmu")?)?;
        assert_eq!(text, "PositionController");
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }

    #[test]
    fn inputs_of_the_system_start_at_the_start_values_of_what_they_drive() -> Result<()> {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
        for set in sets(&sources)? {
            let ssv = set.ssv(Version::One, Timestamp::of_source(&sources)?)?;
            let start = "<ssv:Parameter name=\"referencePosition\">\n      <ssv:Real value=\"0.25\" unit=\"m\"/>";
            assert!(ssv.contains(start), "{ssv}");
        }
        Ok(())
    }

    #[test]
    fn a_name_without_a_component_is_refused() {
        let problem = find("brake.force").err().map(|error| error.to_string()).unwrap_or_default();
        assert!(problem.contains("no component for brake.force"), "{problem}");
    }

    /// Boxes of 40 by 40 with gaps of 20, in a row.
    #[test]
    fn components_are_side_by_side() -> Result<()> {
        for (place, edges) in [(0, ["20", "60"]), (1, ["80", "120"]), (2, ["140", "180"])] {
            let text = document(|xml| geometry(place).write(xml))?;
            for (name, value) in [("x1", edges[0]), ("y1", "20"), ("x2", edges[1]), ("y2", "60")] {
                let found = text.split(&format!(" {name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
                assert_eq!(found.and_then(|number| number.parse::<f64>().ok()), value.parse().ok(), "{name} in {text}");
            }
        }
        Ok(())
    }

    /// A component has the connectors at its ends of connections; the system, seen from inside, has them the other way round.
    #[test]
    fn connectors_are_listed_once_with_their_kind() -> Result<()> {
        let connections = Connection::all()?;
        for component in [None, Some(COMPONENTS[0].0), Some(COMPONENTS[1].0)] {
            let listed = document(|xml| connectors(xml, Version::One, &connections, component))?;
            let of = |ends: fn(&Connection) -> &End| {
                let names =
                    connections.iter().map(ends).filter(|end| end.component == component).map(|end| end.connector);
                names.collect::<std::collections::BTreeSet<_>>()
            };
            let (starts, ends) = (of(|it| &it.start), of(|it| &it.end));
            assert!(starts.is_disjoint(&ends) && starts.len() + ends.len() > 3, "{starts:?} {ends:?}");
            for (names, kind) in [(starts, ["output", "input"]), (ends, ["input", "output"])] {
                let kind = kind[usize::from(component.is_none())];
                for name in names {
                    assert_eq!(
                        listed.matches(&format!("name=\"{name}\" kind=\"{kind}\"")).count(),
                        1,
                        "{name}: {listed}"
                    );
                }
            }
        }
        Ok(())
    }
}
