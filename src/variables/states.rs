//! The continuous states of a model, declared once: their places, their variables, their magnitudes.

/// The states of a model, as [`states!`](crate::states) declares them.
pub trait StateSet<P>: Copy + PartialEq + 'static {
    /// All of them.
    const ALL: &'static [Self];
    /// Number of states other than friction states.
    const OTHERS: usize;

    /// Index among `n` states.
    fn at(self, n: usize) -> usize;

    /// Value reference of the variable.
    fn reference(self) -> u32;

    /// The state of a value reference.
    fn of(reference: u32) -> Option<Self>;

    /// Magnitude under these parameters, for error control.
    fn scale(self, parameters: &P) -> f64;
}

/// Declares the states of a model in the order in which they are integrated: those before the states of its friction
/// law, and those after them, each with the value reference of its variable and its magnitude for given parameters.
///
/// ```text
/// State of Parameters, from 0; {
///     Pressure: 107, |_| 1e5;
///     ..friction;
///     Position: 101, |p| p.stroke;
/// }
/// ```
///
/// Equations read a state by its name, `State::Position.get(x)`, and write its rate as `State::Position.set(&mut rates, velocity)`.
///
/// A row of states has a number of elements and the step of their value references: `Place[10 step 2]: 100, |_| 1.0;` declares ten
/// states with the value references 100, 102, ..., and equations read `State::Place[3].get(x)`. Rows are for models without
/// `..friction;`, where `State` is a place among the states and no enumeration.
///
/// ```
/// use pneumatic_servo::prelude::*;
///
/// states! {
///     /// Three blocks that one crane tows.
///     State of f64 {
///         Crane: 10, |_| 1.0;
///         Place[3 step 10]: 101, |_| 0.1;
///         Velocity[3 step 10]: 102, |scale| *scale;
///     }
/// }
///
/// let places = State::Velocity.map(|velocity| (velocity.get(&[0, 1, 2, 3, 4, 5, 6]), velocity.reference()));
/// assert_eq!(places, [(4, 102), (5, 112), (6, 122)]);
/// assert_eq!((State::Crane.reference(), State::of(111), State::OTHERS), (10, Some(State::Place[1]), 7));
/// ```
///
/// `from` is the number of states that come before all of these and are declared elsewhere. Friction laws have different
/// numbers of states, so that the place of a state depends on the number of all. A model without friction laws leaves
/// `, from 0;` and `..friction;` out.
#[macro_export]
macro_rules! states {
    // The number of elements of a row, and the step of their value references.
    (@count) => { 1 };
    (@count [$count:tt step $step:tt]) => { $count };
    (@step) => { 0 };
    (@step [$count:tt step $step:tt]) => { $step };
    // The states and rows by name, each behind those before it.
    (@places [$($first:tt)*]) => {
        /// Number of states other than friction states.
        pub const OTHERS: usize = $($first)*;
    };
    (@places [$($first:tt)*] $state:ident; $($others:tt)*) => {
        pub const $state: Self = Self($($first)*);
        $crate::states! { @places [$($first)* + 1] $($others)* }
    };
    (@places [$($first:tt)*] $state:ident [$count:tt step $step:tt]; $($others:tt)*) => {
        pub const $state: [Self; $count] = Self::row($($first)*);
        $crate::states! { @places [$($first)* + $count] $($others)* }
    };
    // Interface of every set of states.
    (@set $name:ident of $parameters:ty) => {
        impl $crate::variables::StateSet<$parameters> for $name {
            const ALL: &'static [Self] = Self::ALL;
            const OTHERS: usize = Self::OTHERS;

            #[inline(always)]
            fn at(self, n: usize) -> usize {
                self.at(n)
            }

            fn reference(self) -> u32 {
                self.reference()
            }

            fn of(reference: u32) -> Option<Self> {
                Self::of(reference)
            }

            fn scale(self, parameters: &$parameters) -> f64 {
                self.scale(parameters)
            }
        }
    };
    // A state declared twice would have two meanings.
    (@different $name:ident) => {
        const _: () = {
            let (states, mut index) = ($name::ALL, 0);
            while index < states.len() {
                let mut other = 0;
                while other < index {
                    let differ = states[other].reference() != states[index].reference();
                    assert!(differ, "two states have the same value reference");
                    other += 1;
                }
                index += 1;
            }
        };
    };
    (
        $(#[$doc:meta])* $name:ident of $parameters:ty { $($state:ident: $reference:expr, $scale:expr;)* }
    ) => {
        $crate::states! { $(#[$doc])* $name of $parameters, from 0; { ..friction; $($state: $reference, $scale;)* } }
    };
    (
        $(#[$doc:meta])* $name:ident of $parameters:ty, from $from:expr; {
            $($before:ident: $before_reference:expr, $before_scale:expr;)*
            ..friction;
            $($after:ident: $after_reference:expr, $after_scale:expr;)*
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs, reason = "each state is described by the text of its variable")]
        pub enum $name { $($before,)* $($after),* }

        #[allow(clippy::redundant_closure_call, reason = "magnitudes are stated as functions of the parameters")]
        impl $name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$before,)* $(Self::$after),*];
            /// Index of the first state of the friction law.
            #[allow(dead_code, reason = "a model may have no friction law")]
            pub const FRICTION: usize = $from $(+ { let _ = Self::$before; 1 })*;
            /// Number of states other than friction states.
            pub const OTHERS: usize = $from + Self::ALL.len();

            /// Index in a vector of any length.
            #[inline(always)]
            pub const fn index(self) -> $crate::system::StateIndex {
                let place = $from + self as usize;
                if place < Self::FRICTION {
                    $crate::system::StateIndex::Front(place)
                } else {
                    $crate::system::StateIndex::Back(Self::OTHERS - (place + 1))
                }
            }

            /// Index among `n` states.
            #[inline(always)]
            pub const fn at(self, n: usize) -> usize {
                self.index().among(n)
            }

            /// Its value among all states.
            #[inline(always)]
            #[allow(dead_code, reason = "a model may have no states of its own")]
            pub fn get<S: Copy>(self, x: &[S]) -> S {
                x[self.at(x.len())]
            }

            /// Gives it a value among all states.
            #[inline(always)]
            #[allow(dead_code, reason = "a model may have no states of its own")]
            pub fn set<S>(self, x: &mut [S], value: S) {
                x[self.at(x.len())] = value;
            }

            /// Value reference of the variable.
            pub const fn reference(self) -> u32 {
                match self { $(Self::$before => $before_reference,)* $(Self::$after => $after_reference),* }
            }

            /// The state of a value reference.
            pub fn of(reference: u32) -> Option<Self> {
                Self::ALL.iter().copied().find(|state| state.reference() == reference)
            }

            /// Magnitude, for error control.
            #[allow(unused_variables, reason = "a model may have no states of its own")]
            pub fn scale(self, parameters: &$parameters) -> f64 {
                let of = |scale: fn(&$parameters) -> f64| scale(parameters);
                match self {
                    $(Self::$before => of($before_scale),)*
                    $(Self::$after => of($after_scale)),*
                }
            }
        }

        $crate::states! { @set $name of $parameters }
        $crate::states! { @different $name }
    };
    (
        $(#[$doc:meta])* $name:ident of $parameters:ty {
            $($state:ident $([$count:tt step $step:tt])?: $reference:expr, $scale:expr;)*
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name(usize);

        #[allow(clippy::redundant_closure_call, reason = "magnitudes are stated as functions of the parameters")]
        #[allow(missing_docs, reason = "each state is described by the text of its variable")]
        #[allow(non_upper_case_globals, reason = "states are named as in models without rows")]
        #[allow(dead_code, reason = "a model may have no use for some of this")]
        impl $name {
            $crate::states! { @places [0] $($state $([$count step $step])?;)* }

            /// All of them.
            pub const ALL: &[Self] = &Self::row::<{ Self::OTHERS }>(0);

            /// States in a row behind the first ones.
            const fn row<const COUNT: usize>(first: usize) -> [Self; COUNT] {
                let (mut row, mut element) = ([Self(first); COUNT], 0);
                while element < COUNT {
                    row[element] = Self(first + element);
                    element += 1;
                }
                row
            }

            /// Index among `n` states.
            #[inline(always)]
            pub const fn at(self, n: usize) -> usize {
                self.index().among(n)
            }

            /// Index in a vector of any length.
            #[inline(always)]
            pub const fn index(self) -> $crate::system::StateIndex {
                $crate::system::StateIndex::Back(Self::OTHERS - (self.0 + 1))
            }

            /// Its value among all states.
            #[inline(always)]
            pub fn get<S: Copy>(self, x: &[S]) -> S {
                x[self.at(x.len())]
            }

            /// Gives it a value among all states.
            #[inline(always)]
            pub fn set<S>(self, x: &mut [S], value: S) {
                x[self.at(x.len())] = value;
            }

            /// Value reference of the variable.
            #[allow(unused_assignments, reason = "nothing comes behind the last one")]
            pub const fn reference(self) -> u32 {
                let mut first = 0;
                $({
                    let count = $crate::states!(@count $([$count step $step])?);
                    if self.0 < first + count {
                        let step: u32 = $crate::states!(@step $([$count step $step])?);
                        return $reference + step * (self.0 - first) as u32;
                    }
                    first += count;
                })*
                unreachable!()
            }

            /// The state of a value reference.
            pub fn of(reference: u32) -> Option<Self> {
                Self::ALL.iter().copied().find(|state| state.reference() == reference)
            }

            /// Magnitude, for error control.
            #[allow(unused_assignments, reason = "nothing comes behind the last one")]
            pub fn scale(self, parameters: &$parameters) -> f64 {
                let of = |scale: fn(&$parameters) -> f64| scale(parameters);
                let mut first = 0;
                $({
                    first += $crate::states!(@count $([$count step $step])?);
                    if self.0 < first {
                        return of($scale);
                    }
                })*
                unreachable!()
            }
        }

        $crate::states! { @set $name of $parameters }
        $crate::states! { @different $name }
    };
    (
        $(#[$doc:meta])* $name:ident of $parameters:ty $(, from $from:expr;)? {
            $($before:ident: $before_reference:expr $(, $before_scale:expr)?;)*
            $(..friction; $($after:ident: $after_reference:expr $(, $after_scale:expr)?;)*)?
        }
    ) => {
        compile_error!("each state needs its magnitude: `Velocity: 11, |parameters| 1.0;`");
    };
}

#[cfg(test)]
mod tests {
    states! {
        /// Two states before the friction states and one behind.
        State of f64, from 1; {
            Low: 11, |_| 1.0;
            High: 12, |p| 2.0 * p;
            ..friction;
            Last: 5, |p| p * p;
        }
    }

    #[test]
    fn places_leave_room_for_what_comes_first_and_for_friction() {
        assert_eq!([State::Low, State::High, State::Last].map(|state| state.at(9)), [1, 2, 8]);
        assert_eq!((State::FRICTION, State::OTHERS), (3, 4));
        assert_eq!([State::Low, State::Last].map(|state| state.get(&[0, 1, 2, 3, 4, 5])), [1, 5]);
        let mut x = [0; 6];
        State::Last.set(&mut x, 7);
        assert_eq!(x, [0, 0, 0, 0, 0, 7]);
    }

    #[test]
    fn variables_and_magnitudes_belong_to_their_states() {
        assert_eq!([11, 12, 5, 0].map(State::of), [Some(State::Low), Some(State::High), Some(State::Last), None]);
        assert_eq!([State::Low, State::High, State::Last].map(|state| state.scale(&3.0)), [1.0, 6.0, 9.0]);
    }
}
