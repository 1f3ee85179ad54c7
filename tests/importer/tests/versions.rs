//! Both versions and both kinds, through the crate `fmi`: the same step response, the same events.

use anyhow::Result;
use fmi::EventFlags;
use fmi::fmi3::CoSimulation;
use fmi::fmi3::instance::InstanceCS;
use fmi::traits::{FmiEventHandler, FmiInstance};
use importer::{Exchange, Host, Integrator, Version, fmi2 as two, fmi3 as three};
use pneumatic_servo::friction::LAWS;

const MODEL: &str = "PneumaticServoCylinder";
const COULOMB: i32 = 2;
const STRIBECK: i32 = 7;
const NAMES: [&str; 5] = ["position", "velocity", "frictionForce", "chamberA.pressure", "chamberB.pressure"];

/// The voltage jumps twice: the carriage breaks away, stops, and breaks away to the other side.
fn voltage(step: u32) -> f64 {
    if step < 150 { 6.5 } else { 3.5 }
}

const STEPS: u32 = 350;

fn time(step: u32) -> f64 {
    f64::from(step) * 1e-3
}

/// Chooses a law, by number since the crate reads no enumerations of FMI 3.0, and initializes.
fn begin<I: Version>(host: &mut Host<'_, I>, law: i32, tolerance: f64) -> Result<()> {
    host.set_integer("friction.lawNumber", law)?;
    host.set_real("solver.relativeTolerance", tolerance)?;
    host.set_real("valveVoltage", voltage(0))?;
    host.initialize()
}

fn look<I: Version>(host: &mut Host<'_, I>) -> Result<[f64; 5]> {
    let mut values = [f64::NAN; 5];
    for (value, name) in values.iter_mut().zip(NAMES) {
        *value = host.real(name)?;
    }
    Ok(values)
}

#[test]
fn co_simulation_of_fmi_3_has_the_bits_of_fmi_2_under_every_law() -> Result<()> {
    let (import2, import3) = (two::open(MODEL)?, three::open(MODEL)?);
    for (id, law, _) in LAWS.items {
        let (mut old, mut new) = (two::co_simulation(&import2)?, three::co_simulation(&import3, false)?);
        begin(&mut old, *id, 1e-6)?;
        begin(&mut new, *id, 1e-6)?;
        for step in 0..STEPS {
            old.set_real("valveVoltage", voltage(step))?;
            new.set_real("valveVoltage", voltage(step))?;
            let (from, to) = (time(step), time(step + 1));
            old.step(from, to)?;
            assert_eq!(new.step(from, to)?, three::Step { event: false, reached: to });
            assert_eq!(look(&mut old)?.map(f64::to_bits), look(&mut new)?.map(f64::to_bits), "{law} at {to} s");
        }
        assert_eq!(old.integer("solver.events")?, new.integer("solver.events")?, "{law}");
    }
    Ok(())
}

/// Lets what is pending happen, and a voltage jump before it.
fn handle_event(host: &mut Host<'_, InstanceCS>, voltage: f64) -> Result<()> {
    host.instance.enter_event_mode()?;
    host.set_real("valveVoltage", voltage)?;
    update(host)
}

/// Updates once, which is enough, and goes on to take steps.
fn update(host: &mut Host<'_, InstanceCS>) -> Result<()> {
    let mut flags = EventFlags::default();
    host.instance.update_discrete_states(&mut flags)?;
    assert_eq!(flags, EventFlags::default());
    host.instance.enter_step_mode()?;
    Ok(())
}

#[test]
fn steps_of_fmi_3_end_at_break_away_and_at_the_stop() -> Result<()> {
    let import = three::open(MODEL)?;
    let (mut plain, mut hybrid) = (three::co_simulation(&import, false)?, three::co_simulation(&import, true)?);
    begin(&mut plain, STRIBECK, 1e-6)?;
    begin(&mut hybrid, STRIBECK, 1e-6)?;
    update(&mut hybrid)?;
    let mut told = Vec::new();
    for step in 0..STEPS {
        plain.set_real("valveVoltage", voltage(step))?;
        handle_event(&mut hybrid, voltage(step))?;
        let (mut from, to) = (time(step), time(step + 1));
        plain.step(from, to)?;
        while from < to {
            let three::Step { event, reached } = hybrid.step(from, to)?;
            if event {
                let before = hybrid.boolean("sticking")?;
                handle_event(&mut hybrid, voltage(step))?;
                told.push((before, hybrid.boolean("sticking")?));
            }
            from = reached;
        }
        assert_eq!(look(&mut plain)?.map(f64::to_bits), look(&mut hybrid)?.map(f64::to_bits), "at {to} s");
    }
    assert_eq!(told, [(true, false), (false, true), (true, false)]);
    assert_eq!(plain.integer("solver.events")?, told.len() as i32);
    Ok(())
}

/// The response with a solver outside, as it is at each millisecond, and the number of events on the way.
fn outside<I: Exchange>(mut host: Host<'_, I>, law: i32) -> Result<(Vec<[f64; 5]>, usize)> {
    begin(&mut host, law, 1e-6)?;
    let mut run = Integrator::new(host, 2e-5)?;
    let mut course = Vec::new();
    for step in 0..STEPS {
        if step > 0 && voltage(step) != voltage(step - 1) {
            run.set_input("valveVoltage", voltage(step))?;
        }
        run.advance(time(step + 1))?;
        course.push(look(&mut run.host)?);
    }
    assert_eq!(run.host.integer("solver.events")?, run.events as i32);
    Ok((course, run.events))
}

#[test]
fn model_exchange_of_both_versions_agrees_with_co_simulation() -> Result<()> {
    let (import2, import3) = (two::open(MODEL)?, three::open(MODEL)?);
    for law in [COULOMB, STRIBECK] {
        let (course, events) = outside(three::exchange(&import3)?, law)?;
        let bits = |course: &[[f64; 5]]| course.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
        let (course2, events2) = outside(two::exchange(&import2)?, law)?;
        assert_eq!((bits(&course2), events2), (bits(&course), events), "law {law}");
        let mut inside = two::co_simulation(&import2)?;
        begin(&mut inside, law, 1e-9)?;
        // The bounds that all ways of running the plant keep to; with this step the two are 2e-9 m and 0.01 Pa apart.
        for (step, found) in (0..STEPS).zip(course) {
            inside.set_real("valveVoltage", voltage(step))?;
            inside.step(time(step), time(step + 1))?;
            for (name, bound) in [("position", 1e-7), ("chamberA.pressure", 1.0), ("chamberB.pressure", 1.0)] {
                let found = found[NAMES.iter().position(|it| *it == name).expect("one of the names")];
                let expected = inside.real(name)?;
                assert!((found - expected).abs() <= bound, "law {law}: {name} {found}, not {expected}, in step {step}");
            }
        }
        assert_eq!(inside.integer("solver.events")?, events as i32, "law {law}");
        assert!(events >= 3, "{events} events");
    }
    Ok(())
}

#[test]
fn versions_are_told() -> Result<()> {
    let import = three::open(MODEL)?;
    assert_eq!(three::co_simulation(&import, false)?.instance.get_version(), "3.0");
    assert_eq!(three::exchange(&import)?.instance.get_version(), "3.0");
    Ok(())
}
