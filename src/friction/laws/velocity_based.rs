//! A magic-formula curve through zero velocity.

use std::f64::consts::{FRAC_2_PI, PI};

use crate::friction::parts::of_velocity::VelocityLaw;
use crate::friction::parts::parameters::{coulomb_force, static_force, stribeck_velocity, viscous};
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::{ParameterError, ParameterSet, Variable, units};

parameters! {
    /// Parameters of [`VelocityBased`].
    Parameters {
        static_force: f64 = static_force(11.0);
        coulomb_force: f64 = coulomb_force(8.3);
        peak_velocity: f64 = stribeck_velocity(0.01).text("Velocity at which the curve peaks at Fs");
        viscous: f64 = viscous(30.0);
        curvature: f64 = Variable::parameter(5, "E", units::ONE, 0.0)
            .range(-100.0, 0.99)
            .tunable()
            .text("Curvature factor of the magic formula");
    }
}

/// Velocity-based friction: a smooth odd curve that rises from 0 to `F_s` at `v_s` and falls to `F_c`.
///
/// ```text
/// F = lambda*F_s*sin(C*atan(B*v - E*(B*v - atan(B*v)))) + sigma2*v   [N]
/// C = 2 - (2/pi)*asin(F_c/F_s),   B > 0 such that the peak lies at v_s
/// ```
///
/// # Validity
/// No stiction: under any load the mass creeps.
///
/// # Errors
/// [`ParameterError`] unless `F_c < F_s`.
///
/// # Source
/// The curve is the magic formula of Bakker, Nyborg, Pacejka (1987), SAE paper 870421.
#[derive(Clone, Debug)]
pub struct VelocityBased {
    parameters: Parameters,
    shape: f64,
    stiffness: f64,
}

impl ParameterSet for VelocityBased {
    const LEN: usize = Parameters::LEN;

    fn table() -> Vec<Variable> {
        Parameters::table()
    }

    fn read(values: &[f64]) -> Result<Self, ParameterError> {
        let p = Parameters::read(values)?;
        if p.coulomb_force >= p.static_force {
            let reason =
                format!("it must be below the static friction Fs = {}, or the curve has no peak", p.static_force);
            return Err(ParameterError::new("Fc", p.coulomb_force, &reason));
        }
        let shape = 2.0 - FRAC_2_PI * libm::asin(p.coulomb_force / p.static_force);
        let stiffness = peak_argument(shape, p.curvature) / p.peak_velocity;
        Ok(Self { parameters: p, shape, stiffness })
    }
}

impl VelocityLaw for VelocityBased {
    fn force<S: Scalar>(&self, velocity: S, level: S) -> S {
        let argument = velocity * self.stiffness;
        let bent = argument - (argument - argument.atan()) * self.parameters.curvature;
        let curve = (bent.atan() * self.shape).sin();
        level * curve * self.parameters.static_force + velocity * self.parameters.viscous
    }
}

/// The `q > 0` with `q - E*(q - atan(q)) = tan(pi/(2*C))`, where the sine reaches 1: bisection of a rising function.
fn peak_argument(shape: f64, curvature: f64) -> f64 {
    let target = libm::tan(PI / (2.0 * shape));
    let bent = |q: f64| q - curvature * (q - libm::atan(q));
    let (mut low, mut high) = (0.0, 1.0);
    while bent(high) < target {
        high *= 2.0;
    }
    while high - low > f64::EPSILON * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if bent(middle) < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
