//! The variable table: every variable of a model is stated here once, and the XML, the get and set functions,
//! the documentation and the tests are made from it.

mod array;
mod condition;
mod declare;
mod enumeration;
mod error;
mod notice;
mod plausible;
mod setting;
mod states;
mod table;
pub(crate) mod table_cache;
mod unit;
mod values;

use std::fmt;

pub use array::array_name;
pub use condition::{Condition, counted_by, idle_warning};
pub use declare::{Declaration, Field, Fixed, ParameterSet, Tunable};
#[doc(hidden)]
pub use declare::{Group, declared, refused};
pub use enumeration::{Choice, Enumeration};
pub use error::ParameterError;
pub use notice::{Notice, Notices};
pub use plausible::meant;
pub use setting::find;
pub use setting::{SettingError, Value};
pub use states::StateSet;
pub(crate) use table::SOLVER;
pub use table::{Entry, Place, Table};
#[doc(hidden)]
pub use table_cache::{forget, forget_tables};
pub use unit::{BaseUnit, DisplayUnit, Unit, units};
pub use values::Values;

/// The FMI base type of a variable, with its attributes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A real number in a unit.
    Real(Unit),
    /// A 32-bit integer.
    Integer,
    /// True (1) or false (0).
    Boolean,
    /// One of the items of an enumeration.
    Enumeration(&'static Enumeration),
}

/// Role of a variable, and thereby when it may be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The independent variable, time.
    Time,
    /// Set by the environment while running.
    Input,
    /// Constant after initialization.
    Fixed,
    /// A parameter that may be changed between steps.
    Tunable,
    /// Computed, and meant to be connected or watched.
    Output,
    /// Computed, for analysis.
    Local,
}

/// An enumeration parameter for which an Integer parameter can choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// Its value reference.
    pub reference: u32,
    /// Items to choose from.
    pub of: &'static Enumeration,
}

/// An item of an enumeration parameter, for which alone another parameter counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// The value reference of the enumeration parameter.
    pub reference: u32,
    /// The id of the item.
    pub item: i32,
}

/// How the default of a parameter follows the value of another one, where it does not fit that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Following {
    /// It becomes this value.
    Whole,
    /// In the proportion of both defaults.
    InProportion,
}

/// Meaning of a parameter for a model that would know it by its name otherwise: one that knows the friction of its contact
/// itself, for example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// The force at which sliding starts.
    StaticFriction,
    /// The force of fast sliding without its viscous part.
    CoulombFriction,
    /// By how much the static friction exceeds the Coulomb friction.
    StaticExcess,
    /// Friction in proportion to the velocity.
    ViscousFriction,
    /// The exponent of the Stribeck curve.
    StribeckExponent,
    /// The choice of a friction law.
    FrictionLaw,
    /// When samples are taken.
    Sampling,
    /// Computation of a run, not its result.
    Solving,
}

/// Offset of the value reference of the Integer that can choose for an enumeration parameter; no other variables have such
/// references.
const NUMBERS: u32 = 20_000;

/// One variable of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Structured name, for example `chamberA.pressure`.
    pub name: String,
    /// Value reference, unique over all types and never reused.
    pub reference: u32,
    /// Base type and unit.
    pub kind: Kind,
    /// Causality and variability.
    pub role: Role,
    /// Description for an engineer.
    pub description: String,
    /// Start value of inputs and parameters.
    pub start: Option<f64>,
    /// Smallest legal value.
    pub min: Option<f64>,
    /// Largest legal value.
    pub max: Option<f64>,
    /// Range of the values that rigs have: beyond it a unit was forgotten, as a rule.
    pub plausible: Option<[f64; 2]>,
    /// Order of magnitude.
    pub nominal: Option<f64>,
    /// Display unit to suggest, one of the unit's.
    pub display: Option<&'static str>,
    /// Value reference of the state this is the time derivative of.
    pub derivative_of: Option<u32>,
    /// Value references of what a computed variable depends on directly, if it says so: see
    /// [`Table::dependencies`].
    pub depends_on: Option<Vec<u32>>,
    /// Value references of the inputs that the start value of a state follows from.
    pub starts_from: Vec<u32>,
    /// The enumeration parameter that this Integer parameter chooses for by number, if it is not 0.
    pub chooses: Option<Chosen>,
    /// The choice for which alone this parameter counts: the friction law, for parameters of a law.
    pub counts_for: Option<Case>,
    /// Conditions that must all hold for it to have an effect; of a computed variable, to be anything but 0.
    pub counts_where: Vec<Condition>,
    /// Name of the parameter that its default follows, and how.
    pub follows: Option<(String, Following)>,
    /// Meaning of a parameter, independent of its name.
    pub meaning: Option<Meaning>,
    /// Whether equations hold a parameter as a number that they can be differentiated by.
    pub varies: bool,
    /// Whether 0 stands for the absence of a part, which no small value comes near.
    pub absent_at_zero: bool,
    /// Whether a parameter does something else below 0 than above, and has no derivative there.
    pub turns_at_zero: bool,
}

