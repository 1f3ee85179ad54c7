//! FMI 3.0: import, and instances for both kinds.

use std::fs::File;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::instance::{Instance, InstanceCS, InstanceME};
use fmi::fmi3::{CoSimulation, Fmi3Model, Fmi3Res, GetSet, ModelExchange};
use fmi::traits::{FmiImport, InstanceResult, InstanceTag};
use zip::ZipArchive;

use crate::host::{Host, Version, ok};
use crate::integrator::Exchange;

/// Opens the packaged FMU of a model.
///
/// # Errors
/// When it is not there or cannot be read.
pub fn open(model: &str) -> Result<Fmi3Import> {
    open_file(&crate::fmus().join("fmi3").join(format!("{model}.fmu")))
}

/// Opens an FMU.
///
/// # Errors
/// As above.
pub fn open_file(file: &Path) -> Result<Fmi3Import> {
    let file =
        File::open(file).with_context(|| format!("cannot open {}: run `cargo xtask package` first", file.display()))?;
    let folder = tempfile::tempdir()?;
    ZipArchive::new(file)?.extract(&folder)?;
    let description = std::fs::read_to_string(folder.path().join("modelDescription.xml"))?;
    Ok(Fmi3Import::new(folder, &readable(&description)?)?)
}

/// The description without what version 0.8.0 of the crate refuses although the standard has it: the base units A and K,
/// and units and nominal values of variables.
fn readable(description: &str) -> Result<String> {
    let (head, rest) = description.split_once("<UnitDefinitions>").context("no definitions of units")?;
    let (_, tail) = rest.split_once("</UnitDefinitions>").context("no end of the definitions of units")?;
    let attributes = [" unit=\"", " displayUnit=\"", " nominal=\""];
    Ok(attributes.into_iter().fold(format!("{head}{tail}"), |text, attribute| {
        let mut pieces = text.split(attribute);
        let first = pieces.next().unwrap_or_default();
        // A piece begins with the value, which ends at the next quotation mark.
        let rests = pieces.map(|piece| piece.split_once('"').map_or("", |(_, rest)| rest));
        std::iter::once(first).chain(rests).collect()
    }))
}

/// An instance for co-simulation; whether it returns at events, to let the host handle them.
///
/// # Errors
/// When the FMU refuses.
pub fn co_simulation(import: &Fmi3Import, events: bool) -> Result<Host<'_, InstanceCS>> {
    let instance = import.instantiate_cs("importer", false, false, events, events, &[]);
    Ok(Host { instance: instance.context("fmi3InstantiateCoSimulation")?, import })
}

/// An instance for model exchange.
///
/// # Errors
/// When the FMU refuses.
pub fn exchange(import: &Fmi3Import) -> Result<Host<'_, InstanceME>> {
    let instance = import.instantiate_me("importer", false, false).context("fmi3InstantiateModelExchange")?;
    Ok(Host { instance, import })
}

/// End of a communication step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Whether it has ended at an event, which is still to happen.
    pub event: bool,
    /// The time it has reached.
    pub reached: f64,
}

impl Host<'_, InstanceCS> {
    /// Makes a communication step, or a part of it that ends at an event.
    ///
    /// # Errors
    /// When it cannot be completed, or the FMU contradicts itself.
    pub fn step(&mut self, from: f64, to: f64) -> Result<Step> {
        let [mut event, mut terminate, mut is_early] = [false; 3];
        let mut reached = f64::NAN;
        let instance = &mut self.instance;
        let status = instance.do_step(from, to - from, true, &mut event, &mut terminate, &mut is_early, &mut reached);
        ok::<InstanceCS>(status).with_context(|| format!("step from {from} s"))?;
        ensure!(!terminate && is_early == (reached < to), "step from {from} to {to} s: {reached} s, {is_early}");
        Ok(Step { event, reached })
    }
}

impl<T: InstanceTag> Version for Instance<T> {
    type Import = Fmi3Import;

    fn reference(import: &Fmi3Import, name: &str) -> Result<u32> {
        let variables = &import.model_description().model_variables;
        Ok(variables.find_by_name(name).with_context(|| format!("no variable {name}"))?.value_reference())
    }

    fn is_ok(status: &Fmi3Res) -> bool {
        *status == Fmi3Res::OK
    }

    fn set_real(&mut self, reference: u32, value: f64) -> InstanceResult<Self> {
        self.set_float64(&[reference], &[value])
    }

    fn set_integer(&mut self, reference: u32, value: i32) -> InstanceResult<Self> {
        self.set_int32(&[reference], &[value])
    }

    fn get_real(&mut self, reference: u32, value: &mut f64) -> InstanceResult<Self> {
        self.get_float64(&[reference], std::slice::from_mut(value))
    }

    fn get_integer(&mut self, reference: u32, value: &mut i32) -> InstanceResult<Self> {
        self.get_int32(&[reference], std::slice::from_mut(value))
    }

    fn get_boolean(&mut self, reference: u32, value: &mut bool) -> InstanceResult<Self> {
        GetSet::get_boolean(self, &[reference], std::slice::from_mut(value))
    }
}

impl Exchange for InstanceME {
    fn sizes(&mut self, _: &Fmi3Import) -> Result<[usize; 2]> {
        Ok([self.get_number_of_continuous_states()?, self.get_number_of_event_indicators()?])
    }
}
