//! The common part of co-simulation and model exchange: building runs, their bookkeeping, snapshots.

mod build;
mod differentiate;

use std::cell::RefCell;
use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub(crate) use self::build::check_outputs;
#[doc(hidden)]
pub use self::build::{build, check, read};
use self::differentiate::differentiate;
use self::differentiate::differentiate_varied;
use crate::numbers::{Real, Scalar, Slopes, first};
use crate::system::{System, shared_table};
use crate::variables::{ParameterError, Table};

/// Everything a run starts from.
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    /// Start time in s.
    pub time: f64,
    /// All parameters, in the order in which the table lists them.
    pub parameters: &'a [f64],
    /// All inputs, in the order in which the table lists them.
    pub inputs: &'a [f64],
    /// The tolerance the host asks for; it replaces `solver.relativeTolerance` unless that was changed.
    pub tolerance: Option<f64>,
    /// Values that it varies with.
    pub seeds: Seeds<'a>,
}

/// Slopes of parameters and inputs, in the order in which the table lists them; empty where nothing varies.
#[derive(Clone, Copy, Debug)]
pub struct Seeds<'a> {
    /// Of the parameters.
    pub parameters: &'a [Slopes],
    /// Of the inputs.
    pub inputs: &'a [Slopes],
}

impl Seeds<'_> {
    /// Nothing varies.
    pub const NONE: Self = Self { parameters: &[], inputs: &[] };
}

/// A direction of differentiation. All else is constant, so that time alone moves no input or state.
#[derive(Clone, Copy, Debug)]
pub struct Direction<'a> {
    /// Of time.
    pub time: f64,
    /// Of the inputs, in the order of the table.
    pub inputs: &'a [f64],
    /// Of the continuous states, in the order in which the table lists their derivatives
    /// ([`Variable::derivative_of`](crate::variables::Variable::derivative_of)).
    pub states: &'a [f64],
    /// Of the parameters, in the order of the table: tunable ones alone may vary. Empty if none varies.
    pub parameters: &'a [f64],
}

/// A saved state, free of pointers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Time in s.
    pub time: f64,
    /// Continuous states that are integrated, without those that are compiled along and unused.
    pub states: Vec<f64>,
    /// Discrete memory of the model and of its run, serialised.
    pub memory: Vec<u8>,
}

/// Why a saved state cannot be restored.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Its discrete state cannot be read: another model or another law has saved it.
    Unreadable,
    /// It has another number of continuous states: of another law, or of other options.
    States {
        /// Its number of states.
        found: usize,
        /// The number of states that are integrated.
        expected: usize,
    },
    /// One of its numbers is not finite.
    NotFinite,
    /// Its discrete state is none that these parameters allow.
    Foreign,
    /// Its time is not the one of its run.
    Clock {
        /// The time in s that it says.
        time: f64,
    },
    /// It has another number of parameters or inputs.
    Lengths,
    /// A parameter that is fixed once a run has started has another value in it.
    Fixed {
        /// Name of the parameter.
        name: String,
        /// Its value in the saved state.
        saved: f64,
        /// Its value now.
        present: f64,
    },
    /// Its parameters do not fit together.
    Parameters(ParameterError),
}

impl fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the saved state does not belong to this model with these parameters: ")?;
        match self {
            Self::Unreadable => f.write_str("its discrete state belongs to another model or friction law"),
            Self::States { found, expected } => write!(f, "it has {found} continuous states, not {expected}"),
            Self::NotFinite => f.write_str("a number in it is not finite"),
            Self::Foreign => f.write_str("its discrete state is none that these parameters allow"),
            Self::Clock { time } => write!(f, "its time, {time} s, is not the one of its run"),
            Self::Lengths => f.write_str("it has another number of parameters or inputs"),
            Self::Fixed { name, saved, present } => {
                write!(f, "{name} is {saved} in it, and {present} now, and is fixed once the model has started")
            }
            Self::Parameters(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SnapshotError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Parameters(error) => Some(error),
            _ => None,
        }
    }
}

