//! The Stribeck curve and the parameters that many laws share.

use crate::scalar::Scalar;
use crate::variables::{ParameterError, Variable, units};

/// The Stribeck curve: how the friction level falls from static to Coulomb friction with speed.
///
/// ```text
/// s(v) = lambda*(F_c + (F_s - F_c)*exp(-(|v|/v_s)^delta))   [N]
/// ```
///
/// For `delta < 1` its slope at `v = 0` is infinite; the curve itself is continuous.
///
/// # Source
/// Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30(7):1083-1138.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StribeckCurve {
    /// Static friction in N.
    pub static_force: f64,
    /// Coulomb friction in N.
    pub coulomb_force: f64,
    /// Stribeck velocity in m/s.
    pub stribeck_velocity: f64,
    /// Stribeck exponent.
    pub exponent: f64,
}

impl StribeckCurve {
    /// Checks that the levels fit together.
    ///
    /// # Errors
    /// [`ParameterError`] when the Coulomb friction exceeds the static friction.
    pub fn new(
        static_force: f64,
        coulomb_force: f64,
        stribeck_velocity: f64,
        exponent: f64,
    ) -> Result<Self, ParameterError> {
        check_levels(static_force, "Fc", coulomb_force)?;
        Ok(Self { static_force, coulomb_force, stribeck_velocity, exponent })
    }

    /// Friction level in N at a speed (a velocity's magnitude) and load level.
    pub fn level<S: Scalar>(&self, speed: S, level: S) -> S {
        let decay = (-(speed / self.stribeck_velocity).powf(self.exponent)).exp();
        level * (decay * (self.static_force - self.coulomb_force) + self.coulomb_force)
    }
}

/// Refuses a Coulomb friction above the static friction `Fs`.
///
/// # Errors
/// [`ParameterError`] that names the Coulomb friction.
pub fn check_levels(static_force: f64, name: &str, coulomb_force: f64) -> Result<(), ParameterError> {
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
        .tunable()
        .text("Static friction: force at which sliding starts")
}

/// Coulomb friction `Fc`, value reference 1.
pub fn coulomb_force(default: f64) -> Variable {
    force_level(1, "Fc", default).text("Coulomb friction: force of fast sliding without the viscous part")
}

/// Stribeck velocity `vs`, value reference 2.
pub fn stribeck_velocity(default: f64) -> Variable {
    velocity(2, "vs", default).text("Stribeck velocity: speed at which the static excess has decayed to 1/e")
}

/// Stribeck exponent `delta`, value reference 3.
pub fn exponent() -> Variable {
    Variable::parameter(3, "delta", units::ONE, 2.0)
        .range(0.1, 10.0)
        .tunable()
        .text("Stribeck exponent: 2 bell-shaped, 1 exponential, below 1 infinitely steep at zero velocity")
}

/// Viscous friction `sigma2`, value reference 4.
pub fn viscous(default: f64) -> Variable {
    damping(4, "sigma2", default).text("Viscous friction coefficient")
}

/// Another force level.
pub fn force_level(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::NEWTON, default).range(0.0, MAX_FORCE).tunable()
}

/// Another characteristic velocity.
pub fn velocity(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::METRE_PER_SECOND, default).range(1e-9, 1e6).shown_in("mm/s").tunable()
}

/// Another damping coefficient.
pub fn damping(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::NEWTON_SECOND_PER_METRE, default).range(0.0, 1e7).tunable()
}

/// A contact stiffness.
pub fn stiffness(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::NEWTON_PER_METRE, default).range(1.0, 1e10).tunable()
}

/// A microscopic length.
pub fn length(reference: u32, name: &str, default: f64) -> Variable {
    Variable::parameter(reference, name, units::METRE, default).range(1e-9, 1.0).tunable()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_starts_at_static_and_ends_at_coulomb_friction() {
        let curve = StribeckCurve::new(11.0, 8.3, 0.01, 0.5).unwrap();
        assert_eq!(curve.level(0.0, 1.0), 11.0);
        assert_eq!(curve.level(1e6, 1.0), 8.3);
        assert_eq!(curve.level(0.0, 2.0), 22.0);
    }

    #[test]
    fn excess_decays_to_one_over_e_at_the_stribeck_velocity() {
        for exponent in [0.5, 1.0, 2.0] {
            let curve = StribeckCurve::new(2.0, 1.0, 0.01, exponent).unwrap();
            assert!((curve.level(0.01, 1.0) - 1.0 - (-1.0f64).exp()).abs() < 1e-15);
        }
    }

    #[test]
    fn coulomb_above_static_friction_is_refused_by_name_and_value() {
        let error = StribeckCurve::new(1.0, 2.0, 0.01, 2.0).unwrap_err();
        assert_eq!((error.variable.as_str(), error.value), ("Fc", 2.0));
    }
}
