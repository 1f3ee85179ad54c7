//! What a run tells of itself so that slopes can be carried along.

use super::Equations;
use crate::solver::Mark;

/// A run that slopes can be carried along, unless it says nothing.
pub trait Differentiable {
    /// The equations with the present memory; nothing if the model has none that can be differentiated along a run.
    fn equations(&self) -> Option<Box<dyn Equations>> {
        None
    }

    /// Leaves a trail from now on, or none.
    fn leave_trail(&mut self, _leaves: bool) {}

    /// Time in s since the start, and the states, of a run that can leave a trail; the tolerance it is integrated with.
    fn place(&self) -> Option<(f64, Vec<f64>, f64)> {
        None
    }

    /// The trail left since it was taken last.
    fn take_trail(&mut self) -> Vec<Mark> {
        Vec::new()
    }

    /// The index among the states of [`place`](Self::place) of a continuous state, numbered as in a
    /// [`Direction`](crate::session::Direction), if it is integrated.
    ///
    /// A model without continuous states has nothing to say.
    fn state_index(&self, _state: usize) -> Option<usize> {
        None
    }
}
