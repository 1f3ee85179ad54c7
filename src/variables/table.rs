//! The variables of a model, found by name, by value reference and by place.

use std::iter;
use std::ops::Deref;

use super::{Case, Condition, Enumeration, Following, Kind, Meaning, ParameterError, Role, Tunable, Variable, array};
use crate::numbers::{STILL, Slopes};

/// The place of a value among the values of its kind, in the order of the table.
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
pub struct Entry<'a> {
    /// The variable.
    pub variable: &'a Variable,
    /// The place of its value.
    pub place: Place,
    /// If it is a continuous state, its number in the order in which the table lists the derivatives.
    pub state: Option<usize>,
}

/// All variables of a model.
#[derive(Debug)]
pub struct Table {
    variables: Box<[Variable]>,
    places: Vec<Place>,
    states: Vec<Option<usize>>,
    /// Places of the enumeration parameters, in the order of the Integers that can choose for them: the last parameters.
    numbered: Vec<usize>,
    /// Number of elements of the array that begins with a variable: 1 if it is none, 0 for its further elements.
    lengths: Vec<usize>,
    /// Indices in the order of the names.
    by_name: Vec<usize>,
    /// Indices by value reference, or [`NONE`].
    by_reference: Vec<u32>,
    /// Why no run can start.
    problem: Option<ParameterError>,
}

const NONE: u32 = u32::MAX;

/// The group of the variables of the solver, which every model has.
pub(crate) const SOLVER: &str = "solver";

/// The largest value reference: there is a slot for each up to the largest that is used.
const LARGEST: u32 = 10_000_000;

