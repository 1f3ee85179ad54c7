//! What a solver counts.

use serde::{Deserialize, Serialize};

/// What the solver has done since initialization.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Accepted steps.
    pub steps: u64,
    /// Steps rejected because of the error estimate or because a trial state was not admissible.
    pub rejected: u64,
    /// Evaluations of the Jacobian.
    pub jacobians: u64,
    /// Events: break-away, stop of sliding, and all other switches.
    pub events: u64,
}
