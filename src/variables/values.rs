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
    /// [`ParameterError`] for a value without a meaning, or if too few are left.
    pub fn read<P: ParameterSet>(&mut self) -> Result<P, ParameterError> {
        P::read(self.take(P::LEN)?)
    }

    /// The next values, as many as there are asked for.
    ///
    /// # Errors
    /// [`ParameterError`] if there are fewer: the parts of a model take the values of its table in order.
    pub fn take(&mut self, count: usize) -> Result<&'a [Tunable], ParameterError> {
        let (own, rest) = self.rest.split_at_checked(count).ok_or_else(|| {
            let reason = "the equations read this number of values beyond the end of the table";
            ParameterError::new("parameters", (count - self.rest.len()) as f64, reason)
        })?;
        self.rest = rest;
        Ok(own)
    }

    /// Number of values that no part has taken yet.
    pub fn left(&self) -> usize {
        self.rest.len()
    }
}
