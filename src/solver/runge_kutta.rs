//! Explicit schemes, as tables of Butcher.

use super::array;
use super::relaxing::Relaxing;
use super::run::Trial;
use crate::hybrid::{Held, HybridSystem, Led};

/// An explicit Runge-Kutta method in which each stage uses the one before only.
pub struct Tableau {
    /// Time of each stage within the step, which is also the weight of the stage before.
    times: &'static [f64],
    /// Weights of the stages in the result.
    weights: &'static [f64],
}

/// Explicit Euler method.
pub const EXPLICIT_EULER: Tableau = Tableau { times: &[0.0], weights: &[1.0] };

/// Method of order 3 of Ralston (1962), Mathematics of Computation 16:431-437.
pub const RK3: Tableau = Tableau { times: &[0.0, 0.5, 0.75], weights: &[2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0] };

/// Classical method of order 4 of Kutta (1901).
pub const RK4: Tableau =
    Tableau { times: &[0.0, 0.5, 0.5, 1.0], weights: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0] };

impl Tableau {
    /// One step of size `h` from given derivatives at its start.
    // One function for all these methods, which nobody takes for their speed.
    #[inline(never)]
    #[allow(clippy::too_many_arguments, reason = "the system, where it is, and the step")]
    pub fn step<H: HybridSystem<N, U>, const N: usize, const U: usize>(
        &self,
        system: &H,
        time: f64,
        x: &[f64; N],
        inputs: &Held<U>,
        memory: &H::Memory,
        derivatives: &[f64; N],
        h: f64,
    ) -> Trial<N> {
        let mut slope = *derivatives;
        let mut end = *x;
        for (stage, (fraction, weight)) in self.times.iter().zip(self.weights).enumerate() {
            if stage > 0 {
                let argument = array(|i| x[i] + fraction * h * slope[i]);
                let stage_time = time + fraction * h;
                slope = system.derivatives(stage_time, &argument, &inputs.at(stage_time), memory);
            }
            for i in 0..N {
                end[i] += h * weight * slope[i];
            }
        }
        Trial { end, error: [0.0; N] }
    }
}

/// A step of the classical method, and what is to be known of it besides.
pub struct Classical<const N: usize> {
    /// The step.
    pub trial: Trial<N>,
    /// Derivatives at its end.
    pub slope: [f64; N],
    /// By how much the midpoint rule differs from that of Simpson: an error of order 2, which sees kinks.
    pub bend: [f64; N],
}

/// One step of size `h` of the classical method, with the error of one of order 3.
///
/// Up to order 2 the last stage agrees with the derivatives at the end, so that half of their difference can be moved
/// from the one to the other: the weights 1/6, 1/3, 1/3, -1/3, 1/2 are still of order 3. For a rate `r` the error found
/// is `(r*h)^4*(2 - r*h)/48`, which is more than the `(r*h)^5/120` that a step lacks at all sizes that are stable. With a
/// tenth it is not, and long steps let their errors add up.
///
/// States that follow held inputs alone are those of their closed form, if they are given, in every stage. Their
/// derivatives are then left to [`HybridSystem::refresh`]. A state that relaxes takes the weights that are given for it in
/// place of those of the method.
///
/// Inlined, so that it is compiled once with and once without them.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "the system, where it is, and the step")]
pub fn classical<H: HybridSystem<N, U>, const N: usize, const U: usize>(
    system: &H,
    time: f64,
    x: &[f64; N],
    inputs: &Held<U>,
    memory: &H::Memory,
    derivatives: &[f64; N],
    h: f64,
    led: Option<&Led<[f64; N]>>,
    relaxing: Option<&Relaxing>,
) -> Classical<N> {
    let placed = |mut states: [f64; N], part: fn(&Led<[f64; N]>) -> &[f64; N]| {
        if let Some(led) = led {
            states[..H::LED].copy_from_slice(&part(led)[..H::LED]);
        }
        states
    };
    let relaxing = H::RELAXING.zip(relaxing);
    let rates = |fraction: f64, states: &[f64; N]| {
        let (at, u) = (time + fraction * h, inputs.at(time + fraction * h));
        if led.is_some() { system.driven(at, states, &u, memory) } else { system.derivatives(at, states, &u, memory) }
    };
    let drive =
        |x: &[f64; N], slope: &[f64; N]| relaxing.map_or(0.0, |(state, weights)| weights.drive(x[state], slope[state]));
    let along = |fraction: f64, slope: &[f64; N]| array(|i| x[i] + fraction * h * slope[i]);

    let first = derivatives;
    let drive_1 = drive(x, first);
    let x_2 = placed(along(0.5, first), |led| &led.middle);
    let x_2 = relaxed(x_2, relaxing, |state, weights| weights.second(x[state], drive_1));
    let second = rates(0.5, &x_2);
    let drive_2 = drive(&x_2, &second);
    let x_3 = placed(along(0.5, &second), |led| &led.middle);
    let x_3 = relaxed(x_3, relaxing, |state, weights| weights.third(x_2[state], [drive_1, drive_2]));
    let third = rates(0.5, &x_3);
    let drive_3 = drive(&x_3, &third);
    let x_4 = placed(along(1.0, &third), |led| &led.end);
    let x_4 = relaxed(x_4, relaxing, |state, weights| weights.fourth(x[state], [drive_1, drive_3]));
    let fourth = rates(1.0, &x_4);
    let drives = [drive_1, drive_2, drive_3, drive(&x_4, &fourth)];

    let sixth = h / 6.0;
    let outer: [f64; N] = array(|i| first[i] + fourth[i]);
    let inner: [f64; N] = array(|i| second[i] + third[i]);
    let end = placed(array(|i| x[i] + sixth * (outer[i] + 2.0 * inner[i])), |led| &led.end);
    let end = relaxed(end, relaxing, |state, weights| weights.end(x[state], drives));
    let slope = rates(1.0, &end);
    let last_drive = drive(&end, &slope);
    let error = placed(array(|i| 0.5 * h * (fourth[i] - slope[i])), |led| &led.bend);
    let error = relaxed(error, relaxing, |_, weights| weights.error(drives[3], last_drive));
    let bend = placed(array(|i| sixth * (outer[i] - inner[i])), |led| &led.bend);
    let bend = relaxed(bend, relaxing, |_, weights| weights.bend(drives));
    Classical { trial: Trial { end, error }, slope, bend }
}

/// States, or errors of states, of which that of the relaxing one follows from its weights, if it is to relax.
#[inline(always)]
fn relaxed<const N: usize>(
    mut states: [f64; N],
    relaxing: Option<(usize, &Relaxing)>,
    value: impl Fn(usize, &Relaxing) -> f64,
) -> [f64; N] {
    if let Some((state, weights)) = relaxing {
        states[state] = value(state, weights);
    }
    states
}
