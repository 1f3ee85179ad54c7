//! A configured machine as an FMU of its own: a released FMU is rewritten with other start values and fewer variables. The
//! library inside stays; it reads the values from the resources ([`pneumatic_servo_variant`]).
//!
//! | module | contents |
//! |---|---|
//! | `interface` | the variables that stay: by name, or a preset |
//! | `description` | `modelDescription.xml` and `terminalsAndIcons.xml` of the variant |
//! | `node` | XML as a tree |
//! | `archive` | archives in memory |
//! | `page` | the section of the documentation page |
//! | `system` | an SSP of configured FMUs |
//! | `beside` | the values for other tools: JSON, YAML, Modelica, MATLAB |
//!
//! It touches no file: archives come and go as bytes, so that the page for the browser uses it, too.

mod archive;
mod beside;
mod description;
mod interface;
mod node;
mod page;
mod system;

use std::collections::BTreeMap;
use std::fmt;

use pneumatic_servo::model::Model;
use pneumatic_servo_variant::{FILE, Given, Variant, guid};

use self::archive::Archive;
pub use self::interface::{Interface, Preset};
use self::node::Node;
pub use self::system::{export_system, is_system, read_ssv};

/// Why there is no variant; nothing has been written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl From<String> for Refused {
    fn from(reason: String) -> Self {
        Self(reason)
    }
}

impl From<rawzip::Error> for Refused {
    fn from(error: rawzip::Error) -> Self {
        Self(format!("the FMU cannot be read: {error}"))
    }
}

impl From<std::io::Error> for Refused {
    fn from(error: std::io::Error) -> Self {
        Self(format!("the FMU cannot be read: {error}"))
    }
}

/// A default experiment; what it does not state stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Start time in s.
    pub start: Option<f64>,
    /// Stop time in s.
    pub stop: Option<f64>,
    /// Size of a communication step in s.
    pub step: Option<f64>,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
}

/// A machine to be exported.
#[derive(Clone, Debug, Default)]
pub struct Machine {
    /// Its name: letters, digits, `_`, `-`, `.` and blanks.
    pub name: String,
    /// Values by name, in SI units.
    pub values: BTreeMap<String, Given>,
    /// The variables that stay.
    pub interface: Interface,
    /// The default experiment.
    pub experiment: Experiment,
    /// Sections of HTML for the documentation page.
    pub sections: String,
}

/// An exported machine.
#[derive(Clone, Debug)]
pub struct Exported {
    /// The FMU.
    pub fmu: Vec<u8>,
    /// Values for other tools, by the name of the file.
    pub beside: BTreeMap<String, String>,
}

const DESCRIPTION: &str = "modelDescription.xml";
const TERMINALS: &str = "terminalsAndIcons/terminalsAndIcons.xml";
const PAGE: &str = "documentation/index.html";

/// The FMU of a machine, made from one of its model.
///
/// `models` are those that the program knows: start values of states are computed by them.
///
/// # Errors
/// [`Refused`] when the file is no FMU of these models or a variant already; for names that are not there, an input that the
/// configured machine needs and that is left out, and values that are not legal or do not fit together.
pub fn export(source: &[u8], models: &[&'static Model], machine: &Machine) -> Result<Exported, Refused> {
    check_name(&machine.name)?;
    let archive = Archive::read(source)?;
    let variant_path = format!("resources/{FILE}");
    if archive.has(&variant_path) {
        return Err(Refused("the FMU is a variant already; take the FMU of the model".to_owned()));
    }
    let description = Node::read(&archive.text(DESCRIPTION)?, DESCRIPTION)?;
    let model = model_of(&description, models)?;
    let table = model.table();

    let mut variant = machine.interface.variant(model, &machine.name, &machine.values)?;
    for (name, given) in &mut variant.values {
        // Numbers of items and flags are stated as what they are.
        if let Some(entry) = table.find(name) {
            let number = given.value().number(entry.variable).map_err(|error| Refused(error.to_string()))?;
            *given = pneumatic_servo_variant::given(entry.variable, number);
        }
    }
    let resolved = variant.resolve(table)?;
    let states = model
        .starts_with(&resolved.parameters, &resolved.inputs)
        .map_err(|error| Refused(format!("the values do not fit together: {error}")))?;

    let file = variant.text();
    let base = description.get("guid").or_else(|| description.get("instantiationToken")).unwrap_or_default();
    let started = description::Started { model, resolved: &resolved, states: &states };
    let mut own = started.described(&description, &variant, &guid(base, file.as_bytes()))?;
    description::experiment(&mut own, machine.experiment)?;

    let mut changed: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    changed.insert(DESCRIPTION.to_owned(), own.text().into_bytes());
    changed.insert(variant_path, file.into_bytes());
    if archive.has(TERMINALS) {
        let terminals = Node::read(&archive.text(TERMINALS)?, TERMINALS)?;
        changed.insert(TERMINALS.to_owned(), description::terminals(terminals, &own).text().into_bytes());
    }
    if archive.has(PAGE) {
        let page = archive.text(PAGE)?;
        let section = page::section(model, &variant, &resolved) + &machine.sections;
        changed.insert(PAGE.to_owned(), page::with_section(&page, &machine.name, &section)?.into_bytes());
    }
    let beside = beside::files(model, &variant, &resolved);
    Ok(Exported { fmu: archive.rewritten(changed, is_source)?, beside })
}

/// A name that may stand in XML, file names and messages.
fn check_name(name: &str) -> Result<(), Refused> {
    let is_plain = |letter: char| letter.is_alphanumeric() || "_-. ".contains(letter);
    if name.is_empty() || name.len() > 100 || name.trim() != name || !name.chars().all(is_plain) {
        return Err(Refused(format!(
            "the name {name:?} is refused: give up to 100 letters, digits, underscores, hyphens, dots or blanks"
        )));
    }
    Ok(())
}

/// The model of a description.
fn model_of(description: &Node, models: &[&'static Model]) -> Result<&'static Model, Refused> {
    let kinds = ["CoSimulation", "ModelExchange"].into_iter().filter_map(|kind| description.child(kind));
    let identifier = kinds.filter_map(|kind| kind.get("modelIdentifier")).next().unwrap_or_default();
    if !description.get("generationTool").is_some_and(|tool| tool.starts_with("pneumatic-servo-fmu")) {
        return Err(Refused("it is no FMU of this library".to_owned()));
    }
    models.iter().find(|model| model.name == identifier).copied().ok_or_else(|| {
        let names: Vec<_> = models.iter().map(|model| model.name).collect();
        Refused(format!("the FMU is of the model {identifier}, not of {}", names.join(", ")))
    })
}

/// Sources in C: on a target without files they could not read the values.
fn is_source(path: &str) -> bool {
    path.starts_with("sources/")
}

/// The model of an FMU.
///
/// # Errors
/// [`Refused`] when the file is no FMU of these models.
pub fn model(fmu: &[u8], models: &[&'static Model]) -> Result<&'static Model, Refused> {
    let archive = Archive::read(fmu)?;
    model_of(&Node::read(&archive.text(DESCRIPTION)?, DESCRIPTION)?, models)
}

/// The variant of an exported FMU; nothing of the FMU of a model.
///
/// # Errors
/// [`Refused`] when the archive or the file in it cannot be read.
pub fn variant(fmu: &[u8]) -> Result<Option<Variant>, Refused> {
    let archive = Archive::read(fmu)?;
    let path = format!("resources/{FILE}");
    if !archive.has(&path) {
        return Ok(None);
    }
    Ok(Some(Variant::read(archive.text(&path)?.as_bytes())?))
}
