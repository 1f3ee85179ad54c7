//! The parameters of a model, read part by part.

use super::{ParameterError, ParameterSet, Tunable};

/// The values of the parameters of a model in the order of its table, from which each part takes its own.
#[derive(Debug)]
pub struct Values<'a> {
    rest: &'a [Tunable],
}

impl<'a> Values<'a> {
    /// All values.
    pub fn new(values: &'a [Tunable]) -> Self {
        Self { rest: values }
    }

    /// The next set of parameters.
    ///
    /// # Errors
    /// [`ParameterError`] for a value without a meaning.
    pub fn read<P: ParameterSet>(&mut self) -> Result<P, ParameterError> {
        P::read(self.take(P::LEN))
    }

    /// The next values, as many as there are asked for.
    ///
    /// # Panics
    /// If there are fewer: the parts of a model take what its table lists, in that order.
    pub fn take(&mut self, count: usize) -> &'a [Tunable] {
        let (own, rest) = self.rest.split_at(count);
        self.rest = rest;
        own
    }

    /// How many values no part has taken yet.
    pub fn left(&self) -> usize {
        self.rest.len()
    }
}