impl Table {
    /// The table of a model; behind the variables given come the Integers that can choose for its enumerations. Descriptions
    /// end with the conditions under which a variable counts.
    ///
    /// If two variables have the same name or value reference, one refers to a variable that is not there, or elements of an array
    /// do not follow each other, the table has a [`problem`](Self::problem).
    pub fn new(mut variables: Vec<Variable>) -> Self {
        let parameters = variables.iter().filter(|variable| variable.is_parameter());
        let (numbered, numbers): (Vec<_>, Vec<_>) =
            parameters.enumerate().filter_map(|(place, variable)| Some((place, variable.number()?))).unzip();
        variables.extend(numbers);
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
        let mut by_name: Vec<usize> = (0..variables.len()).collect();
        by_name.sort_by_key(|index| variables[*index].name.as_str());
        let twice = by_name.windows(2).find(|pair| variables[pair[0]].name == variables[pair[1]].name);
        let about = |variable: &Variable, reason: &str| {
            ParameterError::new(&variable.name, f64::from(variable.reference), reason)
        };
        let mut problem = twice.map(|pair| {
            let variable = &variables[pair[1]];
            about(variable, &format!("two variables have the name {}", variable.name))
        });
        let largest = variables.iter().map(|variable| variable.reference.min(LARGEST)).max().unwrap_or(0);
        let mut by_reference = vec![NONE; largest as usize + 1];
        for (index, variable) in variables.iter().enumerate() {
            let Some(slot) = by_reference.get_mut(variable.reference as usize) else {
                problem.get_or_insert_with(|| about(variable, &format!("value references go up to {LARGEST}")));
                continue;
            };
            if *slot == NONE {
                *slot = index as u32;
                continue;
            }
            // The author of a model can change its own variables, not the solver's; of two of its own the first is named first.
            let (first, second) = (&variables[*slot as usize], variable);
            let is_solving = |variable: &Variable| variable.group_and_name().0 == SOLVER;
            let (own, other) = if is_solving(first) { (second, first) } else { (first, second) };
            let reason = format!("the value reference {} of {} is taken by {}", own.reference, own.name, other.name);
            problem.get_or_insert_with(|| about(own, &reason));
        }
        for variable in &variables {
            let lost = variable
                .derivative_of
                .iter()
                .chain(variable.depends_on.iter().flatten())
                .chain(&variable.starts_from)
                .find(|reference| by_reference.get(**reference as usize).is_none_or(|index| *index == NONE));
            if let Some(lost) = lost {
                let reason = format!("no variable has the value reference {lost}, on which {} depends", variable.name);
                problem.get_or_insert_with(|| about(variable, &reason));
            }
        }
        for variable in variables.iter().filter(|variable| !variable.is_computed()) {
            let default = variable.start.map(|start| (start, variable.check(start)));
            if let Some((start, Err(ParameterError { reason, .. }))) = default {
                let reason = format!("as the default of {}, {reason}", variable.name);
                problem.get_or_insert_with(|| ParameterError::new(&variable.name, start, &reason));
            }
        }
        for (variable, case) in variables.iter().filter_map(|variable| Some((variable, variable.counts_for?))) {
            if !variables.iter().any(|choice| choice.has(case)) {
                let Case { reference, item } = case;
                let reason = format!(
                    "no variable with the value reference {reference} has an item {item} to choose, for which {} counts",
                    variable.name
                );
                problem.get_or_insert_with(|| about(variable, &reason));
            }
        }
        let known = |name: &str| by_name.binary_search_by_key(&name, |index| variables[*index].name.as_str()).ok();
        for variable in &variables {
            let about_what = variable.counts_where.iter().flat_map(Condition::parameters);
            let is_parameter = |name: &str| known(name).is_some_and(|place| variables[by_name[place]].is_parameter());
            if let Some(lost) = about_what.into_iter().find(|name| !is_parameter(name)) {
                let reason = format!("no parameter has the name {lost}, on which depends whether it counts");
                problem.get_or_insert_with(|| about(variable, &reason));
            }
        }
        let derivatives = variables.iter().filter_map(|variable| Some((variable, variable.derivative_of?)));
        for (number, (variable, state)) in derivatives.enumerate() {
            let is = |other: &Variable| other.reference == state;
            if states.iter().take(number).any(|other| *other == state) {
                problem.get_or_insert_with(|| about(variable, "another variable is the derivative of the same state"));
            } else if let Some(of) = variables.iter().find(|other| is(other) && !other.is_computed()) {
                let reason = format!("{} is not computed, and has no derivative", of.name);
                problem.get_or_insert_with(|| about(variable, &reason));
            }
        }
        let number = |variable: &Variable| states.iter().position(|state| *state == variable.reference);
        let states = variables.iter().map(number).collect();
        let (lengths, stray) = array::lengths(&variables);
        if let Some(stray) = stray {
            problem.get_or_insert_with(|| about(stray, "it does not follow the other elements of its array"));
        }
        let find = |name: &str| Some(&variables[by_name[known(name)?]]);
        let sentences: Vec<_> = variables.iter().map(|variable| Self::sentence(variable, find)).collect();
        for (variable, sentence) in variables.iter_mut().zip(sentences) {
            variable.description.extend(sentence.iter().flat_map(|sentence| [". ", sentence]));
        }
        let variables = variables.into_boxed_slice();
        Self { variables, places, states, numbered, lengths, by_name, by_reference, problem }
    }

    /// The same with another problem, if it has none yet.
    pub(crate) fn with_problem(mut self, problem: Option<ParameterError>) -> Self {
        self.problem = self.problem.or(problem);
        self
    }

    /// Error in the table, by the name of a variable; no run starts then.
    pub fn problem(&self) -> Option<&ParameterError> {
        self.problem.as_ref()
    }

