//! The variables of a model, found by name, by value reference and by place.

use std::ops::Deref;

use super::{Role, Variable};

/// The place of a value among those of its kind, in the order of the table.
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

/// An entry of a [`Table`]: a variable, where its value is kept, and what else follows from the table as a whole.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The variable.
    pub variable: &'static Variable,
    /// The place of its value.
    pub place: Place,
    /// If it is a continuous state, its number in the order in which the table lists the derivatives.
    pub state: Option<usize>,
}

/// All variables of a model; made once per process.
#[derive(Debug)]
pub struct Table {
    variables: &'static [Variable],
    places: Vec<Place>,
    states: Vec<Option<usize>>,
    /// Indices in the order of the names.
    by_name: Vec<usize>,
    /// Indices by value reference, or [`NONE`].
    by_reference: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Table {
    /// The table of a model.
    ///
    /// # Panics
    /// If two variables have the same name or value reference, or one refers to a variable that is not there.
    pub fn new(variables: Vec<Variable>) -> Self {
        let variables: &'static [Variable] = variables.leak();
        let mut counts = [0; 3];
        let mut next = |kind: usize| {
            counts[kind] += 1;
            counts[kind] - 1
        };
        let places = variables.iter().map(|variable| match variable.role {
            Role::Time => Place::Time,
            Role::Input => Place::Input(next(0)),
            Role::Fixed | Role::Tunable => Place::Parameter(next(1)),
            Role::Output | Role::Local => Place::Computed(next(2)),
        });
        let places = places.collect();
        let states: Vec<u32> = variables.iter().filter_map(|variable| variable.derivative_of).collect();
        let number = |variable: &Variable| states.iter().position(|state| *state == variable.reference);
        let states = variables.iter().map(number).collect();
        let mut by_name: Vec<usize> = (0..variables.len()).collect();
        by_name.sort_by_key(|index| variables[*index].name.as_str());
        let twice = by_name.windows(2).find(|pair| variables[pair[0]].name == variables[pair[1]].name);
        assert!(twice.is_none(), "two variables have the name {}", variables[twice.unwrap_or_default()[0]].name);
        let largest = variables.iter().map(|variable| variable.reference as usize).max().unwrap_or(0);
        let mut by_reference = vec![NONE; largest + 1];
        for (index, Variable { reference, name, .. }) in variables.iter().enumerate() {
            let slot = &mut by_reference[*reference as usize];
            assert!(*slot == NONE, "the value reference {reference} of {name} is used twice");
            *slot = index as u32;
        }
        for reference in variables.iter().flat_map(|variable| variable.derivative_of.iter().chain(&variable.depends_on))
        {
            let known = by_reference.get(*reference as usize).is_some_and(|index| *index != NONE);
            assert!(known, "no variable has the value reference {reference}, on which another depends");
        }
        Self { variables, places, states, by_name, by_reference }
    }

    /// The entry of a variable, by its index.
    fn entry(&self, index: usize) -> Entry {
        Entry { variable: &self.variables[index], place: self.places[index], state: self.states[index] }
    }

    /// All entries, in order.
    pub fn entries(&self) -> impl Iterator<Item = Entry> {
        (0..self.variables.len()).map(|index| self.entry(index))
    }

    /// The variable of a name.
    pub fn find(&self, name: &str) -> Option<Entry> {
        let found = self.by_name.binary_search_by_key(&name, |index| self.variables[*index].name.as_str());
        found.ok().map(|place| self.entry(self.by_name[place]))
    }

    /// The variable of a value reference.
    pub fn by_reference(&self, reference: u32) -> Option<Entry> {
        let index = *self.by_reference.get(reference as usize)?;
        (index != NONE).then(|| self.entry(index as usize))
    }

    /// The inputs, in order.
    pub fn inputs(&self) -> impl Iterator<Item = &'static Variable> {
        self.variables.iter().filter(|variable| variable.role == Role::Input)
    }

