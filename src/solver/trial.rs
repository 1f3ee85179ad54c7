//! Arguments and results of the integration schemes.

use nalgebra::SMatrix;

use crate::numbers::Real;

/// A step that may be accepted.
#[derive(Clone, Copy, Debug)]
pub struct Trial<const N: usize, S = Real> {
    /// States at its end.
    pub end: [S; N],
    /// Estimated error of each state (zero for fixed-step schemes).
    pub error: [S; N],
}

/// The equations linearised at the start of a step.
#[derive(Clone, Debug)]
pub struct Linearisation<const N: usize, S = Real> {
    /// Time derivatives of the states.
    pub derivatives: [S; N],
    /// Their partial derivatives with respect to the states.
    pub jacobian: SMatrix<f64, N, N>,
    /// Their partial derivatives with respect to time, where they depend on it.
    pub time_slopes: Option<[f64; N]>,
}
