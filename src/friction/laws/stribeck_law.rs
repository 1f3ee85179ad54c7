//! The Stribeck curve with true stiction.

use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::parameters::{coulomb_force, exponent, static_force, stribeck_velocity, viscous};
use crate::friction::parts::stick_slip::SetValued;
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
    /// Parameters of [`Stribeck`].
    Parameters {
        static_force: f64 = static_force(11.0);
        coulomb_force: f64 = coulomb_force(8.3);
        stribeck_velocity: f64 = stribeck_velocity(0.01);
        exponent: f64 = exponent();
        viscous: f64 = viscous(30.0);
    }
}

/// Stribeck friction, set-valued at rest.
///
/// ```text
/// stuck:    v = 0, F = F_applied         while |F_applied| <= lambda*F_s
/// sliding:  F = s(v)*sgn(v) + sigma2*v   [N], s the Stribeck curve
/// ```
///
/// With `delta = 1` this is Benson's velocity-dependent law; with `delta = 1` and `F_c = F_s/2` the
/// Coulomb-Stribeck law of the vibro-impact literature.
///
/// # Errors
/// [`ParameterError`] for `F_c > F_s`.
#[derive(Clone, Debug)]
pub struct Stribeck {
    curve: StribeckCurve,
    viscous: f64,
}

impl SetValued for Stribeck {
    type Parameters = Parameters;

    fn new(p: Parameters) -> Result<Self, ParameterError> {
        let curve = StribeckCurve::new(p.static_force, p.coulomb_force, p.stribeck_velocity, p.exponent)?;
        Ok(Self { curve, viscous: p.viscous })
    }

    fn break_away(&self, level: f64) -> f64 {
        level * self.curve.static_force
    }

    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        self.curve.level(velocity.abs(), level) * direction + velocity * self.viscous
    }
}
