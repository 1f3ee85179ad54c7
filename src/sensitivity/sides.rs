//! Equations whose memory differs from that of a run, to both sides.

use super::equations::Equations;

/// Equations whose memory differs in numbers that have slopes.
pub(super) struct Neighbours {
    pub sides: [Side; 2],
    /// The numbers of the memory that differ to both sides.
    pub moved: Vec<bool>,
}

/// One side of them.
pub(super) struct Side {
    pub equations: Box<dyn Equations>,
    pub numbers: Vec<f64>,
    /// By which share of their magnitudes the numbers were moved.
    pub share: f64,
}
