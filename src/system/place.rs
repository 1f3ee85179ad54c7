//! The place of a state among those of a run.

/// The place of a state among those of a run, whose number depends on the friction law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// So many states are before it.
    Front(usize),
    /// So many states are behind it.
    Back(usize),
}

impl Place {
    /// Its index among `n` states.
    pub const fn among(self, n: usize) -> usize {
        match self {
            Self::Front(before) => before,
            Self::Back(behind) => n - 1 - behind,
        }
    }
}
