//! Couplings of states in groups, conserved quantities, states with a closed form, and inputs that are held over a step.

/// Where the second and the third group of the states begin, in a system whose Jacobian has zeros as below.
///
/// ```text
///     | A  0  0 |   the first group depends on nothing but itself,
/// J = | B  C  D |   the second on everything,
///     | 0  E  F |   the third not on the first
/// ```
pub type Groups = [usize; 2];

/// Conserved quantities a system can have.
pub const QUANTITIES: usize = 2;

/// A size of steps, and how states that follow inputs alone come closer in a step of this size to where these lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride {
    /// The size in s.
    pub size: f64,
    /// What half a step leaves of the distances of two states, as a matrix.
    pub half: [[f64; 2]; 2],
}

/// States that follow inputs alone, in a step over which these are held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Led<X> {
    /// In the middle, the values with which the rule of Simpson has the means over the step.
    pub middle: X,
    /// At the end.
    pub end: X,
    /// By how much those in the middle differ from the true ones, which is their error for those that depend on them.
    pub bend: X,
}

/// Inputs that vary linearly from a point in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<const U: usize> {
    since: f64,
    values: [f64; U],
    slopes: [f64; U],
    /// Whether any slope differs from 0.
    vary: bool,
}

impl<const U: usize> Held<U> {
    /// Inputs with values at a time in s, and with slopes in 1/s from there on.
    pub fn new(since: f64, values: [f64; U], slopes: [f64; U]) -> Self {
        Self { since, values, slopes, vary: slopes.iter().any(|slope| *slope != 0.0) }
    }

    /// The inputs at a time.
    pub fn at(&self, time: f64) -> [f64; U] {
        if !self.vary {
            return self.values;
        }
        std::array::from_fn(|i| self.values[i] + self.slopes[i] * (time - self.since))
    }

    /// Slopes in 1/s.
    pub fn slopes(&self) -> [f64; U] {
        self.slopes
    }

    /// Whether any slope differs from 0.
    pub fn vary(&self) -> bool {
        self.vary
    }
}
