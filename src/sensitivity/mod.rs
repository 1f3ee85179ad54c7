//! How a run changes with a parameter, a start value, a state or an input: exact through events.
//!
//! With `S = dx/dp` along a run whose states are `x`, a direction `p`, rates `f`, an event with the indicator `g` and what
//! happens there, `R`, with `-` before and `+` behind it:
//!
//! ```text
//! between events:  dS/dt = f_x*S + f_m*M + f_p
//! at an event:     tau = -(g_x*S- + g_m*M- + g_p)/(g_x*f- + g_t)
//!                  S+  = R_x*(S- + f-*tau) + R_m*M- + R_t*tau + R_p - f+*tau
//! ```
//!
//! `tau` is how much later the event happens, `M` the slopes of the numbers in the memory, which change at events alone. The
//! steps of the run, and what is chosen at events, stay as they are: what is differentiated is the motion, not the method, so
//! that slopes converge with the tolerance as the run does.
//!
//! A [`Companion`] follows a run that [leaves a trail](crate::solver::Run::leave_trail): the run itself knows nothing of it,
//! and its values are the same bits with and without.
//!
//! | what | how its derivative is taken |
//! |---|---|
//! | rates by states | exact to rounding, by dual numbers: the Jacobian of the solver |
//! | rates by inputs and tunable parameters | the same, by tangents |
//! | rates by fixed parameters and numbers of the memory | central differences of one evaluation, to 1e-9 of the largest |
//! | indicators, what happens at events, samples | the same, along the direction; both sides are compared |
//!
//! Differences serve where the equations take plain numbers: a memory says how it is saved, not what it is made of
//! (`leaves`), and a sample or a switch is a program, not a formula. They are of one evaluation, within one mode and with
//! all choices held, so they have nothing in common with differences of two runs. Where both sides disagree, there is no
//! derivative, and [`NoDerivative`] says so.

mod adjoint;
mod begin;
mod bend;
mod besides;
mod companion;
mod crossing;
mod difference;
mod differentiable;
mod direction;
mod equations;
mod leaves;
mod memory;
mod neighbours;
mod of;
mod passage;
mod sides;
mod slopes;
mod transition;
mod variation;
mod way;

use std::fmt;

use crate::solver::StepError;

pub use self::adjoint::{Gradient, Tangents};
pub use self::begin::{Begin, begin};
pub use self::companion::Companion;
pub use self::differentiable::Differentiable;
pub use self::direction::{DirectionError, directions};
pub use self::equations::{Act, At, Equations, Erased};
pub use self::leaves::{Leaf, Leaves};
pub(crate) use self::leaves::{read, told};
pub use self::slopes::{Driven, Slopes};
pub use self::transition::{States, Transition, columns};
pub(crate) use self::variation::Piece;
pub use self::way::{Beside, Way};

/// An event that a run with slopes has come through.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Time in s since the start of the run.
    pub time: f64,
    /// Name of the event.
    pub event: &'static str,
    /// How fast its indicator fell, in its own unit per s: the smaller, the nearer the motion came to missing the event.
    pub rate: f64,
    /// How much later the event happens, in s per unit of each direction.
    pub delays: Vec<f64>,
}

/// A point beyond which a run has no derivative in a direction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NoDerivative {
    /// Time in s.
    pub time: f64,
    /// What happens there.
    pub event: String,
    /// Why there is none.
    pub reason: String,
}

impl NoDerivative {
    /// The same on a clock that shows a time in s at the start of the run.
    pub(crate) fn later(self, start: f64) -> Self {
        Self { time: self.time + start, ..self }
    }
}

impl fmt::Display for NoDerivative {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { time, event, reason } = self;
        write!(f, "the run has no derivative from t = {time} s on, at {event}: {reason}")
    }
}

impl std::error::Error for NoDerivative {}

/// Why a transition cannot be told.
#[derive(Clone, Debug, PartialEq)]
pub enum TransitionError {
    /// There is no such direction or output.
    Direction(DirectionError),
    /// The step cannot be made.
    Step(StepError),
    /// The step is made, and has no derivative.
    NoDerivative(NoDerivative),
}

impl fmt::Display for TransitionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Direction(error) => error.fmt(f),
            Self::Step(error) => error.fmt(f),
            Self::NoDerivative(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for TransitionError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(match self {
            Self::Direction(error) => error,
            Self::Step(error) => error,
            Self::NoDerivative(error) => error,
        })
    }
}

/// What a run is differentiated by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// The parameter in a place of the table.
    Parameter(usize),
    /// The value that a continuous state has now, numbered as in a [`Direction`](crate::session::Direction).
    State(usize),
    /// What is added to the input in a place of the table from now on.
    Input(usize),
    /// A number that the memory has now.
    Memory(usize),
}
