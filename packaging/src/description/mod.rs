//! `modelDescription.xml`, made from the variable table: one description of a model, written for two versions of FMI.

mod enumerations;
mod fmi2;
mod fmi3;
mod structure;
mod terminals;
mod units;
mod variability;

use std::io;

use anyhow::{Context, Result, anyhow};
use pneumatic_servo::model::Model;
use pneumatic_servo_fmu::LOG_CATEGORIES;
use pneumatic_servo_ssp::xml::{Element, Xml, document};

pub use self::enumerations::used as enumerations;
use self::structure::Structure;
pub use self::terminals::xml as terminals;

/// Values that change from build to build.
pub struct Stamp {
    /// Identifies the description and the library that belongs to it.
    pub guid: String,
    /// When it was generated, in ISO 8601.
    pub date: String,
    /// The source files that an importer compiles; none in an FMU without sources.
    pub sources: Vec<String>,
    /// The version of the model.
    pub version: String,
    /// Its licence; empty if none is stated.
    pub licence: String,
}

/// Generation tool named in the files.
pub const TOOL: &str = concat!("pneumatic-servo-fmu ", env!("CARGO_PKG_VERSION"));

/// A version of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

impl Version {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Fmi2, Self::Fmi3];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fmi2 => "FMI 2.0",
            Self::Fmi3 => "FMI 3.0",
        }
    }

    /// Its subfolder in the folders of FMUs and descriptions: none for FMI 2.0, which most tools read.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Fmi2 => "",
            Self::Fmi3 => "fmi3",
        }
    }
}

/// The description of a model for a version.
///
/// # Errors
/// When a variable refers to one that the table does not have.
pub fn xml(model: &Model, version: Version, stamp: &Stamp) -> Result<String> {
    let structure = Structure::new(model.table()).with_context(|| format!("the table of {}", model.name))?;
    let variables =
        model.started_variables().map_err(|error| anyhow!("the defaults of {} do not fit: {error}", model.name))?;
    Ok(document(|xml| match version {
        Version::Fmi2 => fmi2::write(xml, model, &variables, stamp, &structure),
        Version::Fmi3 => fmi3::write(xml, model, &variables, stamp, &structure),
    })?)
}

/// The root, with what the versions of FMI call by the same names, around what is told by `contents`.
fn root(version: &str, token: &str, model: &Model, stamp: &Stamp) -> Element {
    Element::new("fmiModelDescription")
        .with("fmiVersion", version)
        .with("modelName", model.name)
        .with(token, &stamp.guid)
        .with("description", model.description)
        .with("version", &stamp.version)
        .with_some("license", (!stamp.licence.is_empty()).then(|| stamp.licence.clone()))
        .with("generationTool", TOOL)
        .with("generationDateAndTime", &stamp.date)
        .with("variableNamingConvention", "structured")
}

/// Co-simulation or model exchange, with the common attributes before its own.
fn kind(name: &'static str, model: &Model, common: &[Attribute], own: &[Attribute]) -> Element {
    let element = Element::new(name).with("modelIdentifier", model.name);
    common.iter().chain(own).fold(element, |element, (name, value)| element.with(name, value))
}

/// Name and value.
type Attribute = (&'static str, &'static str);

/// Whether there is anything to exchange: a model without continuous states needs no solver.
pub fn is_exchanged(model: &Model) -> bool {
    model.table().number_of_states() > 0
}

fn log_categories(xml: &mut Xml) -> io::Result<()> {
    Element::new("LogCategories").contain(xml, |xml| {
        LOG_CATEGORIES.iter().try_for_each(|category| {
            Element::new("Category").with("name", category.name).with("description", category.description).write(xml)
        })
    })
}

fn default_experiment(xml: &mut Xml, model: &Model) -> io::Result<()> {
    Element::new("DefaultExperiment")
        .with("startTime", "0")
        .with_number("stopTime", model.experiment.stop_time)
        .with_number("tolerance", TOLERANCE)
        .with_number("stepSize", model.experiment.step_size)
        .write(xml)
}

/// The default of `solver.relativeTolerance`.
const TOLERANCE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use pneumatic_servo::models;
    use pneumatic_servo::variables::array_name;

    use super::Version;

    /// FMUs of FMI 2.0, which most tools read, are found first; both have the names of the standard.
    #[test]
    fn versions_have_names_and_folders_of_their_own() {
        assert_eq!(
            Version::ALL.map(|version| (version.name(), version.folder())),
            [("FMI 2.0", ""), ("FMI 3.0", "fmi3")]
        );
    }

    /// Viewers show structured names as a tree, in which a variable cannot be a branch too.
    #[test]
    fn no_variable_has_the_name_of_a_group() {
        for model in models::ALL {
            let indicators = model.indicator_variables();
            let variables = model.table().iter().chain(&indicators);
            let names = variables.flat_map(|variable| [Some(variable.name.as_str()), array_name(&variable.name)]);
            let names: BTreeSet<&str> = names.flatten().collect();
            let plain = names.iter().filter(|name| !name.starts_with("der("));
            for group in plain.filter_map(|name| name.rsplit_once('.')).map(|(group, _)| group) {
                assert!(!names.contains(group), "{}: {group} is a variable and a group", model.name);
            }
        }
    }

    #[test]
    fn indicators_have_names_and_references_of_their_own() {
        for model in models::ALL {
            let table = model.table();
            for indicator in model.indicator_variables() {
                assert!(table.find(&indicator.name).is_none(), "{}: {}", model.name, indicator.name);
                assert!(table.by_reference(indicator.reference).is_none(), "{}: {}", model.name, indicator.name);
            }
        }
    }
}
