//! Runs through the crate `fmi` give the same bits as those through FMPy, and states can be saved.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use fmi::fmi2::instance::{Common, InstanceCS};
use importer::fmi2::{co_simulation, open};
use importer::{Host, gallery};
use pneumatic_servo::friction::LAWS;

const MODEL: &str = "PneumaticServoCylinder";

/// The columns of a result that the gallery holds.
fn results(law: &str) -> Result<BTreeMap<String, Vec<f64>>> {
    let file = gallery().join(MODEL).join(format!("{law}.csv"));
    let text = std::fs::read_to_string(&file)
        .with_context(|| format!("cannot read {}: run `cargo xtask gallery` first", file.display()))?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().context("no header")?.split(',').collect();
    let mut columns: BTreeMap<String, Vec<f64>> = names.iter().map(|name| ((*name).to_owned(), Vec::new())).collect();
    for line in lines {
        for (name, cell) in names.iter().zip(line.split(',')) {
            columns.entry((*name).to_owned()).or_default().push(cell.parse()?);
        }
    }
    ensure!(columns["time"].len() > 1000, "{} holds too few rows", file.display());
    Ok(columns)
}

#[test]
fn default_experiment_has_the_bits_that_fmpy_found() -> Result<()> {
    let import = open(MODEL)?;
    for (id, law, _) in LAWS.items {
        let columns = results(law)?;
        let (times, voltages) = (&columns["time"], &columns["valveVoltage"]);
        let mut host = co_simulation(&import)?;
        host.set_integer("friction.law", *id)?;
        host.initialize()?;
        for row in 0..times.len() {
            host.set_real("valveVoltage", voltages[row])?;
            for name in ["position", "velocity", "frictionForce", "chamberA.pressure", "chamberB.temperature"] {
                let (found, expected) = (host.real(name)?, columns[name][row]);
                assert_eq!(found.to_bits(), expected.to_bits(), "{law}, {name} at {} s", times[row]);
            }
            assert_eq!(f64::from(host.boolean("sticking")?), columns["sticking"][row], "{law} at {} s", times[row]);
            if let Some(next) = times.get(row + 1) {
                host.step(times[row], *next)?;
            }
        }
    }
    Ok(())
}

#[test]
fn serialized_state_goes_on_in_another_instance() -> Result<()> {
    let import = open(MODEL)?;
    let mut first = co_simulation(&import)?;
    first.initialize()?;
    first.set_real("valveVoltage", 6.5)?;
    advance(&mut first, 0, 400)?;
    let state = first.instance.get_fmu_state()?;
    let bytes = first.instance.serialize_fmu_state(&state)?;
    advance(&mut first, 400, 800)?;

    let mut second = co_simulation(&import)?;
    second.initialize()?;
    let state = second.instance.deserialize_fmu_state(&bytes)?;
    assert!(matches!(Result::from(second.instance.set_fmu_state(&state)), Ok(fmi::fmi2::Fmi2Res::OK)));
    advance(&mut second, 400, 800)?;
    for name in ["position", "velocity", "frictionForce", "chamberA.pressure", "chamberB.pressure"] {
        assert_eq!(first.real(name)?.to_bits(), second.real(name)?.to_bits(), "{name}");
    }
    assert!(first.real("position")? > 0.3);
    Ok(())
}

#[test]
fn instances_do_not_disturb_each_other() -> Result<()> {
    let import = open(MODEL)?;
    let alone = {
        let mut host = co_simulation(&import)?;
        host.initialize()?;
        host.set_real("valveVoltage", 6.0)?;
        advance(&mut host, 0, 300)?;
        host.real("position")?
    };
    let (mut left, mut right) = (co_simulation(&import)?, co_simulation(&import)?);
    left.initialize()?;
    right.initialize()?;
    left.set_real("valveVoltage", 6.0)?;
    right.set_real("valveVoltage", 3.0)?;
    for step in 0..300 {
        advance(&mut left, step, step + 1)?;
        advance(&mut right, step, step + 1)?;
    }
    assert_eq!(left.real("position")?.to_bits(), alone.to_bits());
    assert!(right.real("position")? < 0.25);
    Ok(())
}

#[test]
fn version_and_types_are_those_of_fmi_2() -> Result<()> {
    let import = open(MODEL)?;
    let host = co_simulation(&import)?;
    assert_eq!(host.instance.get_version(), "2.0");
    assert_eq!(host.instance.get_types_platform(), "default");
    Ok(())
}

/// Steps of 1 ms, by their numbers.
fn advance(host: &mut Host<'_, InstanceCS>, first: u32, last: u32) -> Result<()> {
    (first..last).try_for_each(|step| host.step(f64::from(step) * 1e-3, f64::from(step + 1) * 1e-3))
}