impl Variable {
    fn new(reference: u32, name: &str, kind: Kind, role: Role) -> Self {
        Self {
            name: name.to_owned(),
            reference,
            kind,
            role,
            description: String::new(),
            start: None,
            min: None,
            max: None,
            plausible: None,
            nominal: None,
            display: None,
            derivative_of: None,
            depends_on: None,
            starts_from: Vec::new(),
            chooses: None,
            counts_for: None,
            counts_where: Vec::new(),
            follows: None,
            meaning: None,
            varies: true,
            absent_at_zero: false,
            turns_at_zero: false,
        }
    }

    /// The same with a meaning.
    pub fn meaning(self, meaning: Meaning) -> Self {
        Self { meaning: Some(meaning), ..self }
    }

    /// The same, for a parameter whose default follows the value of another one of the group, where it does not fit that.
    pub fn follows(self, leader: &str, how: Following) -> Self {
        Self { follows: Some((leader.to_owned(), how)), ..self }
    }

    /// The same, for a parameter that counts only while an enumeration parameter has chosen an item.
    pub fn counts_for(self, reference: u32, item: i32) -> Self {
        Self { counts_for: Some(Case { reference, item }), ..self }
    }

    /// The same, for a variable that counts only while a condition holds, too.
    pub fn counts_where(mut self, condition: Condition) -> Self {
        self.counts_where.push(condition);
        self
    }

    /// The same, for a variable that counts only while a parameter is not 0, or true.
    pub fn counts_with(self, parameter: &str) -> Self {
        self.counts_where(Condition::on(parameter))
    }

    /// The same without those conditions that are about parameters which a model does not have.
    pub(crate) fn without_conditions_unless(mut self, has: impl Fn(&str) -> bool) -> Self {
        self.counts_where.retain(|condition| condition.parameters().all(&has));
        self
    }

    /// The independent variable, the first of every table.
    pub fn time() -> Self {
        Self::new(0, "time", Kind::Real(units::SECOND), Role::Time).text("Time")
    }

    /// A real input.
    pub fn input(reference: u32, name: &str, unit: Unit, start: f64) -> Self {
        Self { start: Some(start), ..Self::new(reference, name, Kind::Real(unit), Role::Input) }
    }

    /// A true-or-false input.
    pub fn switch(reference: u32, name: &str, start: bool) -> Self {
        Self { start: Some(start.into()), ..Self::new(reference, name, Kind::Boolean, Role::Input) }
    }

    /// A fixed real parameter.
    pub fn parameter(reference: u32, name: &str, unit: Unit, start: f64) -> Self {
        Self { start: Some(start), ..Self::new(reference, name, Kind::Real(unit), Role::Fixed) }
    }

    /// A fixed integer parameter.
    pub fn count(reference: u32, name: &str, start: i32) -> Self {
        Self { start: Some(start.into()), ..Self::new(reference, name, Kind::Integer, Role::Fixed) }
    }

    /// A fixed parameter that turns something on or off.
    pub fn option(reference: u32, name: &str, start: bool) -> Self {
        Self { start: Some(start.into()), ..Self::new(reference, name, Kind::Boolean, Role::Fixed) }
    }