    /// The parameters, in order.
    pub fn parameters(&self) -> impl Iterator<Item = &'static Variable> {
        self.variables.iter().filter(|variable| variable.is_parameter())
    }

    /// The computed variables, in order.
    pub fn computed(&self) -> impl Iterator<Item = &'static Variable> {
        self.variables.iter().filter(|variable| variable.is_computed())
    }

    /// Value references of the continuous states, in the order in which the table lists their derivatives.
    pub fn states(&self) -> impl Iterator<Item = u32> {
        self.variables.iter().filter_map(|variable| variable.derivative_of)
    }

    /// Value references of the inputs and of the time that a computed variable depends on at initialization, where states
    /// follow from inputs, if from anything but parameters.
    pub fn initial_dependencies(&self, variable: &Variable) -> Vec<u32> {
        let of_state = |reference: u32| match self.by_reference(reference) {
            Some(Entry { state: Some(_), variable, .. }) => variable.starts_from.clone(),
            _ => vec![reference],
        };
        let mut references: Vec<u32> = variable.depends_on.iter().flat_map(|known| of_state(*known)).collect();
        references.sort_unstable();
        references.dedup();
        references
    }

    /// How many continuous states there are.
    pub fn number_of_states(&self) -> usize {
        self.states.iter().flatten().count()
    }

    /// Names that resemble one that is not in the table, the nearest first: at most three.
    pub fn similar(&self, name: &str) -> Vec<&'static str> {
        let mut near: Vec<_> =
            self.variables.iter().map(|variable| (distance(name, &variable.name), variable.name.as_str())).collect();
        near.sort_unstable();
        let bound = name.len().div_ceil(2);
        near.into_iter().take(3).filter(|(distance, _)| *distance <= bound).map(|(_, name)| name).collect()
    }
}

impl Deref for Table {
    type Target = [Variable];
    fn deref(&self) -> &[Variable] {
        self.variables
    }
}

impl IntoIterator for &Table {
    type Item = &'static Variable;
    type IntoIter = std::slice::Iter<'static, Variable>;
    fn into_iter(self) -> Self::IntoIter {
        self.variables.iter()
    }
}

/// How many characters have to be inserted, removed or replaced to make one word of another, whatever the case
/// (Levenshtein 1966, Soviet Physics Doklady 10(8):707-710).
fn distance(one: &str, other: &str) -> usize {
    let letters = |word: &str| word.to_lowercase().chars().collect::<Vec<_>>();
    let (one, other) = (letters(one), letters(other));
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (i, a) in one.iter().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, b) in other.iter().enumerate() {
            let replaced = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[other.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::units;

    fn table() -> Table {
        Table::new(vec![
            Variable::time(),
            Variable::input(3, "voltage", units::VOLT, 0.0),
            Variable::output(7, "speed", units::METRE_PER_SECOND),
            Variable::output(8, "der(speed)", units::METRE_PER_SECOND_SQUARED).local().derivative_of(7),
            Variable::parameter(20, "valve.C", units::ONE, 1.0),
            Variable::parameter(21, "valve.b", units::ONE, 1.0).tunable(),
        ])
    }

    #[test]
    fn every_variable_is_found_by_name_and_by_reference() {
        let table = table();
        for variable in table.iter() {
            assert_eq!(table.find(&variable.name).expect("found").variable, variable);
            assert_eq!(table.by_reference(variable.reference).expect("found").variable, variable);
        }
        assert!(table.find("valve").is_none());
        assert!([1, 9, 22, u32::MAX].iter().all(|reference| table.by_reference(*reference).is_none()));
    }

    #[test]
    fn places_count_within_their_kind_and_states_by_their_derivatives() {
        let table = table();
        let place = |name: &str| table.find(name).expect("found").place;
        assert_eq!(place("valve.b"), Place::Parameter(1));
        assert_eq!(place("der(speed)"), Place::Computed(1));
        assert_eq!((table.find("speed").expect("found").state, table.number_of_states()), (Some(0), 1));
    }

    #[test]
    fn states_stand_for_what_they_start_from_at_initialization() {
        let table = Table::new(vec![
            Variable::time(),
            Variable::input(3, "voltage", units::VOLT, 0.0),
            Variable::output(7, "speed", units::METRE_PER_SECOND).depends_on(&[7]).starts_from(&[3]),
            Variable::output(8, "der(speed)", units::METRE_PER_SECOND_SQUARED).derivative_of(7).depends_on(&[0, 7]),
        ]);
        let initially = |name: &str| table.initial_dependencies(table.find(name).expect("found").variable);
        assert_eq!((initially("speed"), initially("der(speed)")), (vec![3], vec![0, 3]));
    }

    #[test]
    fn misspelt_names_are_recognised() {
        assert_eq!(table().similar("valve.c")[0], "valve.C");
        assert_eq!(table().similar("votlage"), ["voltage"]);
        assert!(table().similar("somethingElse").is_empty());
    }
}
