//! Values that users give to variables by name, and why they may be refused.

use std::fmt;

use super::{Entry, Kind, ParameterError, Table, Variable};

/// A value as users write it: a number, the name of an item of an enumeration, or true or false.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// A number, in the SI unit of the variable.
    Number(f64),
    /// The name of an item of an enumeration.
    Item(&'a str),
    /// True or false.
    Flag(bool),
}

impl From<f64> for Value<'_> {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<i32> for Value<'_> {
    fn from(value: i32) -> Self {
        Self::Number(value.into())
    }
}

impl<'a> From<&'a str> for Value<'a> {
    fn from(value: &'a str) -> Self {
        Self::Item(value)
    }
}

impl From<bool> for Value<'_> {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value}"),
            Self::Item(value) => write!(f, "\"{value}\""),
            Self::Flag(value) => write!(f, "{value}"),
        }
    }
}

impl Value<'_> {
    /// The number that stands for the value in the table.
    ///
    /// # Errors
    /// [`SettingError`] if the variable cannot have such a value.
    pub fn number(self, variable: &Variable) -> Result<f64, SettingError> {
        let number = match (self, variable.kind) {
            (Self::Number(value), _) => Some(value),
            (Self::Flag(value), Kind::Boolean) => Some(value.into()),
            (Self::Item(name), Kind::Enumeration(of)) => of.id(name).map(f64::from),
            _ => None,
        };
        let Some(number) = number else {
            let (name, value) = (variable.name.clone(), self.to_string());
            return Err(SettingError::Type { name, value, expected: expected(variable.kind) });
        };
        variable.check(number)?;
        Ok(number)
    }
}

fn expected(kind: Kind) -> String {
    match kind {
        Kind::Real(unit) => format!("a number in {}", unit.name),
        Kind::Integer => "an integer".to_owned(),
        Kind::Boolean => "true or false".to_owned(),
        Kind::Enumeration(of) => {
            let names: Vec<_> = of.items.iter().map(|(_, name, _)| *name).collect();
            format!("one of {}", names.join(", "))
        }
    }
}

/// Why a variable cannot be set or read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SettingError {
    /// The model has no variable of this name.
    Unknown {
        /// The name.
        name: String,
        /// Names of the model that resemble it.
        similar: Vec<String>,
    },
    /// The variable cannot be set, or not now.
    NotSettable {
        /// The name.
        name: String,
        /// Why.
        reason: &'static str,
    },
    /// The value is of a kind that the variable cannot have.
    Type {
        /// The name of the variable.
        name: String,
        /// The value.
        value: String,
        /// Requirement on it.
        expected: String,
    },
    /// The value is out of range, or does not fit to others.
    Refused(ParameterError),
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { name, similar } if similar.is_empty() => write!(f, "there is no variable {name}"),
            Self::Unknown { name, similar } => {
                write!(f, "there is no variable {name}; did you mean {}?", similar.join(" or "))
            }
            Self::NotSettable { name, reason } => write!(f, "{name} cannot be set: {reason}"),
            Self::Type { name, value, expected } => write!(f, "{name} = {value} is refused: it must be {expected}"),
            Self::Refused(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SettingError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Refused(error) => Some(error),
            _ => None,
        }
    }
}

impl From<ParameterError> for SettingError {
    fn from(error: ParameterError) -> Self {
        Self::Refused(error)
    }
}

/// The entry of a name in a table.
///
/// # Errors
/// [`SettingError::Unknown`] if there is none.
pub fn find<'a>(table: &'a Table, name: &str) -> Result<Entry<'a>, SettingError> {
    table.find(name).ok_or_else(|| {
        let similar = table.similar(name).into_iter().map(str::to_owned).collect();
        SettingError::Unknown { name: name.to_owned(), similar }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::units;

    crate::enumeration! {
        /// A direction.
        Way "Way": "Where to go" {
            1 Left: "To the left";
            3 Right: "To the right";
        }
    }

    fn table() -> Table {
        Table::new(vec![
            Variable::time(),
            Variable::parameter(1, "length", units::METRE, 1.0).at_least(0.0),
            Variable::count(2, "number", 3),
            Variable::option(3, "open", false),
            Variable::choice(4, "way", Way::Left),
        ])
    }

    fn number(name: &str, value: impl Into<Value<'static>>) -> Result<f64, String> {
        let table = table();
        let entry = find(&table, name).map_err(|error| error.to_string())?;
        value.into().number(entry.variable).map_err(|error| error.to_string())
    }

    #[test]
    fn values_are_numbers_items_and_flags() {
        assert_eq!([number("length", 0.5), number("number", 7), number("way", 3)], [Ok(0.5), Ok(7.0), Ok(3.0)]);
        assert_eq!([number("open", true), number("open", false), number("open", 1)], [Ok(1.0), Ok(0.0), Ok(1.0)]);
        assert_eq!([number("way", "Left"), number("way", "Right")], [Ok(1.0), Ok(3.0)]);
    }

    #[test]
    fn refusal_says_what_a_variable_must_be() {
        let refused = |found: Result<f64, String>| found.expect_err("no such value");
        assert_eq!(refused(number("length", "long")), "length = \"long\" is refused: it must be a number in m");
        assert_eq!(refused(number("length", -1.0)), "length = -1 is refused: it must be at least 0");
        assert_eq!(refused(number("number", true)), "number = true is refused: it must be an integer");
        assert_eq!(refused(number("open", "yes")), "open = \"yes\" is refused: it must be true or false");
        assert_eq!(refused(number("way", "Up")), "way = \"Up\" is refused: it must be one of Left, Right");
        assert_eq!(refused(number("way", false)), "way = false is refused: it must be one of Left, Right");
    }

    #[test]
    fn unknown_name_is_answered_with_those_that_resemble_it() {
        assert_eq!(number("lenght", 1.0), Err("there is no variable lenght; did you mean length?".to_owned()));
        assert_eq!(number("voltage", 1.0), Err("there is no variable voltage".to_owned()));
    }
}
