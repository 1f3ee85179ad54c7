//! Structs of inputs, parameters and computed variables, declared together with their variables.

use super::{ParameterError, Variable};
use crate::numbers::Tangent;

/// A parameter that may be changed between steps: a number that equations can be differentiated by.
pub type Tunable = Tangent;

/// A parameter that is fixed once a run has started, whose field is a number that equations can be differentiated by, as a
/// [`Tunable`].
#[derive(Clone, Copy, Debug)]
pub enum Fixed {}

/// Something that is read from one or more consecutive numbers of a table.
pub trait Field {
    /// Value in the field of a struct.
    type Value;
    /// Number of values.
    const LEN: usize;
    /// Whether it may be changed between steps.
    const IS_TUNABLE: bool = false;
    /// Whether equations can be differentiated by it, where it is real.
    const VARIES: bool = true;
    /// Reads them from the front; `None` if they have no such meaning.
    fn read(values: &[Tunable]) -> Option<Self::Value>;
}

impl Field for Fixed {
    type Value = Tangent;
    const LEN: usize = 1;
    fn read(values: &[Tunable]) -> Option<Tangent> {
        Some(values[0])
    }
}

impl<const N: usize> Field for [Fixed; N] {
    type Value = [Tangent; N];
    const LEN: usize = N;
    fn read(values: &[Tunable]) -> Option<[Tangent; N]> {
        Some(std::array::from_fn(|index| values[index]))
    }
}

/// A number that is fixed once a run has started, and that nothing is differentiated by.
impl Field for f64 {
    type Value = Self;
    const LEN: usize = 1;
    const VARIES: bool = false;
    fn read(values: &[Tunable]) -> Option<Self> {
        Some(values[0].value)
    }
}

impl Field for Tunable {
    type Value = Self;
    const LEN: usize = 1;
    const IS_TUNABLE: bool = true;
    fn read(values: &[Tunable]) -> Option<Self> {
        Some(values[0])
    }
}

impl<const N: usize> Field for [f64; N] {
    type Value = Self;
    const LEN: usize = N;
    const VARIES: bool = false;
    fn read(values: &[Tunable]) -> Option<Self> {
        Some(std::array::from_fn(|index| values[index].value))
    }
}

impl<const N: usize> Field for [Tunable; N] {
    type Value = Self;
    const LEN: usize = N;
    const IS_TUNABLE: bool = true;
    fn read(values: &[Tunable]) -> Option<Self> {
        Some(std::array::from_fn(|index| values[index]))
    }
}

impl Field for bool {
    type Value = Self;
    const LEN: usize = 1;
    fn read(values: &[Tunable]) -> Option<Self> {
        match values[0].value {
            0.0 => Some(false),
            1.0 => Some(true),
            _ => None,
        }
    }
}

/// An integer of the interface, which has 32 bits.
impl Field for i32 {
    type Value = Self;
    const LEN: usize = 1;
    fn read(values: &[Tunable]) -> Option<Self> {
        let whole = values[0].value as i32;
        (f64::from(whole) == values[0].value).then_some(whole)
    }
}

/// A count.
impl Field for usize {
    type Value = Self;
    const LEN: usize = 1;
    fn read(values: &[Tunable]) -> Option<Self> {
        i32::read(values)?.try_into().ok()
    }
}

/// A count or a seed.
impl Field for u64 {
    type Value = Self;
    const LEN: usize = 1;
    fn read(values: &[Tunable]) -> Option<Self> {
        i32::read(values)?.try_into().ok()
    }
}

/// One variable or an array of them, as a declaration in [`parameters!`](crate::parameters) yields it.
pub trait Declaration {
    /// Number of variables.
    const COUNT: usize;
    /// The variables, in order.
    fn into_variables(self) -> Vec<Variable>;
}

impl Declaration for Variable {
    const COUNT: usize = 1;
    fn into_variables(self) -> Vec<Variable> {
        vec![self]
    }
}

impl<const N: usize> Declaration for [Variable; N] {
    const COUNT: usize = N;
    fn into_variables(self) -> Vec<Variable> {
        self.into()
    }
}

/// The variables of a field of several parameters, made by [`parameter_group!`](crate::parameter_group).
#[derive(Clone, Debug)]
pub struct Group<const N: usize>(pub Vec<Variable>);

impl<const N: usize> Declaration for Group<N> {
    const COUNT: usize = N;
    fn into_variables(self) -> Vec<Variable> {
        self.0
    }
}

