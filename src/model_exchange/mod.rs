//! Model exchange: a host integrates the states, watches the indicators, and asks for updates.
//!
//! The equations are the same as in co-simulation. Rules for the host's solver:
//!
//! - The vector of states has the length given by the table ([`Table::number_of_states`]), under every friction law
//!   and option: unused states keep their start value.
//! - Each indicator has a fixed place and meaning (`Model::indicators`). It is positive while the present modes are
//!   valid and rests clearly off zero after an [`update`](Exchange::update): by [`HYSTERESIS`]. By as much it falls
//!   beyond the exact instant until an event is seen. Indicators without use are 1.
//! - Where equations have a kink but no mode ends, at the stops of the cylinder for example, an indicator lets a solver stop
//!   there. Nothing happens, and no event is counted.
//! - Discrete states that follow accepted steps (hysteresis of the valve, nested loops of friction) do so by
//!   [`accept_step`](Exchange::accept_step). A host that never says it has accepted a step gets the error of a memory that
//!   moves at events only: for the valve at most the width of its play, for laws with nested loops the loops that begin
//!   and end between two events. Delay lines make time events of their own and need nothing.
//! - Every finite vector of states has rates, values and indicators, since a solver tries states that no run comes to. Beyond
//!   the [`Limits`](crate::system::Limits) of the states, where volumes, pressures or temperatures would vanish, the
//!   equations use a nearby state, and states return. A state accepted there is refused.
//! - Time is the host's; the equations count from the start: a run is the same from any start time.
//! - Sampled laws and delay lines announce their next time event with every update.
//!
//! [`Table::number_of_states`]: crate::variables::Table::number_of_states

mod exchanger;

use std::fmt;

#[doc(hidden)]
pub use self::exchanger::Exchanger;
pub use self::exchanger::{HYSTERESIS, seen};
use crate::session::{Direction, Snapshot, SnapshotError};
use crate::variables::{Notices, ParameterError};

/// A model whose states are integrated by its host.
///
/// Slices of inputs, parameters and computed values follow the order of the table; states are numbered in the order in
/// which the table lists their derivatives, indicators as the model lists them.
pub trait Exchange: Send {
    /// Current time in s.
    fn time(&self) -> f64;

    /// Sets the current time in s.
    fn set_time(&mut self, time: f64);

    /// Sets the inputs at the current time. They may jump before an update only.
    fn set_inputs(&mut self, values: &[f64]);

    /// Replaces the tunable parameters, before an update; all parameters are given, and fixed ones must be unchanged.
    ///
    /// # Errors
    /// [`ParameterError`] when a value or a combination of values is not legal; nothing is changed then.
    fn retune(&mut self, parameters: &[f64]) -> Result<(), ParameterError>;

    /// Writes the states.
    fn states(&self, states: &mut [f64]);

    /// Sets the states; those that are not used keep their value.
    fn set_states(&mut self, states: &[f64]);

    /// Writes the magnitudes of the states, to which a host may relate its tolerance.
    fn nominals(&self, nominals: &mut [f64]);

    /// Refuses states that a run cannot come to: a host may try them, but not go on from there.
    ///
    /// # Errors
    /// [`ExchangeError::NotAdmissible`] when the equations have no meaning at these states.
    fn admit(&self) -> Result<(), ExchangeError>;

    /// Writes the time derivatives of the states, exactly 0 for a position that is held.
    ///
    /// # Errors
    /// [`ExchangeError::NotFinite`] when one of them overflows, under inputs without measure.
    fn rates(&self, rates: &mut [f64]) -> Result<(), ExchangeError>;

    /// Writes the event indicators.
    fn indicators(&self, indicators: &mut [f64]);

    /// Takes the samples that are due and lets the system switch until all modes are valid. One update is enough.
    ///
    /// # Errors
    /// [`ExchangeError::Chattering`] when switches follow each other without end, [`ExchangeError::MissedTimeEvents`]
    /// when the host has passed time events, [`ExchangeError::NotAdmissible`] as [`admit`](Self::admit); nothing is changed
    /// then.
    fn update(&mut self) -> Result<Update, ExchangeError>;

    /// Lets memories follow a step that the host has accepted.
    ///
    /// # Errors
    /// [`ExchangeError::NotAdmissible`] as [`admit`](Self::admit); nothing is changed then.
    fn accept_step(&mut self) -> Result<(), ExchangeError>;

    /// Writes all computed variables.
    fn values(&self, computed: &mut [f64]);

    /// Writes the derivative of all computed variables in a direction, exact to rounding.
    fn directional_derivative(&self, direction: Direction, computed: &mut [f64]);

    /// Warnings about the parameters and the present inputs.
    fn notices(&self) -> Notices;

    /// Everything that changes while running, apart from inputs and parameters.
    fn save(&self) -> Snapshot;

    /// Goes back to a snapshot of the same model with the same parameters.
    ///
    /// # Errors
    /// [`SnapshotError`] when the snapshot does not fit; nothing is changed then.
    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError>;
}

/// Result of an update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// Whether it has changed the states.
    pub changes_states: bool,
    /// Time in s of the next time event, if there is one.
    pub next_time_event: Option<f64>,
}

/// Why a model cannot go on.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ExchangeError {
    /// The equations have no meaning at the states.
    NotAdmissible {
        /// Time in s.
        time: f64,
        /// Meaningless quantity, as part of a sentence.
        cause: String,
    },
    /// A rate is not a finite number.
    NotFinite {
        /// Time in s.
        time: f64,
    },
    /// Events followed each other without end at one instant.
    Chattering {
        /// Time in s.
        time: f64,
        /// Names of the indicators that fell below zero last.
        indicators: Vec<String>,
    },
    /// The host has integrated past time events.
    MissedTimeEvents {
        /// Time in s.
        time: f64,
        /// Time in s of an event that is still due.
        due: f64,
    },
}

impl fmt::Display for ExchangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAdmissible { time, cause } => {
                write!(f, "at t = {time} s the equations have no meaning at the given states: {cause}")
            }
            Self::NotFinite { time } => write!(f, "at t = {time} s a rate is not a finite number"),
            Self::Chattering { time, indicators } => {
                let names = indicators.join(", ");
                write!(f, "at t = {time} s events follow each other without end; indicators: {names}")
            }
            Self::MissedTimeEvents { time, due } => {
                write!(f, "at t = {time} s the time event of {due} s is still due, and too many after it")
            }
        }
    }
}

impl std::error::Error for ExchangeError {}
