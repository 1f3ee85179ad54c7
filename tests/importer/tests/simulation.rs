//! Runs through the crate `fmi` give the bits of the plant, and states can be saved.

use anyhow::{Context, Result, ensure};
use fmi::fmi2::instance::{Common, InstanceCS};
use importer::Host;
use importer::fmi2::{co_simulation, open};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Setup;
use pneumatic_servo::models::pneumatic_servo_cylinder;

const MODEL: &str = "PneumaticServoCylinder";

/// The default experiment under every law, beside the plant itself.
#[test]
fn default_experiment_has_the_bits_of_the_plant() -> Result<()> {
    let import = open(MODEL)?;
    let experiment = &pneumatic_servo_cylinder::MODEL.experiment;
    let signal = experiment.signal("valveVoltage").context("the default experiment moves the voltage")?;
    for (id, law, _) in LAWS.items {
        let mut host = co_simulation(&import)?;
        host.set_integer("friction.law", *id)?;
        host.initialize()?;
        let mut plant = Setup::new(&pneumatic_servo_cylinder::MODEL).set("friction.law", *id)?.start(0.0)?;
        for step in 0..experiment.steps() {
            let [time, next] = [step, step + 1].map(|step| f64::from(step) * experiment.step_size);
            host.set_real("valveVoltage", signal.course.at(time))?;
            plant.set("valveVoltage", signal.course.at(time))?;
            host.step(time, next)?;
            // A host gives a point and the size of a step, whose sum may be rounded.
            plant.advance_to(time + (next - time))?;
            for name in ["position", "velocity", "frictionForce", "chamberA.pressure", "chamberB.temperature"] {
                let (found, expected) = (host.real(name)?, plant.get(name)?);
                ensure!(found.to_bits() == expected.to_bits(), "{law}: {name} is {found}, not {expected}, at {next} s");
            }
            ensure!(f64::from(host.boolean("sticking")?) == plant.get("sticking")?, "{law} at {next} s");
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
