//! The implicit Euler method with fixed step.

use nalgebra::SMatrix;

use super::linear::Inverse;
use super::trial::Trial;
use super::{array, values};
use crate::numbers::{DIRECTIONS, Varying};
use crate::system::{Held, System};

const MAX_ITERATIONS: usize = 30;

/// Newton iterations end when no state changes by more than this fraction of its scale.
const CONVERGED: f64 = 1e-10;

/// One step of size `h` by Newton's method; `None` if the iteration does not converge.
// A function of its own: inlined, it would be optimised once more with each caller.
#[inline(never)]
pub fn step<H: System<U>, S: Varying, const N: usize, const U: usize>(
    system: &H,
    time: f64,
    start: &[S; N],
    inputs: &Held<U, S>,
    memory: &H::Memory<S>,
    h: f64,
    jacobians: &mut u64,
) -> Option<Trial<N, S>> {
    let (end_time, scales, counting) = (time + h, system.scales::<N>(), system.counting(N));
    let u = inputs.at(end_time).map(S::value);
    let x = values(start);
    let mut end = x;
    let mut jacobian = SMatrix::zeros();
    for _ in 0..MAX_ITERATIONS {
        let derivatives = system.jacobian(end_time, &end, &u, memory, &mut jacobian.data.0);
        *jacobians += 1;
        let residual = array(|i| (x[i] - end[i]) / h + derivatives[i]);
        let inverse = Inverse::new(&jacobian, 1.0 / h, H::GROUPS, system.hints(start, memory).is_chain)?;
        let change = inverse.times(&residual, H::GROUPS);
        for i in 0..N {
            end[i] += change[i];
        }
        if end.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let is_still = |i: usize| change[i].abs() <= CONVERGED * scales[i].max(end[i].abs());
        if (0..N).all(|i| is_still(i) || counting == Some(i)) {
            let ended = array(|i| S::of(end[i]));
            if !S::VARIES {
                return Some(Trial { end: ended, error: [S::zero(); N] });
            }
            // `(I/h - J)*end' = start'/h + f'`, with `f'` by all but the states.
            let besides = system.derivatives(S::of(end_time), &ended, &inputs.at(end_time), memory);
            let slopes: [[f64; N]; DIRECTIONS] = std::array::from_fn(|way| {
                let right = array(|i| start[i].slopes()[way] / h + besides[i].slopes()[way]);
                inverse.times(&right, H::GROUPS)
            });
            let end = array(|i| S::with(end[i], slopes.map(|slopes| slopes[i])));
            return Some(Trial { end, error: [S::zero(); N] });
        }
    }
    None
}
