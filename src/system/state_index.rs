//! The index of a state in the vector of a run.

/// The index of a state in the vector of a run, whose length depends on the friction law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateIndex {
    /// Number of states before it.
    Front(usize),
    /// Number of states behind it.
    Back(usize),
}

impl StateIndex {
    /// Its index among `n` states.
    #[inline(always)]
    pub const fn among(self, n: usize) -> usize {
        match self {
            Self::Front(before) => before,
            Self::Back(behind) => n - 1 - behind,
        }
    }
}
