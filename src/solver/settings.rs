//! Settings of the solver.

use crate::system::{DEFAULT_TOLERANCE, Scheme, Tuning};

/// Settings of the integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The scheme.
    pub scheme: Scheme,
    /// Relative tolerance of the adaptive scheme.
    pub tolerance: f64,
    /// Step size in s of the fixed-step schemes.
    pub step: f64,
    /// Bound on solver steps within one communication step, those included that are rejected or locate an event; 0 for one
    /// that suits its length.
    pub max_steps: u64,
    /// Whether to keep account of conserved quantities.
    pub keeps_balance: bool,
}

impl Settings {
    /// The settings for checked parameters and the tolerance the host asks for.
    pub fn new(tuning: &Tuning, host_tolerance: Option<f64>) -> Self {
        let tolerance = match host_tolerance {
            Some(asked) if tuning.relative_tolerance == DEFAULT_TOLERANCE => asked.clamp(1e-12, 1e-2),
            _ => tuning.relative_tolerance,
        };
        Self { scheme: tuning.scheme, tolerance, step: tuning.step, max_steps: tuning.max_steps, keeps_balance: false }
    }

    /// The same, keeping account of conserved quantities or not.
    pub fn keeping_balance(self, keeps_balance: bool) -> Self {
        Self { keeps_balance, ..self }
    }

    /// Bound on solver steps within a communication step of a length in s, when none is longer than `longest` in s.
    ///
    /// A controller that waits for a step of a millisecond gets it, or a refusal, after some milliseconds.
    ///
    /// # Errors
    /// The bound, if the length alone asks for more.
    pub(super) fn limit(&self, length: f64, longest: f64) -> Result<u64, u64> {
        const FEWEST: f64 = 5e3;
        const MOST: f64 = 1e6;
        const PER_SECOND: f64 = 1e6;
        if self.max_steps > 0 {
            return Ok(self.max_steps);
        }
        // The usual case without divisions.
        if self.is_adaptive() && length <= longest.min(FEWEST / PER_SECOND) {
            return Ok(FEWEST as u64);
        }
        let step = if self.is_adaptive() { longest } else { self.step };
        let fewest = length / step;
        if fewest > MOST {
            return Err(MOST as u64);
        }
        // A fixed step may have to be repeated at events.
        let wanted = if self.is_adaptive() { PER_SECOND * length } else { FEWEST + 2.0 * fewest };
        Ok(wanted.clamp(FEWEST, MOST) as u64)
    }

    /// Whether the step size is chosen by error control.
    pub fn is_adaptive(&self) -> bool {
        self.scheme == Scheme::Adaptive
    }
}
