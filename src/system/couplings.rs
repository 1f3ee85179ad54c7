//! Couplings between states: which rates can depend on which states.

/// Where the second and the third group of the states begin, in a system whose Jacobian has zeros as below.
///
/// ```text
///     | A  0  0 |   the first group depends on nothing but itself,
/// J = | B  C  D |   the others on everything
///     | G  E  F |
/// ```
pub type Groups = [usize; 2];

/// Which rates can depend on which states, and in which direction each state is seeded so that no rate depends on two states of
/// one direction: then a few directions tell the derivatives with respect to all states (Curtis, Powell, Reid 1974, Journal of
/// the Institute of Mathematics and its Applications).
#[derive(Clone, Debug)]
pub struct Couplings<const N: usize> {
    /// The direction of each state.
    pub(super) direction: [u8; N],
    /// For each rate, the states on which it can depend, as bits.
    pub(super) rates: [u64; N],
}

impl<const N: usize> Couplings<N> {
    /// The couplings of no states.
    pub const NONE: Self = Self { direction: [0; N], rates: [0; N] };

    /// The couplings of rates, for each of which the states on which it can depend are given as bits. The states choose
    /// their directions in turn, those with the most neighbours first: each takes the first one without a neighbour in it.
    pub fn new(rates: [u64; N]) -> Self {
        // The states that a rate depends on together with the one of the place.
        let mut neighbours = [0; N];
        for states in rates {
            bits(states).for_each(|state| neighbours[state] |= states);
        }
        let mut order: [usize; N] = std::array::from_fn(|state| state);
        order.sort_by_key(|state| std::cmp::Reverse(neighbours[*state].count_ones()));
        let (mut direction, mut taken) = ([0; N], [0; N]);
        for state in order {
            let is_free = |states: &u64| states & neighbours[state] == 0;
            let first = taken.iter().position(is_free).expect("there are as many directions as states");
            taken[first] |= 1 << state;
            direction[state] = first as u8;
        }
        Self { direction, rates }
    }

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