    /// The entry of a variable, by its index.
    fn entry(&self, index: usize) -> Entry<'_> {
        Entry { variable: &self.variables[index], place: self.places[index], state: self.states[index] }
    }

    /// All entries, in order.
    pub fn entries(&self) -> impl Iterator<Item = Entry<'_>> {
        (0..self.variables.len()).map(|index| self.entry(index))
    }

    /// The variable of a name.
    pub fn find(&self, name: &str) -> Option<Entry<'_>> {
        let found = self.by_name.binary_search_by_key(&name, |index| self.variables[*index].name.as_str());
        found.ok().map(|place| self.entry(self.by_name[place]))
    }

    /// The variable of a value reference.
    pub fn by_reference(&self, reference: u32) -> Option<Entry<'_>> {
        let index = *self.by_reference.get(reference as usize)?;
        (index != NONE).then(|| self.entry(index as usize))
    }

    /// The arrays, in order: the number of elements of each, and the first of them. A variable that is no element of an
    /// array is one of a single element.
    pub fn arrays(&self) -> impl Iterator<Item = (usize, &Variable)> {
        self.lengths.iter().copied().zip(&self.variables).filter(|(length, _)| *length > 0)
    }

    /// Number of elements of the array that begins with the variable of a value reference, if there is one.
    pub fn length_at(&self, reference: u32) -> Option<usize> {
        let index = *self.by_reference.get(reference as usize)?;
        (index != NONE).then(|| self.lengths[index as usize]).filter(|length| *length > 0)
    }

    /// The value reference of the first element of the array that a variable is in, and its number among the elements,
    /// counted from 1; nothing for a variable that is in no array.
    pub fn array_at(&self, reference: u32) -> Option<(u32, usize)> {
        let index = *self.by_reference.get(reference as usize)? as usize;
        let further = self.lengths.get(..=index)?.iter().rev().position(|length| *length > 0)?;
        (self.lengths[index - further] > 1).then(|| (reference - further as u32, further + 1))
    }

    /// The enumeration parameter of a case, and the name of the item.
    pub fn case(&self, case: Case) -> Option<(&Variable, &'static str)> {
        let choice = self.by_reference(case.reference)?.variable;
        let Kind::Enumeration(of) = choice.kind else { return None };
        of.items.iter().find(|(id, ..)| *id == case.item).map(|(_, name, _)| (choice, *name))
    }

    /// The choice of a friction law, the first if a model has several contacts.
    pub fn friction_law(&self) -> Option<(&Variable, &'static Enumeration)> {
        self.parameters().find_map(|variable| match (variable.meaning, variable.kind) {
            (Some(Meaning::FrictionLaw), Kind::Enumeration(laws)) => Some((variable, laws)),
            _ => None,
        })
    }

    /// The inputs, in order.
    pub fn inputs(&self) -> impl Iterator<Item = &Variable> {
        self.variables.iter().filter(|variable| variable.role == Role::Input)
    }

    /// The parameters, in order.
    pub fn parameters(&self) -> impl Iterator<Item = &Variable> {
        self.variables.iter().filter(|variable| variable.is_parameter())
    }

    /// The parameters of the model itself for the values of all: each enumeration as its number chooses, if that is not 0.
    /// They vary with the slopes given for all in the same order, or not at all.
    pub fn chosen(&self, parameters: &[f64], slopes: &[Slopes]) -> Vec<Tunable> {
        let (own, numbers) = parameters.split_at(parameters.len() - self.numbered.len());
        let slopes = slopes.iter().copied().chain(iter::repeat(STILL));
        let mut own: Vec<_> = own.iter().zip(slopes).map(|(&value, slopes)| Tunable { value, slopes }).collect();
        for (place, number) in self.numbered.iter().zip(numbers) {
            if *number != 0.0 {
                own[*place] = Tunable::still(*number);
            }
        }
        own
    }

    /// The value in use of the parameter in a place, for the values of all.
    pub fn in_use(&self, place: usize, parameters: &[f64]) -> f64 {
        let numbers = &parameters[parameters.len() - self.numbered.len()..];
        let number =
            self.numbered.iter().zip(numbers).find(|(numbered, number)| **numbered == place && **number != 0.0);
        number.map_or(parameters[place], |(_, number)| *number)
    }

    /// The computed variables, in order.
    pub fn computed(&self) -> impl Iterator<Item = &Variable> {
        self.variables.iter().filter(|variable| variable.is_computed())
    }

    /// Value references of the continuous states, in the order in which the table lists their derivatives.
    pub fn states(&self) -> impl Iterator<Item = u32> {
        self.variables.iter().filter_map(|variable| variable.derivative_of)
    }

    /// Value references of the time, the inputs and the states on which a variable of the table depends directly: what it declares;
    /// of a computed variable that declares nothing all of them.
    pub fn dependencies(&self, variable: &Variable) -> Vec<u32> {
        let all = || {
            let known = self.iter().filter(|it| matches!(it.role, Role::Time | Role::Input));
            known.map(|it| it.reference).chain(self.states()).collect()
        };
        variable.depends_on.clone().unwrap_or_else(|| if variable.is_computed() { all() } else { Vec::new() })
    }

    /// Value references of the inputs and of the time that a computed variable depends on at initialization, where states
    /// follow from inputs, if from anything but parameters.
    pub fn initial_dependencies(&self, variable: &Variable) -> Vec<u32> {
        let of_state = |reference: u32| match self.by_reference(reference) {
            Some(Entry { state: Some(_), variable, .. }) => variable.starts_from.clone(),
            _ => vec![reference],
        };
        let mut references: Vec<u32> = self.dependencies(variable).into_iter().flat_map(of_state).collect();
        references.sort_unstable();
        references.dedup();
        references
    }

    /// The parameter that the default of another one follows where it does not fit that, and how: the static friction of its law, for a
    /// level of Coulomb friction.
    pub fn leader(&self, variable: &Variable) -> Option<(&Variable, Following)> {
        if let Some((leader, how)) = &variable.follows {
            return Some((self.find(leader)?.variable, *how));
        }
        let is_leader =
            |own: &&Variable| own.meaning == Some(Meaning::StaticFriction) && own.counts_for == variable.counts_for;
        let is_level = variable.meaning == Some(Meaning::CoulombFriction);
        is_level.then(|| self.iter().find(is_leader)).flatten().map(|leader| (leader, Following::InProportion))
    }

    /// Number of continuous states.
    pub fn number_of_states(&self) -> usize {
        self.states.iter().flatten().count()
    }

    /// Names that resemble one that is not in the table, the nearest first: at most three.
    pub fn similar(&self, name: &str) -> Vec<&str> {
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
        &self.variables
    }
}

