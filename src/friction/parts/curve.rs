//! The Stribeck curve.

use super::parameters::{check_forces, coulomb_force, exponent, static_force, stribeck_velocity};
use crate::numbers::Scalar;
use crate::parameter_group;
use crate::variables::{ParameterError, Tunable};

parameter_group! {
    /// The Stribeck curve: how friction falls from static to Coulomb friction with speed.
    ///
    /// ```text
    /// s(v) = lambda*(F_c + (F_s - F_c)*exp(-(|v|/v_s)^delta))   [N]
    /// ```
    ///
    /// For `delta < 1` its slope at `v = 0` is infinite; the curve itself is continuous.
    ///
    /// # Source
    /// Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30(7):1083-1138.
    StribeckCurve() {
        static_force: Tunable = static_force(11.0);
        coulomb_force: Tunable = coulomb_force(8.3);
        stribeck_velocity: Tunable = stribeck_velocity(0.01);
        exponent: Tunable = exponent();
    }
}

impl StribeckCurve {
    /// Checks that the forces fit together.
    ///
    /// # Errors
    /// [`ParameterError`] when the Coulomb friction exceeds the static friction.
    pub fn check(&self) -> Result<(), ParameterError> {
        check_forces(self.static_force, "Fc", self.coulomb_force)
    }

    /// Whether its slope is finite everywhere.
    pub fn is_non_stiff(&self) -> bool {
        self.exponent.value >= 1.0
    }

    /// Friction in N at a speed (a velocity's magnitude) and load factor.
    pub fn at<S: Scalar>(&self, speed: S, level: S) -> S {
        level * (self.decay(speed) * (self.static_force - self.coulomb_force) + self.coulomb_force)
    }

    /// Static excess at a speed.
    #[inline(always)]
    pub fn decay<S: Scalar>(&self, speed: S) -> S {
        faded((speed / self.stribeck_velocity).pow(self.exponent))
    }
}

/// `exp(-distance)`, and 0 where that is less than rounding leaves of 1: a carriage on its way is far from there as a rule,
/// and need not ask for it.
#[inline(always)]
pub fn faded<S: Scalar>(distance: S) -> S {
    /// `exp(-40) = 4e-18`.
    const FAR: f64 = 40.0;
    if distance.value() > FAR { S::zero() } else { (-distance).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;
    use crate::variables::Field;

    fn curve(parameters: [f64; 4]) -> StribeckCurve {
        StribeckCurve::read(&parameters.map(Tunable::still)).unwrap()
    }

    fn at(curve: &StribeckCurve, speed: f64, level: f64) -> f64 {
        curve.at(Real::of(speed), Real::of(level)).value
    }

    #[test]
    fn curve_starts_at_static_and_ends_at_coulomb_friction() {
        let curve = curve([11.0, 8.3, 0.01, 0.5]);
        assert_eq!(at(&curve, 0.0, 1.0), 11.0);
        assert_eq!(at(&curve, 1e6, 1.0), 8.3);
        assert_eq!(at(&curve, 0.0, 2.0), 22.0);
    }

    #[test]
    fn excess_decays_to_one_over_e_at_the_stribeck_velocity() {
        for exponent in [0.5, 1.0, 2.0] {
            let curve = curve([2.0, 1.0, 0.01, exponent]);
            assert!((at(&curve, 0.01, 1.0) - 1.0 - (-1.0f64).exp()).abs() < 1e-15);
        }
    }

    #[test]
    fn what_has_faded_is_below_the_rounding_of_one() {
        for distance in [0.0f64, 1.0, 39.9, 40.0, 40.1, 800.0] {
            let error = faded(Real::of(distance)).value - (-distance).exp();
            assert!(error.abs() <= f64::EPSILON * (-distance).exp() + f64::EPSILON / 50.0, "{distance}: {error}");
        }
        assert!(faded(Real::of(f64::NAN)).value.is_nan(), "what is no number stays none");
    }

    #[test]
    fn coulomb_above_static_friction_is_refused_by_name_and_value() {
        let error = curve([1.0, 2.0, 0.01, 2.0]).check().unwrap_err();
        assert_eq!((error.variable.as_str(), error.value), ("Fc", 2.0));
    }
}
