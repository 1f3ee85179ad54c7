//! The layout of values: the place of each variable of a model.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use super::guid::guid_of_source;
use crate::failure::Failure;
use pneumatic_servo::model::Model;
use pneumatic_servo::system::Indicator;
use pneumatic_servo::variables::{Entry, Kind, Table, Variable};
use pneumatic_servo_variant::Resolved;

/// Variables that the functions of a C interface read and write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// A real number.
    Real,
    /// An integer with 32 bits, or the number of an item of an enumeration.
    Integer,
    /// An integer with 32 bits, but not an enumeration.
    Count,
    /// The number of an item of an enumeration.
    Enumeration,
    /// True or false.
    Boolean,
    /// A type by its name in the standard that no variable has.
    Absent(&'static str),
}

impl Base {
    /// Whether values of a kind can be read and written as this.
    fn holds(self, kind: Kind) -> bool {
        matches!(
            (self, kind),
            (Self::Real, Kind::Real(_))
                | (Self::Integer | Self::Count, Kind::Integer)
                | (Self::Integer | Self::Enumeration, Kind::Enumeration(_))
                | (Self::Boolean, Kind::Boolean)
        )
    }
}

impl fmt::Display for Base {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Real => "Real",
            Self::Integer | Self::Count => "Integer",
            Self::Enumeration => "Enumeration",
            Self::Boolean => "Boolean",
            Self::Absent(name) => name,
        })
    }
}

/// The variables of a model as the interface needs them; made once per model.
#[derive(Clone)]
pub struct Layout {
    /// The model.
    pub model: &'static Model,
    /// Its variables.
    pub table: Arc<Table>,
    /// Its GUID.
    pub guid: String,
    /// Start values of the inputs.
    pub inputs: Vec<f64>,
    /// Start values of the parameters.
    pub parameters: Vec<f64>,
    /// Of a variant: its name, and the value references of inputs and parameters that may be set.
    pub variant: Option<(String, BTreeSet<u32>)>,
    /// Number of computed variables.
    pub computed: usize,
    /// Number of continuous states.
    pub states: usize,
    /// Its event indicators.
    pub indicators: Vec<Indicator>,
    /// Its event indicators as variables.
    pub indicator_variables: Vec<Variable>,
}

impl Layout {
    /// The layout of a model from a source with a fingerprint, if it is not one of [`pneumatic_servo`].
    pub fn new(model: &'static Model, source: Option<&str>) -> Self {
        let table = model.shared_table();
        let start = |variable: &Variable| variable.start.unwrap_or_default();
        Self {
            model,
            guid: guid_of_source(model, source),
            inputs: table.inputs().map(start).collect(),
            parameters: table.parameters().map(start).collect(),
            variant: None,
            computed: table.computed().count(),
            states: table.number_of_states(),
            indicators: model.indicators(),
            indicator_variables: model.indicator_variables(),
            table,
        }
    }

    /// The layout of a variant of the model.
    pub fn varied(&self, guid: String, name: String, resolved: Resolved) -> Self {
        let Resolved { parameters, inputs, settable, outputs: _ } = resolved;
        Self { guid, inputs, parameters, variant: Some((name, settable)), ..self.clone() }
    }

    /// Refuses to set a variable that a variant has fixed.
    pub fn check_kept(&self, variable: &Variable) -> Result<(), Failure> {
        match &self.variant {
            Some((variant, settable)) if !(variable.is_computed() || settable.contains(&variable.reference)) => {
                Err(Failure::error(format!("{} is fixed in {variant} and cannot be set", variable.name)))
            }
            _ => Ok(()),
        }
    }

    /// The entry of a value reference, which must have a type.
    #[inline(always)]
    pub fn typed(&self, reference: u32, base: Base) -> Result<Entry<'_>, Failure> {
        let entry = self.table.by_reference(reference).ok_or_else(|| unknown(reference))?;
        check_type(entry.variable, base)?;
        Ok(entry)
    }

    /// The name of a computed variable, by its place.
    pub fn computed_name(&self, place: usize) -> &str {
        self.table.computed().nth(place).map_or("a computed variable", |variable| variable.name.as_str())
    }

    /// The value references of the elements of the array that begins at one; of a single variable just this.
    pub fn elements(&self, reference: u32) -> Result<Range<u32>, Failure> {
        if let Some(indicator) = self.indicator(reference) {
            let name = &self.indicator_variables[indicator].name;
            let reason = "is an event indicator, which can be read but neither set nor differentiated";
            return Err(Failure::error(format!("{name} {reason}")));
        }
        let length = self.table.length_at(reference).ok_or_else(|| unknown(reference))?;
        Ok(reference..reference + length as u32)
    }

    /// The number of the event indicator that has a value reference, if one has it.
    pub fn indicator(&self, reference: u32) -> Option<usize> {
        self.indicator_variables.iter().position(|variable| variable.reference == reference)
    }
}

/// Refuses to read or write a variable as something that it is not.
pub fn check_type(variable: &Variable, base: Base) -> Result<(), Failure> {
    if base.holds(variable.kind) { Ok(()) } else { Err(mistyped(variable, base)) }
}

#[cold]
fn mistyped(variable: &Variable, base: Base) -> Failure {
    let (name, reference) = (&variable.name, variable.reference);
    let actual = match variable.kind {
        Kind::Real(_) => Base::Real,
        Kind::Integer => Base::Integer,
        Kind::Enumeration(_) => Base::Enumeration,
        Kind::Boolean => Base::Boolean,
    };
    Failure::error(format!("{name} (value reference {reference}) is {actual}, not {base}"))
}

#[cold]
fn unknown(reference: u32) -> Failure {
    Failure::error(format!("there is no variable with value reference {reference}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing;

    #[test]
    fn unknown_references_have_no_entry() {
        let layout = Layout::new(&testing::MODEL, None);
        for reference in [7, 500, 1 << 20, u32::MAX] {
            assert!(layout.typed(reference, Base::Real).is_err(), "{reference}");
        }
    }

    #[test]
    fn wrong_type_is_refused_by_name() {
        let layout = Layout::new(&testing::MODEL, None);
        let failure = layout.typed(testing::INPUT, Base::Integer).expect_err("a real variable");
        assert!(failure.message.contains("input") && failure.message.contains("Real, not Integer"), "{failure:?}");
    }
}
