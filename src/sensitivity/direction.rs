//! Directions by their names.

use std::fmt;

use super::Along;
use crate::variables::{Case, Entry, Kind, Meaning, Place, SettingError, Table, find};

/// A name along which no run can be differentiated.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DirectionError {
    /// The model has no variable of this name.
    Unknown(SettingError),
    /// The variable is none that a run can be differentiated by.
    Refused {
        /// Its name.
        name: String,
        /// Why.
        reason: &'static str,
    },
    /// A law that is chosen holds its force between samples.
    Held {
        /// The choice with the law, as `friction.law = DNLRX`.
        choice: String,
    },
}

impl DirectionError {
    pub(crate) fn refused(name: &str, reason: &'static str) -> Self {
        Self::Refused { name: name.to_owned(), reason }
    }
}

impl fmt::Display for DirectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(error) => error.fmt(f),
            Self::Refused { name, reason } => write!(f, "there are no sensitivities with respect to {name}: {reason}"),
            Self::Held { choice } => write!(
                f,
                "there are no sensitivities under {choice}: it holds its force between samples, and small changes of a run grow from \
                 sample to sample; compare runs, or take a law without samples"
            ),
        }
    }
}

impl std::error::Error for DirectionError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unknown(error) => Some(error),
            Self::Refused { .. } | Self::Held { .. } => None,
        }
    }
}

/// The directions of names: parameters with values, inputs and continuous states.
///
/// # Errors
/// [`DirectionError`] for the first name that is none of these, stands for a choice or a count or a setting of the solver,
/// is of a part that is absent, or comes twice; and for any name, or none, under a law that holds its force between samples.
pub fn directions(table: &Table, parameters: &[f64], names: &[&str]) -> Result<Vec<Along>, DirectionError> {
    if let Some(choice) = held_between_samples(table, parameters) {
        return Err(DirectionError::Held { choice });
    }
    let of = |(index, name): (usize, &&str)| {
        if names[..index].contains(name) {
            return Err(DirectionError::refused(name, "it is given twice"));
        }
        let entry = find(table, name).map_err(DirectionError::Unknown)?;
        along(&entry, parameters).map_err(|reason| DirectionError::refused(name, reason))
    };
    names.iter().enumerate().map(of).collect()
}

/// The choice of a law that holds its force between samples, if it is chosen.
fn held_between_samples(table: &Table, parameters: &[f64]) -> Option<String> {
    let samples = table.parameters().filter(|it| it.meaning == Some(Meaning::Sampling));
    let mut cases = samples.filter_map(|it| it.counts_for);
    cases.find_map(|Case { reference, item }| {
        let choice = table.by_reference(reference)?;
        let (Place::Parameter(place), Kind::Enumeration(of)) = (choice.place, choice.variable.kind) else {
            return None;
        };
        if table.in_use(place, parameters) != f64::from(item) {
            return None;
        }
        let (_, name, _) = of.items.iter().find(|(id, ..)| *id == item)?;
        Some(format!("{} = {name}", choice.variable.name))
    })
}

fn along(entry: &Entry, parameters: &[f64]) -> Result<Along, &'static str> {
    match (entry.place, entry.state, entry.variable.kind) {
        (Place::Time, ..) => Err("it is the time"),
        (Place::Computed(_), Some(state), _) => Ok(Along::State(state)),
        (Place::Computed(_), None, _) => Err("it is computed, and no continuous state"),
        (_, _, Kind::Enumeration(_)) => Err("it is a choice, which does not vary little by little"),
        (_, _, Kind::Integer) => Err("it is a whole number, which does not vary little by little"),
        (_, _, Kind::Boolean) => Err("it is true or false"),
        (Place::Parameter(_), _, Kind::Real(_)) if entry.variable.meaning == Some(Meaning::Solving) => {
            Err("it changes how a run is computed, not what is computed")
        }
        (Place::Parameter(_), _, Kind::Real(_)) if entry.variable.meaning == Some(Meaning::Sampling) => {
            Err("it says when samples are taken, and these see the inputs of a communication point")
        }
        (Place::Parameter(_), _, Kind::Real(_)) if !entry.variable.varies => Err(
            "the equations know no slope by it, since it acts in jumps, or as a constant; compare runs with two values of it",
        ),
        (Place::Parameter(place), _, Kind::Real(_)) if entry.variable.absent_at_zero && parameters[place] == 0.0 => {
            Err("it is 0, which stands for none, and a little of it is another system")
        }
        (Place::Parameter(place), _, Kind::Real(_)) if entry.variable.turns_at_zero && parameters[place] == 0.0 => {
            Err("it is 0, and its slope upwards differs from its slope downwards")
        }
        (Place::Parameter(place), _, Kind::Real(_)) => Ok(Along::Parameter(place)),
        (Place::Input(place), _, Kind::Real(_)) => Ok(Along::Input(place)),
    }
}
