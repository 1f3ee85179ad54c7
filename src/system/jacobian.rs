//! Jacobians by dual numbers.

use super::System;
use crate::numbers::{Dual, Number, Varying};
use crate::system::{Couplings, bits};

/// Directions in which the equations are evaluated at a time.
const DIRECTIONS: usize = 6;

/// The Jacobian, exact to rounding, by evaluating the equations with dual numbers a few directions at a time.
///
/// The number of directions is the same for all systems, so that the equations are compiled for it once.
pub fn jacobian_by_duals<E: System<U>, S: Varying, const N: usize, const U: usize>(
    equations: &E,
    time: f64,
    x: &[f64; N],
    u: &[f64; U],
    memory: &E::Memory<S>,
    jacobian: &mut [[f64; N]; N],
) -> [f64; N] {
    let (time, u) = (Dual::constant(time), u.map(Dual::constant));
    let mut derivatives = [0.0; N];
    for first in (0..N).step_by(DIRECTIONS) {
        let mut seeded = x.map(Dual::<DIRECTIONS, S>::constant);
        for (direction, state) in seeded[first..].iter_mut().take(DIRECTIONS).enumerate() {
            state.slope[direction] = 1.0;
        }
        for (row, rate) in equations.derivatives(time, &seeded, &u, memory).iter().enumerate() {
            derivatives[row] = rate.value;
            for (column, slope) in (first..N).zip(rate.slope) {
                jacobian[column][row] = slope;
            }
        }
    }
    derivatives
}

/// The Jacobian as by [`jacobian_by_duals`], of which the entries that the couplings leave out, all of them zero, are not written.
pub fn jacobian_by_couplings<E: System<U>, S: Varying, const N: usize, const U: usize>(
    equations: &E,
    couplings: &Couplings<N>,
    time: f64,
    x: &[f64; N],
    u: &[f64; U],
    memory: &E::Memory<S>,
    jacobian: &mut [[f64; N]; N],
) -> [f64; N] {
    let (time, u) = (Dual::constant(time), u.map(Dual::constant));
    let mut derivatives = [0.0; N];
    let directions = usize::from(couplings.direction.iter().copied().max().unwrap_or(0)) + 1;
    for first in (0..directions).step_by(DIRECTIONS) {
        let is_seeded = |state: usize| (first..first + DIRECTIONS).contains(&usize::from(couplings.direction[state]));
        let mut seeded = x.map(Dual::<DIRECTIONS, S>::constant);
        let mut chosen = 0;
        for state in (0..N).filter(|state| is_seeded(*state)) {
            seeded[state].slope[usize::from(couplings.direction[state]) - first] = 1.0;
            chosen |= 1 << state;
        }
        for (row, rate) in equations.derivatives(time, &seeded, &u, memory).iter().enumerate() {
            derivatives[row] = rate.value;
            for state in bits(couplings.rates[row] & chosen) {
                jacobian[state][row] = rate.slope[usize::from(couplings.direction[state]) - first];
            }
        }
    }
    derivatives
}

/// The derivatives of the rates by some inputs, column by column, as [`jacobian_by_duals`] has them by the states.
#[cfg(feature = "sensitivities")]
pub fn rates_by_inputs<E: System<U>, S: Varying, const N: usize, const U: usize>(
    equations: &E,
    time: f64,
    x: &[f64; N],
    u: &[f64; U],
    memory: &E::Memory<S>,
    inputs: &[usize],
) -> Vec<[f64; N]> {
    let mut columns = Vec::with_capacity(inputs.len());
    let (time, x) = (Dual::constant(time), x.map(Dual::constant));
    for some in inputs.chunks(DIRECTIONS) {
        let mut seeded = u.map(Dual::<DIRECTIONS, S>::constant);
        some.iter().enumerate().for_each(|(direction, input)| seeded[*input].slope[direction] = 1.0);
        let rates = equations.derivatives(time, &x, &seeded, memory);
        columns.extend((0..some.len()).map(|direction| rates.each_ref().map(|rate| rate.slope[direction])));
    }
    columns
}
