//! What a friction law is: what it sees of the contact, and what it answers.

use serde::{Serialize, de::DeserializeOwned};

use super::event::{Event, Indicators};
use super::parts::elements::MAX_ELEMENTS;
use crate::hybrid::Sample;
use crate::numbers::Scalar;
use crate::variables::{Notice, ParameterError, ParameterSet};

/// The largest number of continuous states a law may have: one for each element.
pub const MAX_STATES: usize = MAX_ELEMENTS;

/// What the continuous states of a law are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateKind {
    /// A deflection in m.
    Deflection,
    /// Forces in N.
    Force,
}

/// What sets the contact in motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A mass moves under forces; friction can hold it.
    Force,
    /// The velocity is prescribed; friction is only read.
    Motion,
}

/// The contact as a friction law sees it.
#[derive(Clone, Copy, Debug)]
pub struct Contact<S> {
    /// Time in s.
    pub time: S,
    /// Position in m.
    pub position: S,
    /// Relative velocity in m/s.
    pub velocity: S,
    /// Sum of all other forces on the mass in N, positive towards positive velocity.
    pub applied: S,
    /// Load level (1 at rated load), which multiplies every force-valued parameter of the law, or the limits of its
    /// deflections where these stand for forces.
    pub level: S,
    /// Whether the contact is moved by forces or by a prescribed motion.
    pub drive: Drive,
}

/// A friction law: its parameters and its hybrid equations.
pub trait FrictionLaw: Sized {
    /// What the law remembers apart from its continuous states; changes at events and accepted steps only.
    type Memory: Clone + PartialEq + std::fmt::Debug + Serialize + DeserializeOwned;

    /// The events that can end a mode of the law.
    const EVENTS: &'static [Event] = &[];

    /// The law's parameters, named relative to its group; value references count from 0 and are never reused.
    type Parameters: ParameterSet;

    /// Builds the law.
    ///
    /// # Errors
    /// [`ParameterError`] when values that are legal one by one do not fit together.
    fn new(parameters: Self::Parameters) -> Result<Self, ParameterError>;

    /// Those that its parameters leave possible.
    fn events(&self) -> &'static [Event] {
        Self::EVENTS
    }

    /// Number of continuous states, at most [`MAX_STATES`].
    fn states(&self) -> usize {
        0
    }

    /// What the continuous states are.
    fn state_kind(&self) -> StateKind {
        StateKind::Deflection
    }

    /// Magnitude of the continuous states, for error control.
    fn state_scale(&self) -> f64 {
        1.0
    }

    /// The memory a run starts with; may set the continuous states, which are zero.
    fn start(&self, contact: &Contact<f64>, z: &mut [f64]) -> Self::Memory;

    /// The friction force in N; writes the time derivatives of the continuous states.
    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Self::Memory, rates: &mut [S]) -> S;

    /// Sets the event indicators that the present mode uses.
    fn indicators(&self, _contact: &Contact<f64>, _z: &[f64], _memory: &Self::Memory, _out: &mut Indicators) {}

    /// Handles an event, whose indicator fell below zero; may set the velocity (to exactly 0) and the states.
    fn switch(
        &self,
        _event: Event,
        _contact: &Contact<f64>,
        _velocity: &mut f64,
        _z: &mut [f64],
        _memory: &mut Self::Memory,
    ) {
    }

    /// Lets the memory follow an accepted step; must leave the indicators as they are.
    fn follow(&self, _contact: &Contact<f64>, _z: &[f64], _memory: &mut Self::Memory) {}

    /// The next sample the law takes.
    fn next_sample(&self, _memory: &Self::Memory) -> Sample {
        Sample::NEVER
    }

    /// Takes a sample.
    fn sample(&self, _contact: &Contact<f64>, _z: &[f64], _memory: &mut Self::Memory) {}

    /// Longest step in s the solver may take.
    fn max_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether the force depends on time otherwise than through contact and states.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// What is unusual about the parameters.
    fn notice(&self) -> Option<Notice> {
        None
    }

    /// Whether the law holds the mass (the output `sticking`).
    fn is_sticking(&self, _memory: &Self::Memory) -> bool {
        false
    }

    /// Whether the position is exactly constant, so that the velocity to report is 0.
    fn holds_position(&self, memory: &Self::Memory) -> bool {
        self.is_sticking(memory)
    }
}
