//! What a run has done since somebody asked, mark by mark: for who does it again with numbers of his own.

use super::Run;
use crate::numbers::{Scalar, Varying};
use crate::system::System;

/// What a run does to its states and its memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// The system takes notice of a communication step of a duration in s.
    Begins(f64),
    /// The memory follows the present inputs, and events happen that these set off.
    Follows,
    /// A step is accepted; the memory follows.
    Moves {
        /// Time in s at its end.
        time: f64,
        /// The states there.
        end: Vec<f64>,
    },
    /// An event happens, by its place among the indicators, and those that it sets off.
    Switches(usize),
    /// The sample of a time in s is taken, and events happen that it sets off.
    Samples(f64),
    /// The system takes notice of a communication point.
    Arrives,
}

impl<H: System<U>, const N: usize, const U: usize, S: Varying> Run<H, N, U, S> {
    /// Leaves a trail from now on, or none.
    pub fn leave_trail(&mut self, leaves: bool) {
        self.trail = leaves.then(Vec::new);
    }

    /// The trail left since this was asked last.
    pub fn take_trail(&mut self) -> Vec<Mark> {
        self.trail.as_mut().map(std::mem::take).unwrap_or_default()
    }

    #[inline(always)]
    pub(super) fn mark(&mut self, mark: impl FnOnce() -> Mark) {
        // Without sensitivities nobody asks for a trail.
        if cfg!(feature = "sensitivities")
            && let Some(trail) = &mut self.trail
        {
            note(trail, mark());
        }
    }

    /// Marks a step to states.
    #[inline(always)]
    pub(super) fn mark_move(&mut self, time: f64, end: &[S; N]) {
        self.mark(|| moved(time, end));
    }
}

// Few runs leave a trail.
#[cold]
#[inline(never)]
fn note(trail: &mut Vec<Mark>, mark: Mark) {
    trail.push(mark);
}

#[cold]
#[inline(never)]
fn moved<S: Scalar>(time: f64, end: &[S]) -> Mark {
    Mark::Moves { time, end: end.iter().map(|state| state.value()).collect() }
}
