//! What a solver counts.

use serde::{Deserialize, Serialize};

use crate::variables::Variable;

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

impl Counters {
    /// How many they are.
    pub const COUNT: usize = 4;

    /// The counters as variables; every model's table has them. Value references from `base`.
    pub fn table(base: u32) -> Vec<Variable> {
        let texts = [
            ("steps", "Accepted solver steps since initialization"),
            ("rejectedSteps", "Rejected solver steps since initialization"),
            ("jacobians", "Evaluations of the Jacobian since initialization"),
            ("events", "Events since initialization: break-away, stop of sliding and all other switches"),
        ];
        let counters = texts.iter().zip(0..);
        counters.map(|((name, text), index)| Variable::counter(index, name).text(text).within("solver", base)).collect()
    }

    /// Writes their values.
    pub fn write(self, slots: &mut [f64]) {
        let Self { steps, rejected, jacobians, events } = self;
        for (slot, count) in slots.iter_mut().zip([steps, rejected, jacobians, events]) {
            // FMI integers have 32 bits; a run that exceeds them shows the largest.
            *slot = f64::from(i32::try_from(count).unwrap_or(i32::MAX));
        }
    }
}
