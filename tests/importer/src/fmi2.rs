//! FMI 2.0: import, and instances for both kinds.

use std::path::Path;

use anyhow::{Context, Result};
use fmi::fmi2::Fmi2Res;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, Instance, InstanceCS, InstanceME};
use fmi::traits::{FmiImport, InstanceResult, InstanceTag};

use crate::host::{Host, Version, ok};
use crate::integrator::Exchange;

/// Opens the packaged FMU of a model.
///
/// # Errors
/// When it is not there or cannot be read.
pub fn open(model: &str) -> Result<Fmi2Import> {
    open_file(&crate::fmus().join(format!("{model}.fmu")))
}

/// Opens an FMU.
///
/// # Errors
/// As above.
pub fn open_file(file: &Path) -> Result<Fmi2Import> {
    fmi::import::from_path(file)
        .with_context(|| format!("cannot import {}: run `cargo xtask package` first", file.display()))
}

/// An instance for co-simulation.
///
/// # Errors
/// When the FMU refuses.
pub fn co_simulation(import: &Fmi2Import) -> Result<Host<'_, InstanceCS>> {
    let instance = import.instantiate_cs("importer", false, false).context("fmi2Instantiate")?;
    Ok(Host { instance, import })
}

/// An instance for model exchange.
///
/// # Errors
/// When the FMU refuses.
pub fn exchange(import: &Fmi2Import) -> Result<Host<'_, InstanceME>> {
    let instance = import.instantiate_me("importer", false, false).context("fmi2Instantiate")?;
    Ok(Host { instance, import })
}

impl Host<'_, InstanceCS> {
    /// Makes a communication step.
    ///
    /// # Errors
    /// When it cannot be completed.
    pub fn step(&mut self, from: f64, to: f64) -> Result<()> {
        ok::<InstanceCS>(self.instance.do_step(from, to - from, true)).with_context(|| format!("step from {from} s"))
    }
}

impl<T: InstanceTag> Version for Instance<T> {
    type Import = Fmi2Import;

    fn reference(import: &Fmi2Import, name: &str) -> Result<u32> {
        Ok(import.model_description().model_variable_by_name(name)?.value_reference)
    }

    fn is_ok(status: &Fmi2Res) -> bool {
        matches!(status, Fmi2Res::OK)
    }

    fn set_real(&mut self, reference: u32, value: f64) -> InstanceResult<Self> {
        Common::set_real(self, &[reference], &[value])
    }

    fn set_integer(&mut self, reference: u32, value: i32) -> InstanceResult<Self> {
        Common::set_integer(self, &[reference], &[value])
    }

    fn get_real(&mut self, reference: u32, value: &mut f64) -> InstanceResult<Self> {
        Common::get_real(self, &[reference], std::slice::from_mut(value))
    }

    fn get_integer(&mut self, reference: u32, value: &mut i32) -> InstanceResult<Self> {
        Common::get_integer(self, &[reference], std::slice::from_mut(value))
    }

    fn get_boolean(&mut self, reference: u32, value: &mut bool) -> InstanceResult<Self> {
        let mut number = [-1];
        let status = Common::get_boolean(self, &[reference], &mut number)?;
        assert!(matches!(number, [0 | 1]), "variable {reference} is {number:?}, neither true nor false");
        *value = number == [1];
        Ok(status)
    }
}

impl Exchange for InstanceME {
    fn sizes(&mut self, import: &Fmi2Import) -> Result<[usize; 2]> {
        let description = import.model_description();
        Ok([description.num_states(), description.num_event_indicators()])
    }
}
