//! Event indicators of a hybrid system.

/// Event indicators: each is positive (or zero) while the present mode is valid, and an event when it turns negative.
#[derive(Clone, Copy, Debug, Default)]
pub struct Indicators {
    values: [f64; Self::CAPACITY],
    len: usize,
}

impl Indicators {
    /// Few, since they are copied in every step; three contacts under laws with three each and three links need most.
    const CAPACITY: usize = 12;

    /// Appends an indicator.
    pub fn push(&mut self, value: f64) {
        self.values[self.len] = value;
        self.len += 1;
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.len
    }

    /// The indicators, in the order in which they were appended.
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.len]
    }
}
