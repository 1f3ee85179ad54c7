//! What a model adds to a hybrid system: computed variables.

use crate::hybrid::HybridSystem;
use crate::numbers::Scalar;
use crate::variables::Table;

/// A hybrid system with computed variables, which come first among those of the model's table.
pub trait Equations<const N: usize, const U: usize>: HybridSystem<N, U> {
    /// Conserved quantities whose residuals the table lists before the solver's counters.
    const RESIDUALS: usize = 0;

    /// Writes the computed variables in the order of the table.
    fn outputs<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; U], memory: &Self::Memory, computed: &mut [S]);

    /// The index among the `N` states of the state whose derivative the table lists in a place, if it is integrated.
    fn state_index(&self, place: usize) -> Option<usize>;
}

/// Name of the variable of a model's table that is a state, by its index.
pub fn state_name<E: Equations<N, U>, const N: usize, const U: usize>(
    equations: &E,
    table: &Table,
    state: usize,
) -> &'static str {
    let mut derivatives = table.into_iter().filter_map(|variable| variable.derivative_of).enumerate();
    let reference = derivatives.find_map(|(place, of)| (equations.state_index(place) == Some(state)).then_some(of));
    let variable = table.into_iter().find(|variable| Some(variable.reference) == reference && !variable.is_parameter());
    variable.map_or("an internal state", |variable| variable.name.as_str())
}
