//! FMUs of a configured machine, made from those of its model.

use std::path::PathBuf;

use anyhow::{Context, Result};
use pneumatic_servo_export::{Interface, Preset, export, read_ssv};

use crate::description::Version;
use crate::files;
use crate::package::fmus_of;
use crate::workspace::Workspace;

/// A machine of the user's: its values, and the variables of its FMUs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Machine {
    /// An SSV with its values.
    pub file: PathBuf,
    /// Its name; otherwise that of the file.
    pub name: Option<String>,
    /// The name of a preset of variables.
    pub preset: Option<String>,
    /// Inputs that stay.
    pub inputs: Option<Vec<String>>,
    /// Outputs that stay.
    pub outputs: Option<Vec<String>>,
    /// Parameters that stay.
    pub parameters: Option<Vec<String>>,
}

/// Writes its FMUs, one for each version, beside those of the first model of the product, and says where.
///
/// # Errors
/// When the file cannot be read, or the machine is refused.
pub fn write(workspace: &Workspace, machine: &Machine) -> Result<Vec<PathBuf>> {
    let Machine { file, name, preset, inputs, outputs, parameters } = machine.clone();
    let shown = file.display().to_string();
    let stem = || file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let own = pneumatic_servo_export::Machine {
        name: name.unwrap_or_else(stem),
        values: read_ssv(&files::text(&file)?, &shown)?,
        interface: Interface {
            preset: preset.as_deref().map_or(Ok(Preset::default()), Preset::named)?,
            inputs,
            outputs,
            parameters,
        },
        ..pneumatic_servo_export::Machine::default()
    };
    let models: Vec<_> = workspace.product.models.iter().collect();
    let mut written = Vec::new();
    for version in Version::ALL {
        let source = fmus_of(workspace, version).next().context("there is no model")?;
        let exported = export(&files::read(&source)?, &models, &own).with_context(|| shown.clone())?;
        let fmu = source.with_file_name(format!("{}.fmu", own.name));
        files::write(&fmu, exported.fmu)?;
        println!("{}", fmu.display());
        written.push(fmu);
    }
    Ok(written)
}
