//! A magic-formula curve through zero velocity.

use std::f64::consts::{FRAC_2_PI, PI};

use crate::friction::parts::of_velocity::VelocityLaw;
use crate::friction::parts::parameters::{coulomb_force, static_force, stribeck_velocity, viscous};
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::{ParameterError, ParameterSet, Tunable, Variable, units};

parameters! {
    /// Parameters of [`VelocityBased`].
    Parameters {
        static_force: Tunable = static_force(11.0);
        coulomb_force: Tunable = coulomb_force(8.3);
        peak_velocity: Tunable = stribeck_velocity(0.01).text("Velocity at which the curve peaks at Fs");
        viscous: Tunable = viscous(30.0);
        curvature: Tunable = Variable::parameter(5, "E", units::ONE, 0.0)
            .range(-100.0, 0.99)
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
    shape: Tunable,
    stiffness: Tunable,
}

impl ParameterSet for VelocityBased {
    const LEN: usize = Parameters::LEN;

    fn table() -> Vec<Variable> {
        Parameters::table()
    }

    fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
        let p = Parameters::read(values)?;
        let [statics, coulomb] = [p.static_force, p.coulomb_force].map(|force| force.value);
        if coulomb >= statics {
            let reason = format!("it must be below the static friction Fs = {statics}, or the curve has no peak");
            return Err(ParameterError::new("Fc", coulomb, &reason));
        }
        let ratio = p.coulomb_force / p.static_force;
        let angle = ratio.chain(libm::asin(ratio.value), 1.0 / (1.0 - ratio.value * ratio.value).sqrt());
        let shape = -angle * FRAC_2_PI + 2.0;
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
fn peak_argument(shape: Tunable, curvature: Tunable) -> Tunable {
    let quarter = Tunable::still(PI) / (shape * 2.0);
    let target = libm::tan(quarter.value);
    let bent = |q: f64| q - (q - libm::atan(q)) * curvature.value;
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
    // The argument moves with the target and with the curvature as the equation that it solves does.
    let rise = 1.0 - curvature.value * high * high / (1.0 + high * high);
    let by_target = 1.0 + target * target;
    let slope = |i: usize| (by_target * quarter.slopes[i] + (high - libm::atan(high)) * curvature.slopes[i]) / rise;
    Tunable { value: high, slopes: std::array::from_fn(slope) }
}
