//! A host made with the crate `fmi`, an FMI implementation that shares nothing with the one of this repository.
//!
//! Its tests import the FMUs that `cargo xtask package` left. The crate needs libclang to be built, which
//! `cargo xtask test` provides, and it is left out unless the feature `fmi` asks for it.

#![cfg(feature = "fmi")]

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use fmi::CS;
use fmi::fmi2::Fmi2Res;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, Instance};
use fmi::traits::FmiImport;

/// The folder with the packaged FMUs.
pub fn fmus() -> PathBuf {
    product("FMU_FOLDER", "fmu")
}

/// The folder with what they do under every friction law.
pub fn gallery() -> PathBuf {
    product("GALLERY_FOLDER", "gallery")
}

/// A folder that `cargo xtask` leaves, wherever the variable says it is.
fn product(variable: &str, name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    std::env::var_os(variable).map_or_else(|| target.join(name), PathBuf::from)
}

/// Opens the packaged FMU of a model.
///
/// # Errors
/// When it is not there or cannot be read.
pub fn open(model: &str) -> Result<Fmi2Import> {
    let file = fmus().join(format!("{model}.fmu"));
    fmi::import::from_path(&file)
        .with_context(|| format!("cannot import {}: run `cargo xtask package` first", file.display()))
}

/// One instance, driven by the names of its variables; every status other than OK is an error.
pub struct Host<'a> {
    /// The instance itself.
    pub instance: Instance<CS>,
    import: &'a Fmi2Import,
}

impl<'a> Host<'a> {
    /// Instantiates the FMU.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn new(import: &'a Fmi2Import) -> Result<Self> {
        let instance = import.instantiate_cs("importer", false, false).context("fmi2Instantiate")?;
        Ok(Self { instance, import })
    }

    /// Initializes at time 0.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn initialize(&mut self) -> Result<()> {
        ok(self.instance.setup_experiment(None, 0.0, None))?;
        ok(self.instance.enter_initialization_mode())?;
        ok(self.instance.exit_initialization_mode())
    }

    /// Makes a communication step.
    ///
    /// # Errors
    /// When it cannot be completed.
    pub fn step(&mut self, from: f64, to: f64) -> Result<()> {
        ok(self.instance.do_step(from, to - from, true)).with_context(|| format!("step from {from} s"))
    }

    /// The value reference of a variable.
    ///
    /// # Errors
    /// When the description has no variable of that name.
    pub fn reference(&self, name: &str) -> Result<u32> {
        Ok(self.import.model_description().model_variable_by_name(name)?.value_reference)
    }

    /// Sets a real variable.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn set_real(&mut self, name: &str, value: f64) -> Result<()> {
        let reference = self.reference(name)?;
        ok(self.instance.set_real(&[reference], &[value])).with_context(|| format!("{name} = {value}"))
    }

    /// Sets an integer variable or an enumeration.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn set_integer(&mut self, name: &str, value: i32) -> Result<()> {
        let reference = self.reference(name)?;
        ok(self.instance.set_integer(&[reference], &[value])).with_context(|| format!("{name} = {value}"))
    }

    /// Reads a real variable.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn real(&mut self, name: &str) -> Result<f64> {
        let mut value = [f64::NAN];
        let reference = self.reference(name)?;
        ok(self.instance.get_real(&[reference], &mut value)).with_context(|| name.to_owned())?;
        Ok(value[0])
    }

    /// Reads a true-or-false variable.
    ///
    /// # Errors
    /// When the FMU refuses, or answers with neither 0 nor 1.
    pub fn boolean(&mut self, name: &str) -> Result<bool> {
        let mut value = [-1];
        let reference = self.reference(name)?;
        ok(self.instance.get_boolean(&[reference], &mut value)).with_context(|| name.to_owned())?;
        ensure!(matches!(value[0], 0 | 1), "{name} is {}", value[0]);
        Ok(value[0] == 1)
    }
}

/// Lets nothing pass but the status OK.
fn ok(result: Result<Fmi2Res, fmi::fmi2::Fmi2Error>) -> Result<()> {
    let status = result?;
    ensure!(matches!(status, Fmi2Res::OK), "the status is {status:?}");
    Ok(())
}
