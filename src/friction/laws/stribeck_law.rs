//! The Stribeck curve with true stiction.

use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::parameters::viscous;
use crate::friction::parts::stick_slip::SetValued;
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
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
    Stribeck {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: f64 = viscous(30.0);
    }
}

impl SetValued for Stribeck {
    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()
    }

    fn break_away(&self, level: f64) -> f64 {
        level * self.curve.static_force
    }

    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        self.curve.at(velocity.abs(), level) * direction + velocity * self.viscous
    }
}
