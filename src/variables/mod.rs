//! The variable table: every variable of a model is stated here once, and the XML, the get and set functions,
//! the documentation and the tests are made from it.

mod table;

use std::fmt;

pub use table::{Entry, Place, Table};

/// Exponents of the SI base units kg, m, s, A, K, mol, cd and rad.
pub type BaseUnit = [i8; 8];

/// A display unit: `shown = factor * value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Name, for example `bar`.
    pub name: &'static str,
    /// Factor from the SI unit.
    pub factor: f64,
    /// Offset after scaling.
    pub offset: f64,
}

/// A coherent SI unit, so that its factor to the base units is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name, for example `Pa`.
    pub name: &'static str,
    /// Exponents of the SI base units.
    pub base: BaseUnit,
    /// Units an engineer may prefer to look at.
    pub display: &'static [DisplayUnit],
}

/// The units of this library.
pub mod units {
    use super::{DisplayUnit, Unit};

    macro_rules! units {
        ($($(#[$doc:meta])* $id:ident = $name:literal $base:expr $(, $shown:literal $factor:expr, $offset:expr)*;)*) => {
            $($(#[$doc])* pub const $id: Unit = Unit {
                name: $name,
                base: $base,
                display: &[$(DisplayUnit { name: $shown, factor: $factor, offset: $offset }),*],
            };)*
            /// Every unit.
            pub const ALL: &[Unit] = &[$($id),*];
        };
    }

    // Exponents in the order kg, m, s, A, K, mol, cd, rad.
    units! {
        /// A number without dimension.
        ONE = "1" [0; 8];
        /// Length; shown in millimetres.
        METRE = "m" [0, 1, 0, 0, 0, 0, 0, 0], "mm" 1e3, 0.0;
        /// Microscopic length; the same unit as [`METRE`].
        SQUARE_METRE = "m2" [0, 2, 0, 0, 0, 0, 0, 0];
        /// Volume; shown in cubic centimetres.
        CUBIC_METRE = "m3" [0, 3, 0, 0, 0, 0, 0, 0], "cm3" 1e6, 0.0;
        /// Time; shown in milliseconds.
        SECOND = "s" [0, 0, 1, 0, 0, 0, 0, 0], "ms" 1e3, 0.0;
        /// Rate.
        PER_SECOND = "1/s" [0, 0, -1, 0, 0, 0, 0, 0];
        /// Rate of a rate.
        PER_SECOND_SQUARED = "1/s2" [0, 0, -2, 0, 0, 0, 0, 0];
        /// Frequency.
        HERTZ = "Hz" [0, 0, -1, 0, 0, 0, 0, 0];
        /// Velocity; shown in millimetres per second.
        METRE_PER_SECOND = "m/s" [0, 1, -1, 0, 0, 0, 0, 0], "mm/s" 1e3, 0.0;
        /// Inverse velocity.
        SECOND_PER_METRE = "s/m" [0, -1, 1, 0, 0, 0, 0, 0];
        /// Acceleration.
        METRE_PER_SECOND_SQUARED = "m/s2" [0, 1, -2, 0, 0, 0, 0, 0];
        /// Mass; shown in grams.
        KILOGRAM = "kg" [1, 0, 0, 0, 0, 0, 0, 0], "g" 1e3, 0.0;
        /// Force.
        NEWTON = "N" [1, 1, -2, 0, 0, 0, 0, 0];
        /// Rate of a force.
        NEWTON_PER_SECOND = "N/s" [1, 1, -3, 0, 0, 0, 0, 0];
        /// Stiffness.
        NEWTON_PER_METRE = "N/m" [1, 0, -2, 0, 0, 0, 0, 0];
        /// Cubic stiffness.
        NEWTON_PER_CUBIC_METRE = "N/m3" [1, -2, -2, 0, 0, 0, 0, 0];
        /// Viscous damping.
        NEWTON_SECOND_PER_METRE = "N.s/m" [1, 0, -1, 0, 0, 0, 0, 0];
        /// Inverse length.
        PER_METRE = "1/m" [0, -1, 0, 0, 0, 0, 0, 0];
        /// Pressure; shown in bar.
        PASCAL = "Pa" [1, -1, -2, 0, 0, 0, 0, 0], "bar" 1e-5, 0.0;
        /// Rate of a pressure.
        PASCAL_PER_SECOND = "Pa/s" [1, -1, -3, 0, 0, 0, 0, 0], "bar/s" 1e-5, 0.0;
        /// Inverse pressure.
        PER_PASCAL = "1/Pa" [-1, 1, 2, 0, 0, 0, 0, 0], "1/bar" 1e5, 0.0;
        /// Absolute temperature; shown in degrees Celsius.
        KELVIN = "K" [0, 0, 0, 0, 1, 0, 0, 0], "degC" 1.0, -273.15;
        /// Rate of a temperature.
        KELVIN_PER_SECOND = "K/s" [0, 0, -1, 0, 1, 0, 0, 0];
        /// Mass flow; shown as the volume flow at the reference conditions of ISO 8778 (density 1.185 kg/m3).
        KILOGRAM_PER_SECOND = "kg/s" [1, 0, -1, 0, 0, 0, 0, 0], "g/s" 1e3, 0.0, "l/min(ANR)" 60_000.0 / 1.185, 0.0;
        /// Sonic conductance of ISO 6358; shown in dm3/(s.bar).
        CUBIC_METRE_PER_SECOND_PASCAL = "m3/(s.Pa)" [-1, 4, 1, 0, 0, 0, 0, 0], "dm3/(s.bar)" 1e8, 0.0;
        /// Laminar leakage coefficient: mass flow per difference of squared pressures.
        KILOGRAM_PER_SECOND_SQUARE_PASCAL = "kg/(s.Pa2)" [-1, 2, 3, 0, 0, 0, 0, 0];
        /// Heat transfer coefficient.
        WATT_PER_SQUARE_METRE_KELVIN = "W/(m2.K)" [1, 0, -3, 0, -1, 0, 0, 0];
        /// Voltage.
        VOLT = "V" [1, 2, -3, -1, 0, 0, 0, 0];
        /// Voltage per velocity.
        VOLT_SECOND_PER_METRE = "V.s/m" [1, 1, -2, -1, 0, 0, 0, 0];
        /// Voltage per length.
        VOLT_PER_METRE = "V/m" [1, 1, -3, -1, 0, 0, 0, 0];
        /// Angle; shown in degrees.
        RADIAN = "rad" [0, 0, 0, 0, 0, 0, 0, 1], "deg" 57.295_779_513_082_32, 0.0;
        /// Damping of a joint.
        NEWTON_METRE_SECOND = "N.m.s/rad" [1, 2, -1, 0, 0, 0, 0, -1];
        /// Angular velocity; shown in degrees per second.
        RADIAN_PER_SECOND = "rad/s" [0, 0, -1, 0, 0, 0, 0, 1], "deg/s" 57.295_779_513_082_32, 0.0;
        /// Angular acceleration.
        RADIAN_PER_SECOND_SQUARED = "rad/s2" [0, 0, -2, 0, 0, 0, 0, 1];
        /// Energy.
        JOULE = "J" [1, 2, -2, 0, 0, 0, 0, 0];
    }
}

/// An enumeration type; the ids are part of the interface and never reused.
#[derive(Debug, PartialEq)]
pub struct Enumeration {
    /// Type name, different from every variable name.
    pub name: &'static str,
    /// What is chosen.
    pub description: &'static str,
    /// Id, name and description of each item.
    pub items: &'static [(i32, &'static str, &'static str)],
}

impl Enumeration {
    /// The id of an item.
    pub fn id(&self, name: &str) -> Option<i32> {
        self.items.iter().find(|(_, item, _)| *item == name).map(|(id, ..)| *id)
    }
}

/// The FMI base type of a variable, with what belongs to it.
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

/// What a variable is for, and thereby when it may be set.
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
    /// What an engineer needs to know about it.
    pub description: String,
    /// Start value of inputs and parameters.
    pub start: Option<f64>,
    /// Smallest legal value.
    pub min: Option<f64>,
    /// Largest legal value.
    pub max: Option<f64>,
    /// Order of magnitude.
    pub nominal: Option<f64>,
    /// Display unit to suggest, one of the unit's.
    pub display: Option<&'static str>,
    /// Value reference of the state this is the time derivative of.
    pub derivative_of: Option<u32>,
    /// Value references of the inputs and states an output depends on directly.
    pub depends_on: Vec<u32>,
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
            nominal: None,
            display: None,
            derivative_of: None,
            depends_on: Vec::new(),
        }
    }

    /// The independent variable, the first of every table.
    pub fn time() -> Self {
        Self::new(0, "time", Kind::Real(units::SECOND), Role::Time).text("Time")
    }

    /// A real input.
    pub fn input(reference: u32, name: &str, unit: Unit, start: f64) -> Self {
        Self { start: Some(start), ..Self::new(reference, name, Kind::Real(unit), Role::Input) }
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
    pub fn choice(reference: u32, name: &str, of: &'static Enumeration, start: i32) -> Self {
        Self { start: Some(start.into()), ..Self::new(reference, name, Kind::Enumeration(of), Role::Fixed) }
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
            reference: self.reference + index as u32,
            start: Some(start[index]),
            description: format!("{} (element {})", self.description, index + 1),
            ..self.clone()
        })
    }

    /// Says what the variable means.
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

    /// Names the inputs and states that enter the variable's equation directly.
    pub fn depends_on(self, references: &[u32]) -> Self {
        Self { depends_on: references.to_vec(), ..self }
    }

    /// Puts the variable into a group: `group.name`, with its value reference counted from `base`.
    pub fn within(self, group: &str, base: u32) -> Self {
        Self { name: format!("{group}.{}", self.name), reference: base + self.reference, ..self }
    }

    /// Whether the variable may be set at all.
    pub fn is_parameter(&self) -> bool {
        matches!(self.role, Role::Fixed | Role::Tunable)
    }

    /// Whether the variable is computed by the model.
    pub fn is_computed(&self) -> bool {
        matches!(self.role, Role::Output | Role::Local)
    }

    /// Checks that a value may be given to this input or parameter.
    ///
    /// # Errors
    /// [`ParameterError`] for a value that is not finite, out of range or no item of the enumeration.
    pub fn check(&self, value: f64) -> Result<(), ParameterError> {
        let refuse = |reason: String| Err(ParameterError { variable: self.name.clone(), value, reason });
        if !value.is_finite() {
            return refuse("it must be a finite number".to_owned());
        }
        if let Some(min) = self.min.filter(|min| value < *min) {
            return refuse(format!("it must be at least {min}"));
        }
        if let Some(max) = self.max.filter(|max| value > *max) {
            return refuse(format!("it must be at most {max}"));
        }
        if let Kind::Enumeration(of) = self.kind
            && !of.items.iter().any(|(id, ..)| f64::from(*id) == value)
        {
            return refuse(format!("it must be one of the items of {}", of.name));
        }
        Ok(())
    }
}

