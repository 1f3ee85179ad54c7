//! Which states change which others, and the Jacobian of a system in which most do not.

use nalgebra::SMatrix;

use super::HybridSystem;
use super::system::DIRECTIONS;
use crate::numbers::{Dual, Number};

/// Which rates can depend on which states, and in which direction each state is seeded so that no rate depends on two states of
/// one direction: then a few directions tell the derivatives with respect to all states (Curtis, Powell, Reid 1974, Journal of
/// the Institute of Mathematics and its Applications).
#[derive(Clone, Debug)]
pub struct Couplings<const N: usize> {
    /// The direction of each state.
    pub direction: [u8; N],
    /// For each rate, the states on which it can depend, as bits.
    pub rates: [u64; N],
}

impl<const N: usize> Couplings<N> {
    /// Those of no states.
    pub const NONE: Self = Self { direction: [0; N], rates: [0; N] };

    /// The same of a system that has `M` states, where here are the first `states`: of these, too, so many are in front, and the
    /// others behind states that rest.
    pub fn among<const M: usize>(&self, states: usize, front: usize) -> Couplings<M> {
        let mut among = Couplings::NONE;
        let (shift, in_front) = (M - states, (1 << front) - 1);
        for state in 0..states {
            let index = if state < front { state } else { state + shift };
            among.direction[index] = self.direction[state];
            among.rates[index] = (self.rates[state] & in_front) | (self.rates[state] & !in_front) << shift;
        }
        among
    }
}

/// The Jacobian as by [`jacobian_by_duals`](super::jacobian_by_duals), of which the entries that the couplings leave out, all of them zero, are not written.
pub fn jacobian_by_couplings<H: HybridSystem<N, U> + ?Sized, const N: usize, const U: usize>(
    system: &H,
    couplings: &Couplings<N>,
    time: f64,
    x: &[f64; N],
    u: &[f64; U],
    memory: &H::Memory,
    jacobian: &mut SMatrix<f64, N, N>,
) -> [f64; N] {
    let (time, u) = (Dual::constant(time), u.map(Dual::constant));
    let mut derivatives = [0.0; N];
    let directions = usize::from(couplings.direction.iter().copied().max().unwrap_or(0)) + 1;
    for first in (0..directions).step_by(DIRECTIONS) {
        let is_seeded = |state: usize| (first..first + DIRECTIONS).contains(&usize::from(couplings.direction[state]));
        let mut seeded = x.map(Dual::<DIRECTIONS>::constant);
        let mut chosen = 0;
        for state in (0..N).filter(|state| is_seeded(*state)) {
            seeded[state].slope[usize::from(couplings.direction[state]) - first] = 1.0;
            chosen |= 1 << state;
        }
        for (row, rate) in system.derivatives(time, &seeded, &u, memory).iter().enumerate() {
            derivatives[row] = rate.value;
            for state in bits(couplings.rates[row] & chosen) {
                jacobian[(row, state)] = rate.slope[usize::from(couplings.direction[state]) - first];
            }
        }
    }
    derivatives
}

/// The places of the bits that are set.
#[inline(always)]
pub(crate) fn bits(mut left: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = left.trailing_zeros() as usize;
        (left != 0).then(|| left &= left - 1).map(|()| place)
    })
}
