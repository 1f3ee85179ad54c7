//! What a model adds to a hybrid system: computed variables.

use crate::hybrid::HybridSystem;
use crate::numbers::Scalar;

/// A hybrid system with computed variables, which come first among those of the model's table.
pub trait Equations<const N: usize, const U: usize>: HybridSystem<N, U> {
    /// Conserved quantities whose residuals the table lists before the solver's counters.
    const RESIDUALS: usize = 0;

    /// Writes the computed variables in the order of the table.
    fn outputs<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; U], memory: &Self::Memory, computed: &mut [S]);

    /// The index among the `N` states of the state whose derivative the table lists in a place, if it is integrated.
    fn state_index(&self, place: usize) -> Option<usize>;
}
