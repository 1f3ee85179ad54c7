//! One instance of either version and kind, driven by the names of its variables.

use anyhow::{Context, Result, ensure};
use fmi::traits::{FmiInstance, FmiStatus, InstanceResult};

/// Names that differ between the versions of FMI.
pub trait Version: FmiInstance<ValueRef = u32> + Sized {
    /// FMU as read by the crate.
    type Import;

    /// The value reference of a variable.
    ///
    /// # Errors
    /// When the description has no variable of that name.
    fn reference(import: &Self::Import, name: &str) -> Result<u32>;

    /// Whether a status is OK, not a warning.
    fn is_ok(status: &<Self::Status as FmiStatus>::Res) -> bool;

    /// Sets a real variable.
    ///
    /// # Errors
    /// When the FMU refuses, as in all below.
    fn set_real(&mut self, reference: u32, value: f64) -> InstanceResult<Self>;

    /// Sets an integer variable.
    ///
    /// # Errors
    /// See above.
    fn set_integer(&mut self, reference: u32, value: i32) -> InstanceResult<Self>;

    /// Reads a real variable.
    ///
    /// # Errors
    /// See above.
    fn get_real(&mut self, reference: u32, value: &mut f64) -> InstanceResult<Self>;

    /// Reads an integer variable.
    ///
    /// # Errors
    /// See above.
    fn get_integer(&mut self, reference: u32, value: &mut i32) -> InstanceResult<Self>;

    /// Reads a true-or-false variable.
    ///
    /// # Errors
    /// See above.
    fn get_boolean(&mut self, reference: u32, value: &mut bool) -> InstanceResult<Self>;
}

/// Lets nothing pass but the status OK.
pub(crate) fn ok<I: Version>(result: InstanceResult<I>) -> Result<()> {
    let status = result.map_err(Into::<fmi::Error>::into)?;
    ensure!(I::is_ok(&status), "the status is a warning");
    Ok(())
}

/// One instance with the names of its variables; every status other than OK is an error.
pub struct Host<'a, I: Version> {
    /// The instance itself.
    pub instance: I,
    pub(crate) import: &'a I::Import,
}

impl<I: Version> Host<'_, I> {
    /// Initializes at time 0.
    ///
    /// # Errors
    /// When the FMU refuses, as in all below.
    pub fn initialize(&mut self) -> Result<()> {
        ok::<I>(self.instance.enter_initialization_mode(None, 0.0, None))?;
        ok::<I>(self.instance.exit_initialization_mode())
    }

    /// Sets a real variable.
    ///
    /// # Errors
    /// See above, or when there is no variable of the name.
    pub fn set_real(&mut self, name: &str, value: f64) -> Result<()> {
        let reference = I::reference(self.import, name)?;
        ok::<I>(self.instance.set_real(reference, value)).with_context(|| format!("{name} = {value}"))
    }

    /// Sets an integer variable.
    ///
    /// # Errors
    /// See above.
    pub fn set_integer(&mut self, name: &str, value: i32) -> Result<()> {
        let reference = I::reference(self.import, name)?;
        ok::<I>(self.instance.set_integer(reference, value)).with_context(|| format!("{name} = {value}"))
    }

    /// Reads a real variable.
    ///
    /// # Errors
    /// See above.
    pub fn real(&mut self, name: &str) -> Result<f64> {
        let mut value = f64::NAN;
        let reference = I::reference(self.import, name)?;
        ok::<I>(self.instance.get_real(reference, &mut value)).with_context(|| name.to_owned())?;
        Ok(value)
    }

    /// Reads an integer variable.
    ///
    /// # Errors
    /// See above.
    pub fn integer(&mut self, name: &str) -> Result<i32> {
        let mut value = i32::MIN;
        let reference = I::reference(self.import, name)?;
        ok::<I>(self.instance.get_integer(reference, &mut value)).with_context(|| name.to_owned())?;
        Ok(value)
    }

    /// Reads a true-or-false variable.
    ///
    /// # Errors
    /// See above.
    pub fn boolean(&mut self, name: &str) -> Result<bool> {
        let mut value = false;
        let reference = I::reference(self.import, name)?;
        ok::<I>(self.instance.get_boolean(reference, &mut value)).with_context(|| name.to_owned())?;
        Ok(value)
    }
}
