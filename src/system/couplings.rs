//! Couplings between states: which rates can depend on which states.

/// Where the second and the third group of the states begin, in a system whose Jacobian has zeros as below.
///
/// ```text
///     | A  0  0 |   the first group depends on nothing but itself,
/// J = | B  C  D |   the second on everything,
///     | 0  E  F |   the third not on the first
/// ```
pub type Groups = [usize; 2];

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
    /// The couplings of no states.
    pub const NONE: Self = Self { direction: [0; N], rates: [0; N] };

    /// The couplings in a vector of `M` states, of which these are the first `states`: the same number is in front, and the
    /// others stand behind states that rest.
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

/// The places of the bits that are set.
#[inline(always)]
pub(crate) fn bits(mut left: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = left.trailing_zeros() as usize;
        (left != 0).then(|| left &= left - 1).map(|()| place)
    })
}