/// Parameters and the host's clock, kept beside a run of equations.
#[derive(Clone)]
pub(crate) struct Session {
    pub table: Arc<Table>,
    /// All parameters, in the order of the table.
    pub parameters: Vec<f64>,
    /// Clock of the host in s at the start. Equations count their time from there, so that late clocks, which resolve
    /// microseconds or less, cost no accuracy.
    pub start: f64,
    /// Clock of the host in s now: exactly as it said.
    pub time: f64,
    /// Room for the computed variables as the equations write them.
    computed: RefCell<Vec<Real>>,
}

impl Session {
    /// A run of equations that begins.
    pub fn begin<E: System<U>, const U: usize>(start: &Start) -> Self {
        let (table, parameters) = (shared_table::<E, U>(), start.parameters.to_vec());
        let computed = RefCell::new(vec![Real::of(0.0); table.computed().count()]);
        Self { table, parameters, start: start.time, time: start.time, computed }
    }

    /// The equations for other parameters, which are taken over if these fit together.
    pub fn retune<E: System<U>, const U: usize>(&mut self, parameters: &[f64]) -> Result<E, ParameterError> {
        let equations = Self::build(parameters, &[])?;
        self.parameters.copy_from_slice(parameters);
        Ok(equations)
    }

    /// Writes the computed variables that the equations have at a point.
    pub fn outputs<E: System<U>, const N: usize, const U: usize>(
        &self,
        equations: &E,
        (time, x, u, memory): (f64, &[f64; N], &[f64; U], &E::Memory<Real>),
        computed: &mut [f64],
    ) {
        let numbers = &mut self.computed.borrow_mut()[..computed.len()];
        equations.outputs(Real::of(time), &Real::all(x), &Real::all(u), memory, numbers);
        computed.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number.value);
    }

    /// Writes the derivatives of the computed variables at a point in a direction: of time, states and inputs, and of the
    /// parameters, if any varies.
    pub fn differentiate<E: System<U>, const N: usize, const U: usize>(
        &self,
        equations: &E,
        at: (f64, &[f64; N], &[f64; U], &E::Memory<Real>),
        seeds: (f64, &[f64; N], &[f64; U]),
        slopes: &[f64],
        computed: &mut [f64],
    ) {
        if slopes.iter().all(|slope| *slope == 0.0) {
            return differentiate(equations, at, seeds, computed);
        }
        let slopes: Vec<Slopes> = slopes.iter().map(|slope| first(*slope)).collect();
        let varied: E = Self::build(&self.parameters, &slopes).expect("parameters that have been accepted");
        differentiate_varied(&varied, at, seeds, computed);
    }

    /// Everything that changes while running, with a memory of whoever integrates.
    pub fn save<E: System<U>, const N: usize, const U: usize>(
        &self,
        equations: &E,
        x: &[f64; N],
        memory: impl Serialize,
    ) -> Snapshot {
        let unused = equations.unused(N);
        let states = [&x[..unused.start], &x[unused.end..]].concat();
        let memory = postcard::to_allocvec(&memory).expect("a memory holds plain data");
        Snapshot { time: self.time, states, memory }
    }

    /// The equations for parameters that vary with slopes.
    fn build<E: System<U>, const U: usize>(parameters: &[f64], slopes: &[Slopes]) -> Result<E, ParameterError> {
        let seeds = Seeds { parameters: slopes, ..Seeds::NONE };
        let start = Start { time: 0.0, parameters, inputs: &[0.0; U], tolerance: None, seeds };
        build(&start).map(|(equations, _)| equations)
    }
}

impl Snapshot {
    /// The states in their places, among unused ones that stay as they are, and the memory.
    pub(crate) fn read<E: System<U>, M: for<'a> Deserialize<'a>, const N: usize, const U: usize>(
        &self,
        equations: &E,
        x: &[f64; N],
    ) -> Result<([f64; N], M), SnapshotError> {
        let memory = postcard::from_bytes(&self.memory).map_err(|_| SnapshotError::Unreadable)?;
        let unused = equations.unused(N);
        let (found, expected) = (self.states.len(), N - unused.len());
        if found != expected {
            return Err(SnapshotError::States { found, expected });
        }
        if !self.states.iter().chain([&self.time]).all(|value| value.is_finite()) {
            return Err(SnapshotError::NotFinite);
        }
        let (before, behind) = self.states.split_at(unused.start);
        let mut states = *x;
        states[..unused.start].copy_from_slice(before);
        states[unused.end..].copy_from_slice(behind);
        Ok((states, memory))
    }
}