/// A parameter or input that cannot be accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterError {
    /// Name of the variable.
    pub variable: String,
    /// The refused value.
    pub value: f64,
    /// What it must be.
    pub reason: String,
}

impl ParameterError {
    /// An error for a variable of a group; [`ParameterError::within`] completes its name.
    pub fn new(variable: &str, value: f64, reason: &str) -> Self {
        Self { variable: variable.to_owned(), value, reason: reason.to_owned() }
    }

    /// Puts the name of the variable into its group.
    pub fn within(self, group: &str) -> Self {
        Self { variable: format!("{group}.{}", self.variable), ..self }
    }
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {} is refused: {}", self.variable, self.value, self.reason)
    }
}

impl std::error::Error for ParameterError {}

/// Something that takes one or more consecutive numbers of a table: `f64`, or `[f64; N]` for an array.
pub trait Field: Sized {
    /// How many numbers it takes.
    const LEN: usize;
    /// Reads them from the front.
    fn read(values: &[f64]) -> Self;
}

impl Field for f64 {
    const LEN: usize = 1;
    fn read(values: &[f64]) -> Self {
        values[0]
    }
}

impl<const N: usize> Field for [f64; N] {
    const LEN: usize = N;
    fn read(values: &[f64]) -> Self {
        std::array::from_fn(|index| values[index])
    }
}

