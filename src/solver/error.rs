//! Errors of the solver.

use std::fmt;

/// Why a communication step could not be completed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepError {
    /// The step size fell below the resolution of the clock.
    StepSizeTooSmall {
        /// Time in s of the last accepted step.
        time: f64,
        /// Why the last step was rejected.
        reason: Rejection,
        /// The choice the equations depend on most, a friction law for example.
        variant: &'static str,
    },
    /// The limit of solver steps within one communication step was reached.
    TooManySteps {
        /// Time in s of the last accepted step.
        time: f64,
        /// The limit.
        limit: u64,
        /// Number of events in the communication step that ended steps.
        events: u64,
        /// The last of them; empty without any.
        event: &'static str,
        /// The choice the equations depend on most, a friction law for example.
        variant: &'static str,
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
        /// Reason of the rejection.
        reason: Rejection,
    },
    /// Events followed each other without end at one instant.
    Chattering {
        /// Time in s of the events.
        time: f64,
        /// The last event.
        event: &'static str,
        /// The choice the equations depend on most, a friction law for example.
        variant: &'static str,
    },
}

/// A state at the start of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateAtStart {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Its rate per second.
    pub rate: f64,
}

/// Why a step is not accepted; states and events by name.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Rejection {
    /// The estimated error of a state exceeds what the tolerance allows.
    Inaccurate(StateAtStart),
    /// A state leaves every reasonable range.
    Unbounded {
        /// The state.
        state: StateAtStart,
        /// The magnitude at which that range ends.
        limit: f64,
    },
    /// The equations have no meaning where the step leads, for the reason the system gives.
    Meaningless(&'static str),
    /// The linear equations of an implicit scheme have no solution, or its iteration finds none.
    Unsolvable,
    /// An event happens, and is undone, within the step.
    Passed,
    /// An event that was at its limit at the start of the step happens at once.
    AtOnce(&'static str),
}

/// Steps of which at most as many as this belong to an event, when events use up a communication step.
const EVENTFUL: u64 = 10;

impl StepError {
    /// The same for a clock that is ahead by a time in s.
    pub fn later(mut self, by: f64) -> Self {
        match &mut self {
            Self::StepSizeTooSmall { time, .. }
            | Self::TooManySteps { time, .. }
            | Self::TooManySamples { time, .. }
            | Self::Diverged { time, .. }
            | Self::Chattering { time, .. } => *time += by,
        }
        self
    }
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StepSizeTooSmall { time, reason, variant } => {
                write!(f, "at t = {time} s no step is small enough: {reason}{}", Variant(variant))
            }
            Self::TooManySteps { time, limit, events, event, variant } => {
                write!(f, "at t = {time} s the limit of {limit} solver steps per communication step was reached")?;
                let otherwise = if !event.is_empty() && events * EVENTFUL >= *limit {
                    write!(f, " after {events} events, the last of them {event}{}", Variant(variant))?;
                    ". Unless these repeat without end"
                } else {
                    ""
                };
                let remedy = "take shorter communication steps, or raise solver.maxStepsPerCommunicationStep";
                write!(f, "{otherwise}{}{remedy}", if otherwise.is_empty() { ": " } else { ", " })
            }
            Self::TooManySamples { time, limit } => {
                write!(f, "at t = {time} s the limit of {limit} samples per communication step was reached")
            }
            Self::Diverged { time, step, reason } => write!(
                f,
                "at t = {time} s the fixed-step scheme diverges: {reason}; solver.step = {step} s is too large for it"
            ),
            Self::Chattering { time, event, variant } => write!(
                f,
                "at t = {time} s events follow each other without end, the last of them {event}{}",
                Variant(variant)
            ),
        }
    }
}

impl std::error::Error for StepError {}

impl fmt::Display for Rejection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inaccurate(state) => {
                write!(f, "the error of {} stays above the tolerance{}", state.name, Origin(state))
            }
            Self::Unbounded { state, limit } => {
                write!(f, "the magnitude of {} goes beyond {limit:.0e}{}", state.name, Origin(state))
            }
            Self::Meaningless(reason) => f.write_str(reason),
            Self::Unsolvable => f.write_str("the equations of a step have no solution"),
            Self::Passed => f.write_str("events happen and are undone within every step"),
            Self::AtOnce(event) => write!(f, "{event} happens at once, however short the step"),
        }
    }
}

/// Where a state comes from.
struct Origin<'a>(&'a StateAtStart);

impl fmt::Display for Origin<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, ", from {:.3e} at a rate of {:.3e} per second", self.0.value, self.0.rate)
    }
}

/// The variant in brackets, if there is one.
struct Variant<'a>(&'a str);

impl fmt::Display for Variant<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() { Ok(()) } else { write!(f, " ({})", self.0) }
    }
}