/// The variables that a declaration yields for a field, whose type says whether they are tunable, and whether they vary.
pub fn declared<F: Field, D: Declaration>(declaration: D) -> impl Iterator<Item = Variable> {
    const { assert!(F::LEN == D::COUNT, "a field has another number of values than its declaration has variables") }
    let role = |variable: Variable| if F::IS_TUNABLE { variable.tunable() } else { variable };
    let declared = declaration.into_variables().into_iter().map(role);
    declared.map(|variable| Variable { varies: variable.varies && F::VARIES, ..variable })
}

/// A struct of parameters, made by [`parameters!`](crate::parameters).
pub trait ParameterSet: Clone + std::fmt::Debug + Send + Sync + 'static {
    /// Number of variables.
    const LEN: usize;
    /// The variables, in the order of the fields.
    fn table() -> Vec<Variable>;
    /// Reads the fields from values in the order of the table.
    ///
    /// # Errors
    /// [`ParameterError`] for a value without a meaning, such as an id that no item of an enumeration has.
    fn read(values: &[Tunable]) -> Result<Self, ParameterError>;
}

/// Sets of parameters one behind the other: one list from which the table is made and the values are read.
macro_rules! sets_in_a_row {
    ($($set:ident $value:ident),*) => {
        impl<$($set: ParameterSet),*> ParameterSet for ($($set,)*) {
            const LEN: usize = 0 $(+ $set::LEN)*;

            fn table() -> Vec<Variable> {
                [$($set::table()),*].concat()
            }

            fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
                $(let ($value, values) = values.split_at($set::LEN);)*
                debug_assert!(values.is_empty());
                Ok(($($set::read($value)?,)*))
            }
        }
    };
}

sets_in_a_row!(A a, B b);
sets_in_a_row!(A a, B b, C c);
sets_in_a_row!(A a, B b, C c, D d);
sets_in_a_row!(A a, B b, C c, D d, E e);
sets_in_a_row!(A a, B b, C c, D d, E e, F f);

/// The error for values from the place of a field on that it cannot be read from.
#[cfg(feature = "names")]
pub fn refused<P: ParameterSet>(place: usize, values: &[Tunable]) -> ParameterError {
    let (table, value) = (P::table(), values[place].value);
    let otherwise = || ParameterError::new(&table[place].name, value, "it has no meaning");
    table[place].check(value).err().unwrap_or_else(otherwise)
}

/// The same without the table, which would be compiled for the name alone.
#[cfg(not(feature = "names"))]
pub fn refused<P: ParameterSet>(place: usize, values: &[Tunable]) -> ParameterError {
    ParameterError::new("a parameter", values[place].value, "it has no meaning")
}

/// Declares a [`ParameterSet`]: each field together with the variable (or array of variables) it is read from.
///
/// A field takes as many numbers as its declaration has variables; this is refused by the compiler:
///
/// ```compile_fail
/// use pneumatic_servo::prelude::*;
///
/// parameters! {
///     /// Two stiffnesses, of three variables.
///     Pair {
///         k: [f64; 2] = Variable::parameter(1, "k", units::NEWTON_PER_METRE, 1.0).array([1.0, 2.0, 3.0]);
///     }
/// }
///
/// fn main() {
///     Pair::table();
/// }
/// ```
#[macro_export]
macro_rules! parameters {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty = $declaration:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs, reason = "each field is described by the text of its variable")]
        pub struct $name { $(pub $field: <$type as $crate::variables::Field>::Value),* }

        impl $crate::variables::ParameterSet for $name {
            const LEN: usize = 0 $(+ <$type as $crate::variables::Field>::LEN)*;

            fn table() -> Vec<$crate::variables::Variable> {
                #[allow(unused_mut, reason = "a struct may have no fields")]
                let mut table = Vec::new();
                $(table.extend($crate::variables::declared::<$type, _>($declaration));)*
                table
            }

            #[allow(unused, reason = "a struct may have no fields")]
            fn read(values: &[$crate::variables::Tunable]) -> Result<Self, $crate::variables::ParameterError> {
                let mut next = 0;
                $(
                    let $field = <$type as $crate::variables::Field>::read(&values[next..])
                        .ok_or_else(|| $crate::variables::refused::<Self>(next, values))?;
                    next += <$type as $crate::variables::Field>::LEN;
                )*
                Ok(Self { $($field),* })
            }
        }
    };
}

