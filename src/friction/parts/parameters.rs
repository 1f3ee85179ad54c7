//! Parameters that many laws share.

use crate::variables::{Meaning, ParameterError, Tunable, Variable, units};

/// Refuses a Coulomb friction above the static friction `Fs`.
///
/// # Errors
/// [`ParameterError`] that names the Coulomb friction.
pub fn check_forces(static_force: Tunable, name: &str, coulomb_force: Tunable) -> Result<(), ParameterError> {
    let [static_force, coulomb_force] = [static_force, coulomb_force].map(|force| force.value);
    if coulomb_force > static_force {
        let reason = format!("it must not exceed the static friction Fs = {static_force}");
        return Err(ParameterError::new(name, coulomb_force, &reason));
    }
    Ok(())
}

const MAX_FORCE: f64 = 1e6;

/// Static friction `Fs`, value reference 0.
pub fn static_force(default: f64) -> Variable {
    Variable::parameter(0, "Fs", units::NEWTON, default)
        .range(0.0, MAX_FORCE)
        .meaning(Meaning::StaticFriction)
        .text("Static friction: force at which sliding starts")
}

/// Coulomb friction `Fc`, value reference 1.
pub fn coulomb_force(default: f64) -> Variable {
    force(1, "Fc", default)
        .meaning(Meaning::CoulombFriction)
        .text("Coulomb friction: force of fast sliding without the viscous part")
}

/// Stribeck velocity `vs`, value reference 2.
pub fn stribeck_velocity(default: f64) -> Variable {
    velocity(2, "vs", default).text("Stribeck velocity: speed at which the static excess has decayed to 1/e")
}

/// Stribeck exponent `delta`, value reference 3.
pub fn exponent() -> Variable {
    Variable::parameter(3, "delta", units::ONE, 2.0)
        .meaning(Meaning::StribeckExponent)
        .range(0.1, 10.0)
        .text("Stribeck exponent: 2 bell-shaped, 1 exponential, below 1 infinitely steep at zero velocity")
}

/// Viscous friction `sigma2`, value reference 4.
pub fn viscous(default: f64) -> Variable {
    damping(4, "sigma2", default).meaning(Meaning::ViscousFriction).text("Viscous friction coefficient")
}

/// Another friction force.
pub fn force(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::NEWTON, default).range(0.0, MAX_FORCE)
}

/// Another characteristic velocity.
pub fn velocity(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::METRE_PER_SECOND, default)
        .range(1e-9, 1e6)
        .plausible(1e-5 * default, 200.0 * default)
        .shown_in("mm/s")
}

/// Another damping coefficient.
pub fn damping(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::NEWTON_SECOND_PER_METRE, default).range(0.0, 1e7)
}

/// A time at rest `gamma`.
pub fn dwell_time(reference: u32, default: f64) -> Variable {
    Variable::parameter(reference, "gamma", units::SECOND, default).range(1e-6, 1e6).plausible(1e-6, 50.0)
}

/// A contact stiffness.
pub fn stiffness(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::NEWTON_PER_METRE, default).range(1.0, 1e10).plausible(1e4, 1e10)
}

/// A microscopic length.
pub fn length(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::METRE, default).range(1e-9, 1.0).plausible(1e-9, 2e-3)
}