    /// A fixed choice among the items of an enumeration.
    pub fn choice<C: Choice>(reference: u32, name: &str, start: C) -> Self {
        let kind = Kind::Enumeration(C::ENUMERATION);
        Self { start: Some(start.id().into()), ..Self::new(reference, name, kind, Role::Fixed) }
    }

    /// The Integer parameter that can choose for an enumeration parameter, for hosts that set no enumerations.
    fn number(&self) -> Option<Self> {
        let Kind::Enumeration(of) = self.kind else { return None };
        let (name, reference) = (&self.name, self.reference);
        let largest = of.items.iter().map(|(id, ..)| *id).max()?;
        let text = format!(
            "Number of an item of {}, for tools that set no enumerations; 0: as {name} chooses. What it chooses is read from {name}",
            of.name
        );
        let number = Self::new(reference.saturating_add(NUMBERS), &format!("{name}Number"), Kind::Integer, self.role);
        let number = Self {
            start: Some(0.0),
            chooses: Some(Chosen { reference, of }),
            meaning: self.meaning,
            counts_for: self.counts_for,
            counts_where: self.counts_where.clone(),
            ..number
        };
        Some(number.range(0.0, largest.into()).text(&text))
    }

    /// A real output.
    pub fn output(reference: u32, name: &str, unit: Unit) -> Self {
        Self::new(reference, name, Kind::Real(unit), Role::Output)
    }

    /// A true-or-false output.
    pub fn flag(reference: u32, name: &str) -> Self {
        Self::new(reference, name, Kind::Boolean, Role::Output)
    }

    /// An integer that counts something, for analysis.
    pub fn counter(reference: u32, name: &str) -> Self {
        Self::new(reference, name, Kind::Integer, Role::Local)
    }

    /// Parameters `name[1]`, `name[2]`, ... with consecutive value references.
    pub fn array<const N: usize>(self, start: [f64; N]) -> [Self; N] {
        std::array::from_fn(|index| Self {
            name: format!("{}[{}]", self.name, index + 1),
            reference: self.reference.saturating_add(index as u32),
            start: Some(start[index]),
            description: format!("{} (element {})", self.description, index + 1),
            ..self.clone()
        })
    }

    /// Sets the meaning of the variable.
    pub fn text(self, description: &str) -> Self {
        Self { description: description.to_owned(), ..self }
    }

    /// States the legal range.
    pub fn range(self, min: f64, max: f64) -> Self {
        Self { min: Some(min), max: Some(max), ..self }
    }

    /// States the smallest legal value.
    pub fn at_least(self, min: f64) -> Self {
        Self { min: Some(min), ..self }
    }

    /// States the order of magnitude.
    pub fn nominal(self, nominal: f64) -> Self {
        Self { nominal: Some(nominal), ..self }
    }

    /// Says that 0 stands for the absence of a part: there is no slope by it there.
    pub fn absent_at_zero(self) -> Self {
        Self { absent_at_zero: true, ..self }
    }

    /// Says that below 0 a parameter does something else than above: there is no derivative by it at 0.
    pub fn turns_at_zero(self) -> Self {
        Self { turns_at_zero: true, ..self }
    }

    /// Suggests a display unit.
    pub fn shown_in(self, display: &'static str) -> Self {
        Self { display: Some(display), ..self }
    }

    /// Lets a parameter be changed between steps.
    pub fn tunable(self) -> Self {
        Self { role: Role::Tunable, ..self }
    }

    /// Makes an output a local variable.
    pub fn local(self) -> Self {
        Self { role: Role::Local, ..self }
    }

    /// Marks the variable as the time derivative of another.
    pub fn derivative_of(self, state: u32) -> Self {
        Self { derivative_of: Some(state), ..self }
    }

    /// Names the inputs, the states and, by reference 0, the time that enter the variable's equation directly: in the
    /// present mode if it is a number, also by way of events if it is true or false. A computed variable that says nothing depends on
    /// all of them, as far as an importer is told: that is never wrong, and makes its Jacobians dense.
    pub fn depends_on(self, references: &[u32]) -> Self {
        Self { depends_on: Some(references.to_vec()), ..self }
    }

    /// Names the inputs that the start value of a state follows from; from parameters they all may.
    pub fn starts_from(self, references: &[u32]) -> Self {
        Self { starts_from: references.to_vec(), ..self }
    }

