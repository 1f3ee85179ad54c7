//! States that follow the inputs alone, with a closed form while these are held.

/// A size of steps, and how states that follow inputs alone come closer in a step of this size to where these lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride<S> {
    /// The size in s.
    pub size: f64,
    /// Decay matrix of half a step for the distances of two states.
    pub half: [[S; 2]; 2],
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
