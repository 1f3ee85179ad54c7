//! Inputs that are held over a step, or vary linearly.

use crate::numbers::{Real, Scalar};

/// Inputs that vary linearly from a point in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<const U: usize, S = Real> {
    since: f64,
    values: [S; U],
    slopes: [f64; U],
    /// Whether any slope differs from 0.
    vary: bool,
}

impl<const U: usize, S: Scalar> Held<U, S> {
    /// Inputs with values at a time in s, and with slopes in 1/s from there on.
    pub fn new(since: f64, values: [S; U], slopes: [f64; U]) -> Self {
        Self { since, values, slopes, vary: slopes.iter().any(|slope| *slope != 0.0) }
    }

    /// The inputs at a time.
    pub fn at(&self, time: f64) -> [S; U] {
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
