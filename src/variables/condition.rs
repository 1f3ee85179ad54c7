//! Conditions under which a variable has an effect, stated at the variable: of an option that must be on, or of a choice.

use super::{Choice, Enumeration, Kind, Table, Variable};

/// One of several statements about parameters, of which at least one must hold for a variable to count.
///
/// ```
/// use pneumatic_servo::prelude::*;
/// use pneumatic_servo::variables::{Condition, Table};
///
/// let table = Table::new(vec![
///     Variable::parameter(1, "spring.stiffness", units::NEWTON_PER_METRE, 0.0).range(0.0, 1e9),
///     Variable::parameter(2, "spring.rest", units::METRE, 0.0).counts_with("spring.stiffness"),
/// ]);
/// let rest = table.find("spring.rest").unwrap().variable;
/// assert_eq!(table.lack(rest, &[0.0, 0.1]).as_deref(), Some("spring.stiffness above 0"));
/// assert_eq!(table.lack(rest, &[5.0, 0.1]), None);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Condition(Vec<Statement>);

/// A statement about the value of a parameter.
#[derive(Clone, Debug, PartialEq)]
struct Statement {
    parameter: String,
    test: Test,
}

#[derive(Clone, Debug, PartialEq)]
enum Test {
    /// Not 0, or true.
    On,
    /// 0, or false.
    Off,
    /// One of the items of an enumeration.
    Is(Vec<i32>),
    /// An item other than these.
    IsNot(Vec<i32>),
    /// A count of this many.
    AtLeast(u32),
}

impl Condition {
    fn new(parameter: &str, test: Test) -> Self {
        Self(vec![Statement { parameter: parameter.to_owned(), test }])
    }

    /// A parameter is not 0, or true.
    pub fn on(parameter: &str) -> Self {
        Self::new(parameter, Test::On)
    }

    /// One of several parameters is not 0, or true.
    pub fn any_on(parameters: &[&str]) -> Self {
        Self(parameters.iter().flat_map(|parameter| Self::on(parameter).0).collect())
    }

    /// A parameter is 0, or false.
    pub fn off(parameter: &str) -> Self {
        Self::new(parameter, Test::Off)
    }

    /// An enumeration parameter has one of the items.
    pub fn is<C: Choice>(parameter: &str, items: &[C]) -> Self {
        Self::new(parameter, Test::Is(items.iter().map(|item| item.id()).collect()))
    }

    /// An enumeration parameter has none of the items.
    pub fn is_not<C: Choice>(parameter: &str, items: &[C]) -> Self {
        Self::new(parameter, Test::IsNot(items.iter().map(|item| item.id()).collect()))
    }

    /// A count is at least a number.
    pub fn at_least(count: &str, number: u32) -> Self {
        Self::new(count, Test::AtLeast(number))
    }

    /// This or another condition.
    pub fn or(self, other: Self) -> Self {
        Self([self.0, other.0].concat())
    }

    /// The same for a variable in a group, whose conditions are about parameters of the group.
    pub(super) fn within(self, group: &str) -> Self {
        let inside = |it: Statement| Statement { parameter: format!("{group}.{}", it.parameter), ..it };
        Self(self.0.into_iter().map(inside).collect())
    }