    /// The group of a structured name, all before its last dot, and the name within it; the group may be empty.
    ///
    /// ```
    /// use pneumatic_servo::variables::{Variable, units};
    ///
    /// let bore = Variable::parameter(1, "bore", units::METRE, 0.02);
    /// assert_eq!(bore.group_and_name(), ("", "bore"));
    /// assert_eq!(bore.within("drive.cylinder", 10).group_and_name(), ("drive.cylinder", "bore"));
    /// ```
    pub fn group_and_name(&self) -> (&str, &str) {
        self.name.rsplit_once('.').unwrap_or(("", &self.name))
    }

    /// Puts the variable into a group: `group.name`, with its value reference and the reference of the choice for which it counts,
    /// counted from `base`; its conditions and what it follows are parameters of the group.
    pub fn within(self, group: &str, base: u32) -> Self {
        let counts_for =
            self.counts_for.map(|case| Case { reference: base.saturating_add(case.reference), item: case.item });
        let (name, reference) = (format!("{group}.{}", self.name), base.saturating_add(self.reference));
        let counts_where = self.counts_where.into_iter().map(|condition| condition.within(group)).collect();
        let follows = self.follows.map(|(leader, how)| (format!("{group}.{leader}"), how));
        Self { name, reference, counts_for, counts_where, follows, ..self }
    }

    /// Whether the variable may be set at all.
    pub fn is_parameter(&self) -> bool {
        matches!(self.role, Role::Fixed | Role::Tunable)
    }

    /// Whether the variable is computed by the model.
    pub fn is_computed(&self) -> bool {
        matches!(self.role, Role::Output | Role::Local)
    }

    /// Whether it counts under conditions only.
    pub fn is_conditional(&self) -> bool {
        self.counts_for.is_some() || !self.counts_where.is_empty()
    }

    /// Whether this is the enumeration parameter of a case, and has its item.
    fn has(&self, Case { reference, item }: Case) -> bool {
        self.reference == reference && matches!(self.kind, Kind::Enumeration(of) if of.has(item.into()))
    }

    /// Checks that a value may be given to this input or parameter.
    ///
    /// # Errors
    /// [`ParameterError`] for a value that is not finite, out of range or no item of the enumeration.
    pub fn check(&self, value: f64) -> Result<(), ParameterError> {
        let refuse = |reason: fmt::Arguments| Err(self.refusal(value, reason));
        if !value.is_finite() {
            return refuse(format_args!("it must be a finite number"));
        }
        if let Some(min) = self.min.filter(|min| value < *min) {
            return refuse(format_args!("it must be at least {min}{}", self.meant(value).unwrap_or_default()));
        }
        if let Some(max) = self.max.filter(|max| value > *max) {
            return refuse(format_args!("it must be at most {max}{}", self.meant(value).unwrap_or_default()));
        }
        if let Some(Chosen { of, .. }) = self.chooses
            && value != 0.0
            && !of.has(value)
        {
            return refuse(format_args!("it must be 0 or the number of an item of {}", of.name));
        }
        match self.kind {
            Kind::Enumeration(of) if !of.has(value) => {
                refuse(format_args!("it must be one of the items of {}", of.name))
            }
            Kind::Integer if value.trunc() != value => refuse(format_args!("it must be a whole number")),
            Kind::Integer if f64::from(value as i32) != value => refuse(format_args!("integers have 32 bits")),
            Kind::Boolean if value != 0.0 && value != 1.0 => refuse(format_args!("it must be 0 (false) or 1 (true)")),
            _ => Ok(()),
        }
    }

    /// The legal value nearest to a value: within the range, and of a Boolean 0 or 1.
    pub fn nearest(&self, value: f64) -> f64 {
        if self.kind == Kind::Boolean {
            return f64::from(value > 0.5);
        }
        value.max(self.min.unwrap_or(f64::NEG_INFINITY)).min(self.max.unwrap_or(f64::INFINITY))
    }

    /// Why a value is refused: apart from the check, which is made at every step.
    #[cold]
    fn refusal(&self, value: f64, reason: fmt::Arguments) -> ParameterError {
        ParameterError::new(&self.name, value, &reason.to_string())
    }
}