impl<'a> IntoIterator for &'a Table {
    type Item = &'a Variable;
    type IntoIter = std::slice::Iter<'a, Variable>;
    fn into_iter(self) -> Self::IntoIter {
        self.variables.iter()
    }
}

/// Edit distance: characters to insert, remove or replace to turn one word into another, ignoring case (Levenshtein 1966,
/// Soviet Physics Doklady 10(8):707-710).
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
    use crate::variables::{Kind, units};

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

    crate::enumeration! {
        /// A direction.
        Way "Way": "Where to go" {
            1 Left: "To the left";
            3 Right: "To the right";
        }
    }

    /// An enumeration between two other parameters.
    fn ways() -> Table {
        Table::new(vec![
            Variable::parameter(20, "first", units::ONE, 1.0),
            Variable::choice(21, "walk.way", Way::Left),
            Variable::parameter(22, "last", units::ONE, 2.0),
        ])
    }

    #[test]
    fn every_enumeration_has_a_number_behind_all_other_parameters() {
        let table = ways();
        let Entry { variable, place, .. } = table.find("walk.wayNumber").expect("found");
        assert_eq!((variable.reference, place, variable.role), (20_021, Place::Parameter(3), Role::Fixed));
        assert_eq!((variable.kind, variable.start), (Kind::Integer, Some(0.0)));
        assert_eq!((variable.min, variable.max), (Some(0.0), Some(3.0)));
    }

    #[test]
    fn number_chooses_unless_it_is_0_and_the_enumeration_says_what_is_chosen() {
        let table = ways();
        for (number, way) in [(0.0, 1.0), (1.0, 1.0), (3.0, 3.0)] {
            let all = [5.0, 1.0, 6.0, number];
            assert_eq!(table.chosen(&all, &[]), [5.0, way, 6.0].map(Tunable::still));
            assert_eq!([0, 1, 2, 3].map(|place| table.in_use(place, &all)), [5.0, way, 6.0, number]);
        }
    }

    #[test]
    fn number_of_no_item_is_refused_by_name_and_value() {
        let table = ways();
        let number = table.find("walk.wayNumber").expect("found").variable;
        let refused = |value: f64| number.check(value).expect_err("no item").to_string();
        assert_eq!(refused(2.0), "walk.wayNumber = 2 is refused: it must be 0 or the number of an item of Way");
        assert_eq!(refused(1.5), "walk.wayNumber = 1.5 is refused: it must be 0 or the number of an item of Way");
        assert_eq!(refused(4.0), "walk.wayNumber = 4 is refused: it must be at most 3");
        assert_eq!([0.0, 1.0, 3.0].map(|value| number.check(value)), [Ok(()), Ok(()), Ok(())]);
    }

    #[test]
    fn misspelt_names_are_recognised() {
        assert_eq!(table().similar("valve.c")[0], "valve.C");
        assert_eq!(table().similar("votlage"), ["voltage"]);
        assert!(table().similar("somethingElse").is_empty());
    }
}
