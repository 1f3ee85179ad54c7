//! Where the value of each variable of a model is kept.

use super::failure::Failure;
use super::guid::guid;
use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Entry, Kind, Place, Table, Variable};

/// The base types of the interface; an enumeration is read and written as an integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// A real number.
    Real,
    /// An integer with 32 bits.
    Integer,
    /// True or false.
    Boolean,
    /// Text; no variable has it.
    Text,
}

/// A variable and what the interface needs to know about it.
#[derive(Debug)]
pub struct Slot {
    /// The variable.
    pub variable: &'static Variable,
    /// Its base type.
    pub base: Base,
    /// Its place.
    pub place: Place,
    /// If it is a continuous state, its number in the order in which the table lists the derivatives.
    pub state: Option<usize>,
}

/// The variables of a model as the interface needs them; made once per model.
pub struct Layout {
    /// The model.
    pub model: &'static Model,
    /// Its variables.
    pub table: &'static Table,
    /// Its GUID.
    pub guid: String,
    /// Its inputs.
    pub inputs: Vec<&'static Variable>,
    /// Its parameters.
    pub parameters: Vec<&'static Variable>,
    /// Its computed variables.
    pub computed: Vec<&'static Variable>,
    /// How many continuous states it has.
    pub states: usize,
    /// How many event indicators it has.
    pub indicators: usize,
}

impl Layout {
    /// The layout of a model.
    pub fn new(model: &'static Model) -> Self {
        let table = (model.variables)();
        Self {
            model,
            table,
            guid: guid(model),
            inputs: table.inputs().collect(),
            parameters: table.parameters().collect(),
            computed: table.computed().collect(),
            states: table.number_of_states(),
            indicators: (model.indicators)().len(),
        }
    }

    /// The slot of a value reference.
    pub fn slot(&self, reference: u32) -> Option<Slot> {
        let Entry { variable, place, state } = self.table.by_reference(reference)?;
        Some(Slot { variable, base: base(variable.kind), place, state })
    }

    /// The slot of a value reference, which must have a type.
    pub fn typed_slot(&self, reference: u32, base: Base) -> Result<Slot, Failure> {
        let slot = self
            .slot(reference)
            .ok_or_else(|| Failure::error(format!("there is no variable with value reference {reference}")))?;
        if slot.base != base {
            let (name, actual) = (&slot.variable.name, slot.base);
            return Err(Failure::error(format!("{name} (value reference {reference}) is {actual:?}, not {base:?}")));
        }
        Ok(slot)
    }
}

fn base(kind: Kind) -> Base {
    match kind {
        Kind::Real(_) => Base::Real,
        Kind::Integer | Kind::Enumeration(_) => Base::Integer,
        Kind::Boolean => Base::Boolean,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::testing;
    use pneumatic_servo::models;

    #[test]
    fn every_variable_of_every_model_is_found_by_its_reference() {
        for model in models::ALL.iter().chain([&testing::MODEL]) {
            let layout = Layout::new(model);
            for variable in (model.variables)() {
                let slot = layout.slot(variable.reference).expect("a slot");
                assert_eq!(slot.variable.name, variable.name, "value references must be unique");
                let (group, place) = match slot.place {
                    Place::Time => continue,
                    Place::Input(place) => (&layout.inputs, place),
                    Place::Parameter(place) => (&layout.parameters, place),
                    Place::Computed(place) => (&layout.computed, place),
                };
                assert_eq!(group[place].name, variable.name);
            }
        }
    }

    #[test]
    fn states_are_numbered_in_the_order_of_their_derivatives() {
        for model in models::ALL.iter().chain([&testing::MODEL]) {
            let layout = Layout::new(model);
            let states = (model.variables)().iter().filter_map(|variable| variable.derivative_of);
            for (number, reference) in states.enumerate() {
                assert_eq!(layout.slot(reference).expect("a state").state, Some(number));
            }
        }
    }

    #[test]
    fn unknown_references_have_no_slot() {
        let layout = Layout::new(&testing::MODEL);
        for reference in [7, 500, 1 << 20, u32::MAX] {
            assert!(layout.slot(reference).is_none(), "{reference}");
        }
    }

    #[test]
    fn wrong_type_is_refused_by_name() {
        let layout = Layout::new(&testing::MODEL);
        let failure = layout.typed_slot(testing::INPUT, Base::Integer).expect_err("a real variable");
        assert!(failure.message.contains("input") && failure.message.contains("Real, not Integer"), "{failure:?}");
    }
}