    /// The parameters that it is about.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|statement| statement.parameter.as_str())
    }

    /// Whether it is about the number of elements alone, which descriptions of arrays say once.
    pub(super) fn is_of_elements(&self) -> bool {
        self.0.iter().all(|statement| matches!(statement.test, Test::AtLeast(_)))
    }

    /// Whether one of the statements holds for the values of the parameters.
    pub(super) fn holds(&self, value: impl Fn(&str) -> Option<f64>) -> bool {
        // A parameter that is not there can forbid nothing.
        self.0.iter().any(|Statement { parameter, test }| value(parameter).is_none_or(|value| test.holds(value)))
    }

    /// The condition without what the other conditions decide: an item that they exclude, or a choice that they leave no other item.
    fn beside<'a>(&self, others: &[Self], find: impl Fn(&str) -> Option<&'a Variable>) -> Option<Self> {
        if self.choice().is_some() {
            return Some(self.clone());
        }
        // The values that the others leave to the parameter of a statement, if it is a choice.
        let items = |parameter: &str| {
            let Kind::Enumeration(of) = find(parameter)?.kind else { return None };
            let decide = || others.iter().filter(|it| it.choice() == Some(parameter));
            let values = of.items.iter().map(|(id, ..)| f64::from(*id));
            Some(values.filter(|value| decide().all(|it| it.0[0].test.holds(*value))).collect::<Vec<_>>())
        };
        let mut possible = self.0.clone();
        for statement in &self.0 {
            let Some(left) = items(&statement.parameter) else { continue };
            if left.iter().all(|value| statement.test.holds(*value)) {
                return None;
            }
            if !left.iter().any(|value| statement.test.holds(*value)) {
                possible.retain(|it| it != statement);
            }
        }
        Some(Self(possible))
    }

    /// The statements as a text: `hoseA.length or throttleA.C above 0`, `stiffness above 0 if drive = Spring`.
    pub(super) fn text<'a>(&self, find: impl Fn(&str) -> Option<&'a Variable> + Copy) -> String {
        if let [Statement { parameter, test: Test::IsNot(items) }, others @ ..] = &self.0[..]
            && !others.is_empty()
        {
            let case = Test::Is(items.clone()).text(find(parameter));
            return format!("{} if {parameter} {case}", Self(others.to_vec()).text(find));
        }
        let mut parts: Vec<(Vec<&str>, String)> = Vec::new();
        for Statement { parameter, test } in &self.0 {
            let end = test.text(find(parameter));
            match parts.last_mut() {
                Some((names, same)) if *same == end => names.push(parameter),
                _ => parts.push((vec![parameter], end)),
            }
        }
        let parts = parts.iter().map(|(names, end)| format!("{} {end}", listed(names, "or")));
        parts.collect::<Vec<_>>().join(" or ")
    }

    /// The one parameter whose item decides, if there is one.
    pub(super) fn choice(&self) -> Option<&str> {
        let [Statement { parameter, test: Test::Is(_) | Test::IsNot(_) }] = &self.0[..] else { return None };
        Some(parameter)
    }
}

impl Test {
    fn holds(&self, value: f64) -> bool {
        let is_among = |items: &[i32]| items.iter().any(|item| f64::from(*item) == value);
        match self {
            Self::On => value != 0.0,
            Self::Off => value == 0.0,
            Self::Is(items) => is_among(items),
            Self::IsNot(items) => !is_among(items),
            Self::AtLeast(number) => value >= f64::from(*number),
        }
    }

    /// The end of a statement about a variable.
    fn text(&self, variable: Option<&Variable>) -> String {
        let is_flag = variable.is_some_and(|variable| variable.kind == Kind::Boolean);
        let named = |items: &[i32]| {
            let of =
                variable.and_then(|variable| if let Kind::Enumeration(of) = variable.kind { Some(of) } else { None });
            let names: Vec<&str> = of.map(|of| names(of, items)).unwrap_or_default();
            listed(&names, "or")
        };
        match self {
            Self::On if is_flag => "= true".to_owned(),
            Self::On if variable.is_some_and(|variable| variable.min == Some(0.0)) => "above 0".to_owned(),
            Self::On => "other than 0".to_owned(),
            Self::Off if is_flag => "= false".to_owned(),
            Self::Off => "= 0".to_owned(),
            Self::Is(items) => format!("= {}", named(items)),
            Self::IsNot(items) => match variable.map(|variable| variable.kind) {
                Some(Kind::Enumeration(of)) if of.items.len() <= 2 * items.len() => {
                    let others: Vec<_> = of.items.iter().map(|(id, ..)| *id).filter(|id| !items.contains(id)).collect();
                    format!("= {}", named(&others))
                }
                _ => format!("other than {}", named(items)),
            },
            Self::AtLeast(number) => format!("of at least {number}"),
        }
    }
}

/// Names of those items that an enumeration has.
fn names(of: &Enumeration, items: &[i32]) -> Vec<&'static str> {
    of.items.iter().filter(|(id, ..)| items.contains(id)).map(|(_, name, _)| *name).collect()
}

/// Names as a text: `a, b or c`.
pub(super) fn listed(names: &[&str], joint: &str) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [others @ .., last] => format!("{} {joint} {last}", others.join(", ")),
    }
}

/// The elements of an array of which only as many count as a parameter says.
pub fn counted_by<const N: usize>(count: &str, elements: [Variable; N]) -> [Variable; N] {
    let mut number = 0;
    elements.map(|element| {
        number += 1;
        element.counts_where(Condition::at_least(count, number))
    })
}

