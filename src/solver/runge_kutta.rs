//! Explicit schemes, as tables of Butcher.

use super::run::Trial;
use crate::hybrid::{Held, HybridSystem};

/// An explicit Runge-Kutta method of `S` stages in which each stage uses the one before only.
pub struct Tableau<const S: usize> {
    /// Time of each stage within the step, which is also the weight of the stage before.
    times: [f64; S],
    /// Weights of the stages in the result.
    weights: [f64; S],
}

/// Explicit Euler method.
pub const EXPLICIT_EULER: Tableau<1> = Tableau { times: [0.0], weights: [1.0] };

/// Method of order 3 of Ralston (1962), Mathematics of Computation 16:431-437.
pub const RK3: Tableau<3> = Tableau { times: [0.0, 0.5, 0.75], weights: [2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0] };

/// Classical method of order 4 of Kutta (1901).
pub const RK4: Tableau<4> =
    Tableau { times: [0.0, 0.5, 0.5, 1.0], weights: [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0] };

impl<const S: usize> Tableau<S> {
    /// One step of size `h` from given derivatives at its start.
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
        let (end, _) = self.stages(system, time, x, inputs, memory, derivatives, h);
        Trial { end, error: [0.0; N] }
    }

    /// The end of a step, and the derivatives in its last stage.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "the system, where it is, and the step")]
    fn stages<H: HybridSystem<N, U>, const N: usize, const U: usize>(
        &self,
        system: &H,
        time: f64,
        x: &[f64; N],
        inputs: &Held<U>,
        memory: &H::Memory,
        derivatives: &[f64; N],
        h: f64,
    ) -> ([f64; N], [f64; N]) {
        let mut slope = *derivatives;
        let mut end = *x;
        for stage in 0..S {
            if stage > 0 {
                let argument = std::array::from_fn(|i| x[i] + self.times[stage] * h * slope[i]);
                let stage_time = time + self.times[stage] * h;
                slope = system.derivatives(stage_time, &argument, &inputs.at(stage_time), memory);
            }
            for i in 0..N {
                end[i] += h * self.weights[stage] * slope[i];
            }
        }
        (end, slope)
    }
}

/// One step of size `h` of the classical method, with the error of one of order 3, and the derivatives at its end.
///
/// Up to order 2 the last stage agrees with the derivatives at the end, so that a tenth of their difference can be
/// moved from the one to the other: the weights 1/6, 1/3, 1/3, 1/15, 1/10 are still of order 3.
#[allow(clippy::too_many_arguments, reason = "the system, where it is, and the step")]
pub fn classical_with_error<H: HybridSystem<N, U>, const N: usize, const U: usize>(
    system: &H,
    time: f64,
    x: &[f64; N],
    inputs: &Held<U>,
    memory: &H::Memory,
    derivatives: &[f64; N],
    h: f64,
) -> (Trial<N>, [f64; N]) {
    let (end, last) = RK4.stages(system, time, x, inputs, memory, derivatives, h);
    let end_time = time + h;
    let slope = system.derivatives(end_time, &end, &inputs.at(end_time), memory);
    (Trial { end, error: std::array::from_fn(|i| 0.1 * h * (last[i] - slope[i])) }, slope)
}
