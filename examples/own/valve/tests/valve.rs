//! Closed forms and balances of the pair of valves, on the cylinder of the library.

use own_valve::CYLINDER;
use pneumatic_servo::conformance;
use pneumatic_servo::prelude::*;

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

fn cylinder() -> Outcome<Setup> {
    Ok(Setup::new(&CYLINDER).set("actuation", "ValvePair")?.set("supplyPressure", 6e5)?)
}

/// Spools follow `s = e*(1 - exp(-t/tau))`, which the plant has in closed form: rounding remains.
#[test]
fn spools_lag_behind_the_voltage() -> Outcome {
    let mut plant = cylinder()?.set("valveVoltage", 7.5)?.start(0.0)?;
    for step in 1..=20 {
        plant.step(1e-3)?;
        let expected = 0.5 * (1.0 - (-f64::from(step) * 1e-3 / 5e-3f64).exp());
        assert!((plant.get("valvePair.spoolA")? - expected).abs() < 1e-12);
        assert!((plant.get("valvePair.spoolB")? + expected).abs() < 1e-12);
    }
    Ok(())
}

/// Choked flow of ISO 6358 at the reference temperature: `C*p*rho0`, with `rho0 = 1.185 kg/m3`.
#[test]
fn open_valve_has_the_choked_flow() -> Outcome {
    let mut plant = cylinder()?.set("valveVoltage", 10.0)?.set("friction.law", "Coulomb")?;
    plant.change("friction.coulomb.Fc", 1e5)?;
    let mut plant = plant.start(0.0)?;
    plant.advance_to(0.005)?;
    let opening = plant.get("valvePair.spoolA")?;
    let expected = opening * 4e-9 * 6e5 * 1.185;
    let found = plant.get("chamberA.massFlow")?;
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} kg/s, not {expected} kg/s");
    Ok(())
}

/// The mass in the chambers is the inflow, to the solver's tolerance of a millionth of the flowing gram; the carriage moves
/// both ways.
#[test]
fn carriage_moves_both_ways_and_no_air_is_lost() -> Outcome {
    let mut plant = cylinder()?.set("balance.enabled", true)?.start(0.0)?;
    for (voltage, until, ahead) in [(8.0, 0.4, 1.0), (2.0, 1.0, -1.0)] {
        let before = plant.get("position")?;
        plant.set("valveVoltage", voltage)?;
        plant.advance_to(until)?;
        assert!(ahead * (plant.get("position")? - before) > 0.05, "{voltage} V");
    }
    let lost = plant.get("balance.massResidual")?;
    assert!(lost.abs() < 1e-9, "{lost} kg");
    Ok(())
}

/// The cylinder keeps the promises of models with it, with explicit and with implicit steps: both spools act on the
/// flow, and every scheme sees it.
#[test]
fn cylinder_keeps_what_models_promise() -> Outcome {
    for law in ["Stribeck", "SmoothCoulomb"] {
        conformance::run(&cylinder()?.set("friction.law", law)?.set("valveVoltage", 6.0)?);
    }
    Ok(())
}