/// The most names that a warning lists.
const MOST: usize = 4;

/// The warning about variables without effect, for a reason that [`Table::lack`] gives; outputs are 0 then.
pub fn idle_warning(names: &[&str], lack: &str, are_outputs: bool) -> String {
    let mut shown = names.iter().take(MOST).copied().collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        shown += &format!(" and {} more", names.len() - MOST);
    }
    let said = match (names, are_outputs) {
        ([_], false) => "has no effect: it counts",
        (_, false) => "have no effect: they count",
        ([_], true) => "is 0 throughout: it counts",
        (_, true) => "are 0 throughout: they count",
    };
    format!("{shown} {said} only with {lack}")
}

impl Table {
    /// The condition that a variable lacks to have an effect on runs with the values of all parameters, in the order of the
    /// table, as a text for people; of an output, to be anything but 0. Nothing if it counts.
    pub fn lack(&self, variable: &Variable, parameters: &[f64]) -> Option<String> {
        let value = |name: &str| {
            let super::Place::Parameter(place) = self.find(name)?.place else { return None };
            Some(self.in_use(place, parameters))
        };
        let present = |name: &str| {
            let Kind::Enumeration(of) = self.find(name)?.variable.kind else { return None };
            let name = *names(of, &[value(name)? as i32]).first()?;
            Some(format!(", and here it is {name}"))
        };
        if let Some((choice, item)) = variable
            .counts_for
            .and_then(|case| Some((case, self.case(case)?)))
            .filter(|(case, (choice, _))| value(&choice.name) != Some(f64::from(case.item)))
            .map(|(_, found)| found)
        {
            return Some(format!("{} = {item}{}", choice.name, present(&choice.name).unwrap_or_default()));
        }
        let lacking = variable.counts_where.iter().find(|condition| !condition.holds(value))?;
        let here = lacking.choice().and_then(present).unwrap_or_default();
        Some(lacking.text(|name| Some(self.find(name)?.variable)) + &here)
    }

