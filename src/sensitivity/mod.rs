//! Sensitivities of a run to parameters, start values, states and inputs, exact through events.
//!
//! A run is repeated in numbers that carry slopes in a few directions ([`Tangent`]): the same equations,
//! the same solver, the same bits ([`Varied`]). Its slopes are the derivatives of the scheme with all adaptive choices
//! held: internal numerical differentiation (Bock, 1981). With states `x`, rates `f-` before and `f+` behind an event with
//! the indicator `g`, and the change there, `switch` (the saltation matrix):
//!
//! ```text
//! tau = -g'/gdot,   x+ = switch(x- + f-*tau, t + tau) - f+*tau
//! ```
//!
//! `tau` is how much later the event happens. The numbers that a discrete state keeps carry slopes, too. Slopes are refined within
//! a step where their own error asks for it, and pieces of a step end at kinks, so that they converge with the tolerance as the run
//! does.
//!
//! Where a direction leads to one mode and against it to another, there is no derivative, and [`NoDerivative`] says so: a motion
//! that only grazes a limit, an input that brings an event exactly to its limit, a set point at the edge of its play.

mod adjoint;
mod direction;
mod transition;

use std::any::Any;
use std::fmt;

use crate::numbers::{DIRECTIONS, STILL, Slopes, Tangent, random};
use crate::session::{Snapshot, SnapshotError, Start};
use crate::solver::StepError;
use crate::system::LabelledNumber;

pub use self::adjoint::{Gradient, Tangents};
pub use self::direction::{DirectionError, directions};
pub use self::transition::{Column, States, Transition};

/// An event that a run with slopes has come through.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Time in s since the start of the run.
    pub time: f64,
    /// Name of the event.
    pub event: &'static str,
    /// Rate at which its indicator fell, in its own unit per s: the smaller, the nearer the motion came to missing the
    /// event.
    pub rate: f64,
    /// Derivative of the time of the event, in s per unit of each direction; not a number where there is none.
    pub delays: Vec<f64>,
}

/// A run in numbers with slopes in [`DIRECTIONS`], beside a plain run: it is told all that the plain one is told.
///
/// Slices follow the order of the table, as in a [`Simulation`](crate::co_simulation::Simulation).
pub trait Varied: Any + Send {
    /// Finds directions of parameters and inputs to one side of which the run begins in another mode: they have no derivative.
    fn check_start(&mut self, start: &Start);

    /// Goes to a saved state of the plain run; from there on states, numbers of the memory and additions to inputs vary with the
    /// seeds, and a parameter that it has been built for in its direction.
    ///
    /// # Errors
    /// [`SnapshotError`] when the saved state does not fit.
    fn place(&mut self, snapshot: &Snapshot, seeds: &[Seed]) -> Result<(), SnapshotError>;

    /// Moves the continuous states, numbered as in a [`Direction`](crate::session::Direction), to other values at the present time and
    /// with the present modes; from there on each direction of a state or an input varies alone, as in [`Seed::each`]. A run that has
    /// been moved so at the same point of the same run may be given: its memory is taken over.
    fn reseed(&mut self, states: &[f64], along: &[Along], moved: Option<&dyn Varied>);

    /// Does not tell from here on why there are no slopes, and lets them be less accurate: for a filter, whose steps then do not
    /// allocate.
    fn be_silent(&mut self);

    /// Everything that changes while running, apart from inputs, parameters and slopes: what a plain run would save.
    fn save(&self) -> Snapshot;

    /// Sets the inputs at the current time and their slopes in 1/s.
    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]);

    /// Integrates to `end` on the clock of the host.
    ///
    /// # Errors
    /// [`StepError`] when the end cannot be reached.
    fn advance(&mut self, end: f64) -> Result<(), StepError>;

    /// Integrates over a step of a size in s.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn step(&mut self, size: f64) -> Result<(), StepError>;

    /// Writes the computed variables with their slopes, which belong to the present inputs. Values without slopes, such as counters, stay;
    /// values that depend on a rounded number, such as the reading of a sensor with a resolution, have slopes of NaN.
    /// Tells why there are none any more in a direction.
    fn outputs(&self, computed: &mut [Tangent]) -> [Option<NoDerivative>; DIRECTIONS];

    /// The slopes of a continuous state, numbered as in a [`Direction`](crate::session::Direction); 0 if it is not integrated.
    fn state(&self, state: usize) -> Slopes;

    /// Writes the continuous states that are integrated, numbered as in a [`Direction`](crate::session::Direction).
    fn states(&self, states: &mut [Tangent]);

    /// The numbers of the memory that are told as states of a transition.
    fn memory(&self) -> Vec<LabelledNumber>;

    /// The slopes of all numbers of the memory, by their places.
    fn memory_slopes(&self) -> Vec<Slopes>;

    /// The events so far, each with a delay for each direction.
    fn crossings(&self) -> Vec<Crossing>;

    /// Where there is no derivative any more in a direction.
    fn lost(&self, direction: usize) -> Option<&NoDerivative>;
}

/// A point beyond which a run has no derivative in a direction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NoDerivative {
    /// Time in s.
    pub time: f64,
    /// Effect of the event.
    pub event: String,
    /// Why there is none.
    pub reason: String,
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

/// Direction of a derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// The parameter in a place of the table.
    Parameter(usize),
    /// The value that a continuous state has now, numbered as in a [`Direction`](crate::session::Direction).
    State(usize),
    /// Addition to the input with an index in the table, from now on.
    Input(usize),
    /// A number that the memory has now.
    Memory(usize),
}

/// A slope that something has at first: a direction may vary several things at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// What varies.
    pub along: Along,
    /// The direction.
    pub direction: usize,
    /// The slope.
    pub slope: f64,
}

impl Seed {
    /// Directions in each of which one thing varies at the rate 1.
    pub fn each(along: &[Along]) -> Vec<Self> {
        along.iter().enumerate().map(|(direction, along)| Self { along: *along, direction, slope: 1.0 }).collect()
    }
}

/// A slope that no other direction has, by its place.
pub(crate) fn own_slope(place: usize) -> f64 {
    random::uniform(&mut (place as u64)) + 1.0
}

/// The slopes of a quantity that one of the directions may vary.
pub(crate) fn seeds(along: &[Along], of: Along) -> Slopes {
    std::array::from_fn(|direction| if along.get(direction) == Some(&of) { 1.0 } else { 0.0 })
}

/// Seeds by what varies, to be looked up.
#[derive(Debug, Default)]
pub(crate) struct Seeded {
    states: Vec<Slopes>,
    memory: Vec<Slopes>,
    inputs: Vec<Slopes>,
}

impl Seeded {
    pub fn new(seeds: &[Seed]) -> Self {
        let mut seeded = Self::default();
        for Seed { along, direction, slope } in seeds {
            let (all, place) = match along {
                Along::State(place) => (&mut seeded.states, *place),
                Along::Memory(place) => (&mut seeded.memory, *place),
                Along::Input(place) => (&mut seeded.inputs, *place),
                Along::Parameter(_) => continue,
            };
            all.resize(all.len().max(place + 1), STILL);
            all[place][*direction] = *slope;
        }
        seeded
    }

    #[cfg(feature = "sensitivities")]
    pub fn state(&self, place: usize) -> Slopes {
        self.states.get(place).copied().unwrap_or(STILL)
    }

    pub fn memory(&self, place: usize) -> Slopes {
        self.memory.get(place).copied().unwrap_or(STILL)
    }

    pub fn input(&self, place: usize) -> Slopes {
        self.inputs.get(place).copied().unwrap_or(STILL)
    }
}
