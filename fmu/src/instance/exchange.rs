//! Model exchange: answers to the importer's solver.

use super::Instance;
use super::record::Kind;
use crate::calls::Mode;
use crate::failure::Failure;
use pneumatic_servo::model_exchange::{Exchange, ExchangeError, Update};

/// The vectors of the importer's solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vector {
    /// The continuous states.
    States,
    /// Their derivatives with respect to time.
    Derivatives,
    /// Their magnitudes.
    Nominals,
    /// The event indicators.
    Indicators,
}

impl Instance {
    /// From now on inputs may jump, until the next update.
    pub fn enter_event_mode(&mut self) -> Result<(), Failure> {
        self.record.mode = match self.record.kind {
            Kind::CoSimulation => {
                return Err(Failure::error("the instance was made without event mode and handles all events itself"));
            }
            Kind::HybridCoSimulation { .. } => Mode::StepEvent,
            Kind::ModelExchange => {
                self.outside()?.admit()?;
                Mode::Event
            }
        };
        Ok(())
    }

    /// From now on steps are taken.
    pub fn enter_step_mode(&mut self) -> Result<(), Failure> {
        self.record.mode = Mode::StepComplete;
        Ok(())
    }

    /// From now on the host integrates.
    pub fn enter_continuous_time_mode(&mut self) -> Result<(), Failure> {
        self.record.mode = Mode::ContinuousTime;
        Ok(())
    }

    /// Updates the discrete part of the model.
    pub fn update(&mut self) -> Result<Update, Failure> {
        let update = self.run.update(&self.layout, &self.record)?;
        self.tell_notices()?;
        Ok(update)
    }

    /// Lets the model follow a step that the host has accepted.
    pub fn accept_step(&mut self) -> Result<(), Failure> {
        self.outside()?.accept_step()?;
        self.tell_notices()
    }

    /// Sets the time in s.
    pub fn set_time(&mut self, time: f64) -> Result<(), Failure> {
        let start = self.record.start().time;
        if !(time.is_finite() && time >= start) {
            return Err(Failure::error(format!("the time must be finite and not before {start} s, not {time} s")));
        }
        self.outside()?.set_time(time);
        Ok(())
    }

    /// Sets the continuous states: all of them or, if one is refused, none.
    pub fn set_states(&mut self, states: impl Iterator<Item = f64>) -> Result<(), Failure> {
        let mut room = std::mem::take(&mut self.scratch.states);
        let outcome = self.take_states(states, &mut room);
        self.scratch.states = room;
        outcome
    }

    /// Sets some of the continuous states, given by their numbers.
    pub(super) fn move_states(&mut self, moved: impl Iterator<Item = (usize, f64)>) -> Result<(), Failure> {
        let mut room = std::mem::take(&mut self.scratch.states);
        let outcome = self.outside().map(|exchange| {
            exchange.states(&mut room);
            moved.for_each(|(number, value)| room[number] = value);
            exchange.set_states(&room);
        });
        self.scratch.states = room;
        outcome
    }

    fn take_states(&mut self, states: impl Iterator<Item = f64>, room: &mut [f64]) -> Result<(), Failure> {
        for ((number, slot), state) in (1..).zip(&mut *room).zip(states) {
            if !state.is_finite() {
                return Err(Failure::error(format!("continuous state {number} must be a finite number, not {state}")));
            }
            *slot = state;
        }
        self.outside()?.set_states(room);
        Ok(())
    }

    /// A vector, which the host has room for.
    pub fn vector(&mut self, vector: Vector) -> Result<&[f64], Failure> {
        let mut answers = std::mem::take(&mut self.scratch.answers);
        answers.clear();
        answers.resize(self.length(vector), 0.0);
        let outcome = self.run.look_from_outside(&self.layout, &self.record, |exchange| {
            match vector {
                Vector::States => exchange.states(&mut answers),
                Vector::Derivatives => exchange.rates(&mut answers)?,
                Vector::Nominals => exchange.nominals(&mut answers),
                Vector::Indicators => exchange.indicators(&mut answers),
            }
            Ok(())
        });
        self.scratch.answers = answers;
        outcome?;
        Ok(&self.scratch.answers)
    }

    /// Refuses an array whose length differs from a vector of the model.
    pub fn check_length(&self, vector: Vector, length: usize) -> Result<(), Failure> {
        let expected = self.length(vector);
        if length == expected {
            return Ok(());
        }
        Err(Failure::error(format!("there are {expected} {vector:?}, not {length}")))
    }

    /// The length of a vector.
    pub fn length(&self, vector: Vector) -> usize {
        if vector == Vector::Indicators { self.layout.indicators.len() } else { self.layout.states }
    }

    fn outside(&mut self) -> Result<&mut dyn Exchange, Failure> {
        self.run.outside(&self.layout, &self.record)
    }
}

impl From<ExchangeError> for Failure {
    /// A host that integrates may try another step where rates overflow; the rest is final.
    fn from(error: ExchangeError) -> Self {
        match error {
            ExchangeError::NotFinite { .. } => Self::discard(error.to_string()),
            _ => Self::error(error.to_string()),
        }
    }
}
