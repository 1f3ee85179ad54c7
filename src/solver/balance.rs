//! Accounts of conserved quantities: the content of the system against its inflow.

use serde::{Deserialize, Serialize};

use super::event::Hermite;
use super::{array, numbers};
use crate::numbers::Varying;
use crate::system::{Held, QUANTITIES, System};

/// The account of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Content of the system at the start.
    initial: [f64; QUANTITIES],
    /// Inflow since.
    received: [f64; QUANTITIES],
}

impl Balance {
    /// The account of a system that holds these amounts now.
    pub fn new(content: [f64; QUANTITIES]) -> Self {
        Self { initial: content, received: [0.0; QUANTITIES] }
    }

    /// Adds the inflow of a step, by Simpson's rule on the cubic through its ends.
    pub fn add<H: System<U>, S: Varying, const N: usize, const U: usize>(
        &mut self,
        system: &H,
        inputs: &Held<U, S>,
        memory: &H::Memory<S>,
        time: f64,
        path: &Hermite<N>,
    ) {
        for (fraction, weight) in [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)] {
            let at = time + fraction * path.h;
            let inflow = system.inflow(S::of(at), &numbers(&path.at(fraction)), &inputs.at(at), memory);
            for (sum, rate) in self.received.iter_mut().zip(inflow) {
                *sum += weight * path.h * rate;
            }
        }
    }

    /// Content of a system beyond the account: the error of the integration.
    pub fn residual(&self, content: [f64; QUANTITIES]) -> [f64; QUANTITIES] {
        array(|i| content[i] - self.initial[i] - self.received[i])
    }

    /// Whether all amounts are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.initial.iter().chain(&self.received).all(|amount| amount.is_finite())
    }
}