/// One variable or an array of them, as a declaration in [`parameters!`](crate::parameters) yields it.
pub trait Declaration {
    /// The variables, in order.
    fn into_variables(self) -> Vec<Variable>;
}

impl Declaration for Variable {
    fn into_variables(self) -> Vec<Variable> {
        vec![self]
    }
}

impl<const N: usize> Declaration for [Variable; N] {
    fn into_variables(self) -> Vec<Variable> {
        self.into()
    }
}

/// A struct of parameters or inputs, made by [`parameters!`](crate::parameters).
pub trait ParameterSet: Sized {
    /// How many variables there are.
    const LEN: usize;
    /// The variables, in the order of the fields.
    fn table() -> Vec<Variable>;
    /// Reads the fields from values in the order of the table.
    fn read(values: &[f64]) -> Self;
}

/// Declares a [`ParameterSet`]: each field together with the variable (or array of variables) it is read from.
#[macro_export]
macro_rules! parameters {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty = $declaration:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs, reason = "each field is described by the text of its variable")]
        pub struct $name { $(pub $field: $type),* }

        impl $crate::variables::ParameterSet for $name {
            const LEN: usize = 0 $(+ <$type as $crate::variables::Field>::LEN)*;

            fn table() -> Vec<$crate::variables::Variable> {
                #[allow(unused_mut, reason = "a struct may have no fields")]
                let mut table = Vec::new();
                $(table.extend($crate::variables::Declaration::into_variables($declaration));)*
                table
            }

            #[allow(unused, reason = "a struct may have no fields")]
            fn read(values: &[f64]) -> Self {
                let mut next = 0;
                $(
                    let $field = <$type as $crate::variables::Field>::read(&values[next..]);
                    next += <$type as $crate::variables::Field>::LEN;
                )*
                Self { $($field),* }
            }
        }
    };
}

/// Declares a struct of computed variables, generic over the scalar, together with their table.
///
/// The struct gets `table()`, the variables in the order of the fields, and `values()`, an iterator in that order.
#[macro_export]
macro_rules! outputs {
    ($(#[$doc:meta])* $name:ident { $($field:ident = $declaration:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "each field is described by the text of its variable")]
        pub struct $name<S> { $(pub $field: S),* }

        impl<S> $name<S> {
            /// The variables, in the order of the fields.
            pub fn table() -> Vec<$crate::variables::Variable> {
                vec![$($declaration),*]
            }

            /// Writes the values in the order of the table, and returns the rest of the slots.
            pub fn write(self, slots: &mut [S]) -> &mut [S] where S: Copy {
                let values = [$(self.$field),*];
                let (own, rest) = slots.split_at_mut(values.len());
                own.copy_from_slice(&values);
                rest
            }
        }
    };
}