/// Declares a [`Field`](crate::variables::Field) of several parameters: each field of the struct together with the variable (or array
/// of variables) it is read from. Its `variables()`, which takes the arguments behind the name, declare a field of this type in
/// [`parameters!`](crate::parameters).
#[macro_export]
macro_rules! parameter_group {
    ($(#[$doc:meta])* $name:ident($($argument:ident: $of:ty),*) { $($field:ident: $type:ty = $declaration:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(missing_docs, reason = "each field is described by the text of its variable")]
        pub struct $name { $(pub $field: <$type as $crate::variables::Field>::Value),* }

        impl $crate::variables::Field for $name {
            type Value = Self;
            const LEN: usize = 0 $(+ <$type as $crate::variables::Field>::LEN)*;
            const IS_TUNABLE: bool = true $(&& <$type as $crate::variables::Field>::IS_TUNABLE)*;

            fn read(values: &[$crate::variables::Tunable]) -> Option<Self> {
                $(
                    let $field = <$type as $crate::variables::Field>::read(values)?;
                    let values = &values[<$type as $crate::variables::Field>::LEN..];
                )*
                let _ = values;
                Some(Self { $($field),* })
            }
        }

        impl $name {
            /// Its parameters, in the order of the fields.
            pub fn variables($($argument: $of),*) -> $crate::variables::Group<{ <Self as $crate::variables::Field>::LEN }> {
                let mut all = Vec::new();
                $(all.extend($crate::variables::declared::<$type, _>($declaration));)*
                $crate::variables::Group(all)
            }
        }
    };
}

/// Declares a struct of inputs, generic over the scalar, together with their table.
///
/// The struct gets `LEN`, `table()`, the variables in the order of the fields, and `read()`.
#[macro_export]
macro_rules! inputs {
    ($(#[$doc:meta])* $name:ident { $($field:ident = $declaration:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs, reason = "each field is described by the text of its variable")]
        pub struct $name<S> { $(pub $field: S),* }

        impl $name<f64> {
            /// Number of inputs.
            pub const LEN: usize = [$(stringify!($field)),*].len();

            /// The variables, in the order of the fields.
            pub fn table() -> Vec<$crate::variables::Variable> {
                vec![$($declaration),*]
            }
        }

        impl<S: Copy> $name<S> {
            /// Reads the fields from values in the order of the table.
            #[inline(always)]
            pub fn read([$($field),*]: &[S; $name::<f64>::LEN]) -> Self {
                Self { $($field: *$field),* }
            }
        }
    };
}

/// Declares a struct of computed variables, generic over the scalar, together with their table.
///
/// The struct gets `table()`, the variables in the order of the fields, and `write()`, which puts values in that order. A field with
/// a number of elements is an array, and its declaration a function of the element's number, from 0 on:
///
/// ```
/// use pneumatic_servo::prelude::*;
///
/// outputs! {
///     /// Three forces and their sum.
///     Outputs {
///         forces[3] = |i| Variable::output(20 + i, &format!("force[{}]", i + 1), units::NEWTON);
///         sum = Variable::output(30, "force", units::NEWTON);
///     }
/// }
///
/// let mut slots = [0.0; 5];
/// Outputs { forces: [1.0, 2.0, 3.0], sum: 6.0 }.write(&mut slots);
/// assert_eq!((slots, Outputs::<f64>::LEN), ([1.0, 2.0, 3.0, 6.0, 0.0], 4));
/// assert_eq!(Outputs::<f64>::table()[2].name, "force[3]");
/// ```
#[macro_export]
macro_rules! outputs {
    // The type of a field, the number of its variables, its variables and its values.
    (@type $s:ident) => { $s };
    (@type $s:ident [$count:tt]) => { [$s; $count] };
    (@count) => { 1 };
    (@count [$count:tt]) => { $count };
    (@variables $declaration:expr) => { [$declaration] };
    (@variables $declaration:expr, [$count:tt]) => {{
        let element: fn(u32) -> $crate::variables::Variable = $declaration;
        (0..$count).map(element)
    }};
    (@values $values:expr) => { [$values] };
    (@values $values:expr, [$count:tt]) => { $values };
    ($(#[$doc:meta])* $name:ident { $($field:ident = $declaration:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "each field is described by the text of its variable")]
        pub struct $name<S> { $(pub $field: S),* }

        #[allow(dead_code, reason = "few models say which of their variables are at hand")]
        impl $name<usize> {
            /// The place of each variable in the table.
            pub const PLACES: Self = {
                let mut places = 0;
                $(let $field = places; places += 1;)*
                assert!(places == Self::LEN);
                Self { $($field),* }
            };
        }

        impl<S> $name<S> {
            /// Number of variables.
            pub const LEN: usize = [$(stringify!($field)),*].len();

            /// The variables, in the order of the fields.
            pub fn table() -> Vec<$crate::variables::Variable> {
                vec![$($declaration),*]
            }

            /// Writes the values in the order of the table, and returns the rest of the slots.
            pub fn write(self, slots: &mut [S]) -> &mut [S] where S: Copy {
                let values = [$(self.$field),*];
                let (own, rest) = slots.split_at_mut(Self::LEN);
                own.copy_from_slice(&values);
                rest
            }
        }
    };
    ($(#[$doc:meta])* $name:ident { $($field:ident $([$count:tt])? = $declaration:expr;)* }) => {
        // No derive takes types that macros make.
        $(#[$doc])*
        #[allow(missing_docs, reason = "each field is described by the text of its variable")]
        pub struct $name<S> { $(pub $field: $crate::outputs!(@type S $([$count])?)),* }

        impl<S> $name<S> {
            /// Number of variables.
            pub const LEN: usize = 0 $(+ $crate::outputs!(@count $([$count])?))*;

            /// The variables, in the order of the fields.
            pub fn table() -> Vec<$crate::variables::Variable> {
                let mut table = Vec::with_capacity(Self::LEN);
                $(table.extend($crate::outputs!(@variables $declaration $(, [$count])?));)*
                table
            }

            /// Writes the values in the order of the table, and returns the rest of the slots.
            pub fn write(self, slots: &mut [S]) -> &mut [S] where S: Copy {
                let rest = slots;
                $(
                    let values = $crate::outputs!(@values self.$field $(, [$count])?);
                    let (own, rest) = rest.split_at_mut(values.len());
                    own.copy_from_slice(&values);
                )*
                rest
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::{Role, units};

    parameters! {
        /// Parameters of all kinds.
        Mixed {
            length: Tunable = Variable::parameter(1, "length", units::METRE, 1.0);
            pair: [f64; 2] = Variable::parameter(2, "pair", units::METRE, 1.0).array([1.0, 2.0]);
            count: usize = Variable::count(4, "count", 3).range(0.0, 9.0);
            enabled: bool = Variable::option(5, "enabled", true);
        }
    }

    #[test]
    fn fields_are_read_in_the_order_of_the_table() {
        let read = Mixed::read(&[0.5, 3.0, 4.0, 7.0, 0.0].map(Tunable::still));
        assert_eq!(read, Ok(Mixed { length: Tunable::still(0.5), pair: [3.0, 4.0], count: 7, enabled: false }));
        assert_eq!((Mixed::LEN, Mixed::table().len()), (5, 5));
    }

    #[test]
    fn types_of_fields_say_what_is_tunable() {
        let tunable = |variable: &Variable| variable.role == Role::Tunable;
        assert_eq!(Mixed::table().iter().map(tunable).collect::<Vec<_>>(), [true, false, false, false, false]);
    }

    #[test]
    fn values_without_a_meaning_are_refused_by_name() {
        let refused = |count: f64, enabled: f64| {
            Mixed::read(&[0.5, 3.0, 4.0, count, enabled].map(Tunable::still)).unwrap_err().to_string()
        };
        assert_eq!(refused(2.5, 1.0), "count = 2.5 is refused: it must be a whole number");
        assert_eq!(refused(-1.0, 1.0), "count = -1 is refused: it must be at least 0");
        assert_eq!(refused(2.0, 0.5), "enabled = 0.5 is refused: it must be 0 (false) or 1 (true)");
    }

    /// In the order of the table, independent of the declaration.
    #[test]
    fn sets_in_a_row_are_read_as_they_are_listed() {
        parameters! {
            /// One length.
            Single {
                width: f64 = Variable::parameter(9, "width", units::METRE, 1.0);
            }
        }
        let numbers = |first: [f64; 6]| first.map(Tunable::still);
        let mixed = Mixed { length: Tunable::still(0.5), pair: [3.0, 4.0], count: 7, enabled: false };
        let single = Single { width: 8.0 };
        assert_eq!(
            <(Mixed, Single)>::read(&numbers([0.5, 3.0, 4.0, 7.0, 0.0, 8.0])),
            Ok((mixed.clone(), single.clone()))
        );
        assert_eq!(<(Single, Mixed)>::read(&numbers([8.0, 0.5, 3.0, 4.0, 7.0, 0.0])), Ok((single, mixed)));
        let names: Vec<_> = <(Single, Mixed)>::table().into_iter().map(|variable| variable.name).collect();
        assert_eq!(names, ["width", "length", "pair[1]", "pair[2]", "count", "enabled"]);
    }

    inputs! {
        /// Two inputs.
        Both {
            first = Variable::input(1, "first", units::METRE, 0.0);
            second = Variable::input(2, "second", units::METRE, 0.0);
        }
    }

    #[test]
    fn inputs_are_read_by_name() {
        let Both { first, second } = Both::read(&[1.0, 2.0]);
        assert_eq!((first, second, Both::LEN, Both::table().len()), (1.0, 2.0, 2, 2));
    }
}
