//! A configured FMU gives the bits of the plant with its values through the crate `fmi`, in both versions.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use importer::{Host, Version, fmi2, fmi3, fmus};
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo_export::{Interface, Machine, Preset, export};
use pneumatic_servo_variant::Given;
use tempfile::TempDir;

const VALUES: [(&str, f64); 3] = [("mass.moving", 3.1), ("position0", 0.1), ("supplyPressure", 6.5e5)];
const NAMES: [&str; 5] = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce"];
/// A sum of these is exact.
const STEP: f64 = 1.0 / 1024.0;

/// The FMU of the machine, made of a released one.
fn configured(folder: &TempDir, version: &str) -> Result<PathBuf> {
    let source = std::fs::read(fmus().join(version).join("PneumaticServoCylinder.fmu"))?;
    let law = ("friction.law".to_owned(), Given::Item("LuGre".to_owned()));
    let values = VALUES.map(|(name, value)| (name.to_owned(), Given::Number(value)));
    let machine = Machine {
        name: "Axis7".to_owned(),
        values: values.into_iter().chain([law]).collect(),
        interface: Interface { preset: Preset::Minimal, ..Interface::default() },
        ..Machine::default()
    };
    let file = folder.path().join("Axis7.fmu");
    std::fs::write(&file, export(&source, &[&MODEL], &machine)?.fmu)?;
    Ok(file)
}

/// Runs an instance beside the plant.
fn same_bits<I: Version>(
    mut host: Host<'_, I>,
    mut step: impl FnMut(&mut Host<'_, I>, f64, f64) -> Result<()>,
) -> Result<()> {
    host.set_real("valveVoltage", 6.5)?;
    host.initialize()?;
    let setup = Setup::new(&MODEL).set("friction.law", "LuGre")?.set("valveVoltage", 6.5)?;
    let mut plant = VALUES.into_iter().try_fold(setup, |setup, (name, value)| setup.set(name, value))?.start(0.0)?;
    for index in 0..400 {
        let (from, to) = (f64::from(index) * STEP, f64::from(index + 1) * STEP);
        step(&mut host, from, to)?;
        plant.advance_to(to)?;
        for name in NAMES {
            let (found, expected) = (host.real(name)?, plant.get(name)?);
            ensure!(found.to_bits() == expected.to_bits(), "{name} is {found}, not {expected}, at {to} s");
        }
    }
    ensure!(host.real("position")? > 0.11, "the carriage moves");
    Ok(())
}

#[test]
fn configured_fmu_has_the_bits_of_the_plant() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let import = fmi2::open_file(&configured(&folder, "")?)?;
    same_bits(fmi2::co_simulation(&import)?, |host, from, to| host.step(from, to))
}

#[test]
fn configured_fmu_of_fmi_3_has_them_too() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let import = fmi3::open_file(&configured(&folder, "fmi3")?)?;
    same_bits(fmi3::co_simulation(&import, false)?, |host, from, to| host.step(from, to).map(|_| ()))
}
