//! Why a solver stops.

use std::fmt;

/// Why a communication step could not be completed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepError {
    /// The step size fell below what the clock resolves.
    StepSizeTooSmall {
        /// Time in s of the last accepted step.
        time: f64,
    },
    /// The limit of solver steps within one communication step was reached.
    TooManySteps {
        /// Time in s of the last accepted step.
        time: f64,
        /// The limit.
        limit: u64,
    },
    /// The limit of samples within one communication step was reached.
    TooManySamples {
        /// Time in s of the last sample.
        time: f64,
        /// The limit.
        limit: u64,
    },
    /// A fixed-step scheme left the range in which the equations have a meaning.
    Diverged {
        /// Time in s of the last accepted step.
        time: f64,
        /// The step size in s.
        step: f64,
    },
    /// Events followed each other without end at one instant.
    Chattering {
        /// Time in s of the events.
        time: f64,
    },
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StepSizeTooSmall { time } => {
                write!(
                    f,
                    "at t = {time} s no step size meets the tolerance: the equations have no finite solution there"
                )
            }
            Self::TooManySteps { time, limit } => {
                write!(f, "at t = {time} s the limit of {limit} solver steps per communication step was reached")
            }
            Self::TooManySamples { time, limit } => {
                write!(f, "at t = {time} s the limit of {limit} samples per communication step was reached")
            }
            Self::Diverged { time, step } => {
                write!(f, "at t = {time} s the fixed-step scheme diverges: solver.step = {step} s is too large for it")
            }
            Self::Chattering { time } => write!(f, "at t = {time} s events follow each other without end"),
        }
    }
}

impl std::error::Error for StepError {}