    /// The conditions of a variable as a sentence of its description, nothing without conditions. Bounds of the
    /// elements of an array are left out.
    pub(super) fn sentence<'a>(
        variable: &Variable,
        find: impl Fn(&str) -> Option<&'a Variable> + Copy,
    ) -> Option<String> {
        let stated = variable.counts_where.iter().filter(|condition| !condition.is_of_elements());
        let stated = stated.filter_map(|condition| condition.beside(&variable.counts_where, find));
        let conditions: Vec<String> = stated.map(|condition| condition.text(find)).collect();
        let begin = if variable.is_computed() { "0 unless" } else { "Only with" };
        (!conditions.is_empty()).then(|| format!("{begin} {}", conditions.join(" and ")))
    }

    /// Warnings of parameters and inputs that differ from their defaults without effect, for the values of all.
    pub fn idle(&self, parameters: &[f64], inputs: &[f64]) -> Vec<String> {
        let given = self.parameters().zip(parameters).chain(self.inputs().zip(inputs));
        let mut lost: Vec<(String, Vec<&str>)> = Vec::new();
        for (variable, _) in given.filter(|(variable, value)| variable.start != Some(**value)) {
            let Some(lack) = self.lack(variable, parameters) else { continue };
            match lost.iter_mut().find(|(known, _)| *known == lack) {
                Some((_, names)) => names.push(&variable.name),
                None => lost.push((lack, vec![&variable.name])),
            }
        }
        lost.iter().map(|(lack, names)| idle_warning(names, lack, false)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enumeration;
    use crate::variables::units;

    enumeration! {
        /// Drive of a mass.
        Drive "Drive": "What drives a mass" {
            1 Force: "A force";
            2 Motion: "A motion";
            3 Spring: "A spring";
        }
    }

    fn table() -> Table {
        Table::new(vec![
            Variable::choice(1, "drive", Drive::Force),
            Variable::option(2, "open", false),
            Variable::parameter(3, "stiffness", units::NEWTON_PER_METRE, 0.0).range(0.0, 1e9),
            Variable::parameter(4, "offset", units::METRE, 0.0),
            Variable::count(5, "N", 2),
            Variable::parameter(6, "a", units::METRE, 0.0)
                .counts_where(Condition::is("drive", &[Drive::Motion, Drive::Spring])),
            Variable::parameter(7, "b", units::METRE, 0.0).counts_where(
                Condition::is_not("drive", &[Drive::Spring]).or(Condition::any_on(&["stiffness", "offset"])),
            ),
            Variable::parameter(8, "c", units::METRE, 0.0).counts_where(Condition::off("open")).counts_with("offset"),
            Variable::parameter(9, "d", units::METRE, 0.0).counts_where(Condition::at_least("N", 3)),
            Variable::output(20, "flow", units::METRE).counts_with("open"),
        ])
    }

    /// Condition that a variable lacks with the first parameters changed.
    fn lack(name: &str, first: &[f64]) -> Option<String> {
        let table = table();
        assert_eq!(table.problem(), None);
        let mut values: Vec<f64> = table.parameters().map(|variable| variable.start.unwrap_or_default()).collect();
        values[..first.len()].copy_from_slice(first);
        table.lack(table.find(name).expect("the variable").variable, &values)
    }

    #[test]
    fn conditions_hold_where_one_of_their_statements_does() {
        assert_eq!(lack("a", &[]).as_deref(), Some("drive = Motion or Spring, and here it is Force"));
        assert_eq!(lack("a", &[2.0]), None);
        assert_eq!(lack("b", &[1.0]), None);
        assert_eq!(lack("b", &[3.0]).as_deref(), Some("stiffness above 0 or offset other than 0 if drive = Spring"));
        assert_eq!(lack("b", &[3.0, 0.0, 0.0, -1.0]), None);
        assert_eq!(lack("c", &[1.0, 1.0]).as_deref(), Some("open = false"));
        assert_eq!(lack("c", &[1.0, 0.0]).as_deref(), Some("offset other than 0"));
        assert_eq!(lack("d", &[]).as_deref(), Some("N of at least 3"));
        assert_eq!(lack("d", &[1.0, 0.0, 0.0, 0.0, 3.0]), None);
        assert_eq!(lack("flow", &[]).as_deref(), Some("open = true"));
    }

    /// A condition of one item of a choice is not repeated where the choice has this item alone.
    #[test]
    fn description_states_each_condition_once() {
        let table = table();
        let find = |name: &str| Some(table.find(name)?.variable);
        let sentence = |conditions: [Condition; 2]| {
            let [first, second] = conditions;
            let variable = Variable::parameter(9, "e", units::METRE, 0.0).counts_where(first).counts_where(second);
            Table::sentence(&variable, find).expect("a sentence")
        };
        let spring = || Condition::is_not("drive", &[Drive::Spring]).or(Condition::on("stiffness"));
        let not = |items: &[Drive]| Condition::is_not("drive", items);
        assert_eq!(sentence([not(&[Drive::Spring]), spring()]), "Only with drive other than Spring");
        assert_eq!(
            sentence([not(&[Drive::Force, Drive::Motion]), spring()]),
            "Only with drive = Spring and stiffness above 0"
        );
        assert_eq!(
            sentence([not(&[Drive::Force]), spring()]),
            "Only with drive other than Force and stiffness above 0 if drive = Spring"
        );
    }

    /// A number that chooses an item counts as the item.
    #[test]
    fn choice_by_number_counts() {
        let table = table();
        let mut values: Vec<f64> = table.parameters().map(|variable| variable.start.unwrap_or_default()).collect();
        *values.last_mut().expect("the number of the drive") = 2.0;
        assert_eq!(table.lack(table.find("a").expect("the variable").variable, &values), None);
    }

    #[test]
    fn changed_values_without_effect_are_listed_by_what_they_lack() {
        let table = table();
        let mut values: Vec<f64> = table.parameters().map(|variable| variable.start.unwrap_or_default()).collect();
        assert_eq!(table.idle(&values, &[]), Vec::<String>::new());
        values[5..9].fill(0.5);
        let told = table.idle(&values, &[]);
        assert_eq!(told.len(), 3, "{told:?}");
        assert_eq!(told[1], "c has no effect: it counts only with offset other than 0");
        assert_eq!(
            idle_warning(&["a", "b", "c", "d", "e"], "x", true),
            "a, b, c, d and 1 more are 0 throughout: they count only with x"
        );
    }

    #[test]
    fn condition_about_a_parameter_that_is_missing_is_refused() {
        let table = Table::new(vec![Variable::parameter(1, "k", units::METRE, 0.0).counts_with("lost")]);
        assert!(table.problem().expect("a problem").reason.contains("lost"));
    }
}
