//! The owner of the FMUs to pack: the project, or a crate of a user.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use pneumatic_servo::model::Model;
use pneumatic_servo::models;

use crate::files;

/// The package of the built-in library.
pub const PACKAGE: &str = "pneumatic-servo-builtin";

/// Models to pack.
#[derive(Clone, Debug)]
pub struct Product {
    /// The models.
    pub models: &'static [Model],
    /// The package that is built as the shared library.
    pub package: String,
    /// Its version.
    pub version: String,
    /// Its licence, as SPDX writes it; empty if it states none.
    pub licence: String,
    /// The fingerprint of a source that the library of the project does not have.
    pub source: Option<String>,
    /// Where hand-written parts of the FMUs are.
    pub parts: Parts,
}

impl Product {
    /// The FMUs of the project.
    pub fn of_the_project(home: &Path) -> Self {
        let [version, licence] = [env!("CARGO_PKG_VERSION"), env!("CARGO_PKG_LICENSE")].map(str::to_owned);
        let package = PACKAGE.to_owned();
        Self { models: models::ALL, package, version, licence, source: None, parts: Parts::of_the_project(home) }
    }

    /// The same with one model alone.
    ///
    /// # Errors
    /// When there is no model of this name.
    pub fn only(&self, name: &str) -> Result<Self> {
        let Some(place) = self.models.iter().position(|model| model.name == name) else {
            let names: Vec<_> = self.models.iter().map(|model| model.name).collect();
            bail!("there is no model {name}, but {}", names.join(", "));
        };
        Ok(Self { models: &self.models[place..=place], ..self.clone() })
    }

    /// Whether they are joined to a system, an SSP, besides: all models of the project.
    pub fn has_system(&self) -> bool {
        self.is_of_the_project() && self.models.len() == models::ALL.len()
    }

    /// Whether the models belong to the project.
    pub fn is_of_the_project(&self) -> bool {
        self.source.is_none()
    }
}

/// Folders with hand-written parts of FMUs: pages, icons, parameter sets. What is in an earlier one counts.
#[derive(Clone, Debug)]
pub struct Parts(Vec<PathBuf>);

impl Parts {
    /// The parts in a folder, which may be missing, and the project's.
    pub fn of_a_crate(folder: PathBuf, home: &Path) -> Self {
        Self(vec![folder, home.join("modelDescription")])
    }

    /// The project's parts.
    pub fn of_the_project(home: &Path) -> Self {
        Self(vec![home.join("modelDescription")])
    }

    /// The folders.
    pub fn folders(&self) -> impl Iterator<Item = &Path> {
        self.0.iter().map(PathBuf::as_path)
    }

    /// A part, if there is one of this name.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn read(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let Some(file) = self.folders().map(|folder| folder.join(name)).find(|file| file.is_file()) else {
            return Ok(None);
        };
        files::read(file).map(Some)
    }

    /// A part that is text, if there is one of this name.
    ///
    /// # Errors
    /// When it cannot be read or is not UTF-8.
    pub fn text(&self, name: &str) -> Result<Option<String>> {
        let bytes = self.read(name)?;
        bytes.map(String::from_utf8).transpose().with_context(|| format!("{name} is not UTF-8"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_model_is_packed_alone_and_without_the_system() -> Result<()> {
        let all = Product::of_the_project("/home".as_ref());
        let one = all.only("FrictionBench")?;
        assert_eq!(one.models.iter().map(|model| model.name).collect::<Vec<_>>(), ["FrictionBench"]);
        assert!(all.has_system() && !one.has_system() && one.is_of_the_project());
        let problem = all.only("Bench").map(|_| ()).map_err(|error| error.to_string());
        assert!(problem.is_err_and(|text| text.contains("no model Bench, but PneumaticServoCylinder,")));
        Ok(())
    }
}
