//! What a model adds to a hybrid system: computed variables.

use crate::hybrid::HybridSystem;
use crate::numbers::Scalar;
use crate::variables::Table;

/// A hybrid system with computed variables, which come first among those of the model's table.
pub trait Equations<const N: usize, const U: usize>: HybridSystem<N, U> {
    /// Conserved quantities whose residuals the table lists before the solver's counters.
    const RESIDUALS: usize = 0;

    /// The variable table of the model.
    fn table() -> &'static Table;

    /// Writes the computed variables in the order of the table.
    fn outputs<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; U], memory: &Self::Memory, computed: &mut [S]);

    /// The index among the `N` states of the one that a variable stands for, if it is integrated: with other parameters
    /// (another friction law, another rig) it may not be, and keeps its start value.
    fn state_at(&self, reference: u32) -> Option<usize>;
}

/// Name of the variable of a model that is a state, by its index.
pub fn state_name<E: Equations<N, U>, const N: usize, const U: usize>(equations: &E, state: usize) -> &'static str {
    let reference = E::table().states().find(|reference| equations.state_at(*reference) == Some(state));
    let entry = reference.and_then(|reference| E::table().by_reference(reference));
    entry.map_or("an internal state", |entry| entry.variable.name.as_str())
}
