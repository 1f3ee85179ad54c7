//! States that follow the inputs alone, with a closed form while these are held.

/// A size of steps, and the decay in a step of this size of the distance between states with a closed form and their limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride<S> {
    /// The size in s.
    pub size: f64,
    /// Decay matrix of half a step for the distances of two states.
    pub half: [[S; 2]; 2],
}

/// The closed form of states in a step over which the inputs are held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedForm<X> {
    /// In the middle, the values with which Simpson's rule has the exact means over the step.
    pub middle: X,
    /// At the end.
    pub end: X,
    /// Defect in the middle: these values minus the true ones, a quadrature error of the states that depend on them.
    pub defect: X,
}
