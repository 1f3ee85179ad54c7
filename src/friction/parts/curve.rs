//! The Stribeck curve.

use super::parameters::check_levels;
use crate::numbers::Scalar;
use crate::variables::ParameterError;

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
