//! What of equations is differentiated.

use super::equations::{At, Equations};

/// What is differentiated.
#[derive(Clone, Copy, Debug)]
pub(super) enum Of {
    /// The rates of the states.
    Rates,
    /// The computed variables.
    Outputs,
}

impl Of {
    pub fn values(self, equations: &dyn Equations, at: At) -> Vec<f64> {
        match self {
            Self::Rates => equations.rates(at),
            Self::Outputs => equations.outputs(at),
        }
    }

    pub fn slopes(self, equations: &dyn Equations, at: At, direction: (&[f64], &[f64]), found: &mut [f64]) {
        match self {
            Self::Rates => equations.rate_slopes(at, direction, found),
            Self::Outputs => found.copy_from_slice(&equations.output_slopes(at, direction)),
        }
    }
}
