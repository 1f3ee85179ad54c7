//! Where the value of each variable of a model is kept.

use super::failure::Failure;
use super::guid::guid;
use super::types::ValueReference;
use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Role, Variable};

/// The base types of the interface; an enumeration is read and written as an integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer`.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
    /// `fmi2String`; no variable has it.
    Text,
}

/// The place of a value among those of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The time.
    Time,
    /// An input.
    Input(usize),
    /// A parameter.
    Parameter(usize),
    /// A computed variable.
    Computed(usize),
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

/// The variables of a model by value reference and by place; made once per model.
pub struct Layout {
    /// The model.
    pub model: &'static Model,
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
    slots: Vec<Slot>,
    /// The index in `slots` by value reference, or [`NONE`].
    by_reference: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Layout {
    /// The layout of a model.
    pub fn new(model: &'static Model) -> Self {
        let variables = (model.variables)();
        let largest = variables.iter().map(|variable| variable.reference as usize).max().unwrap_or(0);
        let mut layout = Self {
            model,
            guid: guid(model),
            inputs: Vec::new(),
            parameters: Vec::new(),
            computed: Vec::new(),
            states: variables.iter().filter(|variable| variable.derivative_of.is_some()).count(),
            slots: Vec::with_capacity(variables.len()),
            by_reference: vec![NONE; largest + 1],
        };
        for variable in variables {
            layout.by_reference[variable.reference as usize] = layout.slots.len() as u32;
            let place = layout.place(variable);
            let mut states = variables.iter().filter_map(|other| other.derivative_of);
            let state = states.position(|state| state == variable.reference);
            layout.slots.push(Slot { variable, base: base(variable.kind), place, state });
        }
        layout
    }

    /// The slot of a value reference.
    pub fn slot(&self, reference: ValueReference) -> Option<&Slot> {
        self.slots.get(*self.by_reference.get(reference as usize)? as usize)
    }

    /// The slot of a value reference, which must have a type.
    pub fn typed_slot(&self, reference: ValueReference, base: Base) -> Result<&Slot, Failure> {
        let slot = self
            .slot(reference)
            .ok_or_else(|| Failure::error(format!("there is no variable with value reference {reference}")))?;
        if slot.base != base {
            let (name, actual) = (&slot.variable.name, slot.base);
            return Err(Failure::error(format!("{name} (value reference {reference}) is {actual:?}, not {base:?}")));
        }
        Ok(slot)
    }

    fn place(&mut self, variable: &'static Variable) -> Place {
        let (group, place): (_, fn(usize) -> Place) = match variable.role {
            Role::Time => return Place::Time,
            Role::Input => (&mut self.inputs, Place::Input),
            Role::Fixed | Role::Tunable => (&mut self.parameters, Place::Parameter),
            Role::Output | Role::Local => (&mut self.computed, Place::Computed),
        };
        group.push(variable);
        place(group.len() - 1)
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
    use crate::fmi2::testing;
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
