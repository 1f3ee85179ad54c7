//! A catalogue of friction laws: one line for each law, from which the enumeration, the parameter table and the dispatch are
//! made. The laws of this library are one catalogue; another crate makes its own with [`laws!`](crate::laws).

use super::law::{Contact, FrictionLaw};
use super::lubrication::Film;
use crate::numbers::Scalar;

/// The force of one law: a function of its own, so that a short law does not save the registers that a long one needs.
#[doc(hidden)]
#[inline(never)]
pub fn force<L: FrictionLaw, S: Scalar>(
    law: &L,
    contact: &Contact<S>,
    z: &[S],
    memory: &L::Memory<S::Held>,
    rates: &mut [S],
) -> S {
    law.force(contact, z, memory, rates)
}

/// The same under factors on Stribeck velocity and viscous friction.
#[doc(hidden)]
#[inline(never)]
pub fn lubricated_force<L: FrictionLaw, S: Scalar>(
    law: &L,
    contact: &Contact<S>,
    film: impl Film<S>,
    z: &[S],
    memory: &L::Memory<S::Held>,
    rates: &mut [S],
) -> S {
    law.lubricated_force(contact, film, z, memory, rates)
}

#[doc(hidden)]
pub use super::law::checked;

/// Makes a catalogue of friction laws, a module with the enumeration `Law`, the laws `Friction` and their memories `Memory`.
///
/// Each line has an id, the name of the law, the group of its parameters, its type and one sentence. With `..builtin` the
/// laws of this library come first. Ids are never reused; those from 1000 on belong to other crates.
///
/// ```
/// use pneumatic_servo::prelude::*;
///
/// parameters! {
///     /// Friction that grows with the square of the velocity.
///     Drag {
///         area: Tunable = Variable::parameter(0, "kappa", units::ONE, 5.0).range(0.0, 1e3).text("Force at 1 m/s");
///     }
/// }
///
/// impl VelocityLaw for Drag {
///     fn force<S: Scalar>(&self, v: S, level: S) -> S {
///         v.abs() * v * level * self.area
///     }
/// }
///
/// laws! {
///     /// All laws, and drag.
///     mod with_drag {
///         ..builtin;
///         1000 Drag "drag" OfVelocity<Drag>, "Quadratic drag";
///     }
/// }
///
/// fn main() {
///     assert_eq!(with_drag::LAWS.id("Drag"), Some(1000));
///     assert_eq!(with_drag::LAWS.id("LuGre"), Some(14));
/// }
/// ```
#[macro_export]
macro_rules! laws {
    ($(#[$doc:meta])* $vis:vis mod $name:ident { ..builtin; $($own:tt)* }) => {
        $(#[$doc])*
        $vis mod $name {
            #[allow(unused_imports, reason = "lines may need none of them")]
            use super::*;
            #[allow(unused_imports, reason = "lines may need none of them")]
            use $crate::friction::laws as builtin;
            #[allow(unused_imports, reason = "lines may need none of them")]
            use $crate::friction::parts::{of_velocity::OfVelocity, one_bristle::OneBristle, stick_slip::StickSlip};
            $crate::own_ids! { $($own)* }
            $crate::builtin_laws! { $($own)* }
        }
    };
    ($(#[$doc:meta])* $vis:vis mod $name:ident { ..$other:ident $($own:tt)* }) => {
        compile_error!(concat!("the laws of the library join by the line `..builtin;`, not by `..", stringify!($other), "`"));
    };
    ($(#[$doc:meta])* $vis:vis mod $name:ident { $($own:tt)* }) => {
        $(#[$doc])*
        $vis mod $name {
            #[allow(unused_imports, reason = "lines may need none of them")]
            use super::*;
            #[allow(unused_imports, reason = "lines may need none of them")]
            use $crate::friction::laws as builtin;
            #[allow(unused_imports, reason = "lines may need none of them")]
            use $crate::friction::parts::{of_velocity::OfVelocity, one_bristle::OneBristle, stick_slip::StickSlip};
            $crate::own_ids! { $($own)* }
            $crate::law_items! { $($own)* }
        }
    };
}

/// The enumeration, the laws and the memories of a catalogue.
#[doc(hidden)]
#[macro_export]
macro_rules! law_items {
    ($($id:literal $law:ident $group:literal $type:ty, $summary:literal;)*) => {
        $crate::enumeration! {
            /// The choice of a friction law; ids are never reused.
            Law "FrictionLaw": "Friction law of the contact" {
                $($id $law: $summary;)*
            }
        }

        /// All laws: ids, names and summaries.
        pub static LAWS: &$crate::variables::Enumeration = <Law as $crate::variables::Choice>::ENUMERATION;

        /// A friction law chosen at run time.
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "each variant is described by the law it names")]
        #[allow(clippy::large_enum_variant, reason = "a plant holds one, and a box would cost each evaluation")]
        pub enum Friction {
            $($law($type)),*
        }

        /// The memory of a friction law chosen at run time.
        #[doc(hidden)]
        // The law is asked for at every evaluation: by a number of its own it is told quicker than by a gap in a variant.
        #[repr(u64)]
        #[derive(Clone, Debug, PartialEq, $crate::serde::Serialize, $crate::serde::Deserialize)]
        #[serde(crate = "pneumatic_servo::serde")]
        #[allow(missing_docs, reason = "each variant is described by the law it names")]
        #[allow(clippy::large_enum_variant, reason = "made once per run and never moved while stepping")]
        #[serde(bound(serialize = "", deserialize = ""))]
        pub enum Memory<S: $crate::numbers::Varying = $crate::numbers::Real> {
            $($law(<$type as $crate::friction::FrictionLaw>::Memory<S>)),*
        }

        const _: () = {
            use $crate::friction::law::NamedState;
            use $crate::friction::{Contact, Drive, Event, FrictionLaw, Indicators, Film, StateKind, Stiction};
            use $crate::system::Sample;
            use $crate::numbers::{Scalar, Varying};
            use $crate::variables::{Choice, Meaning, Notice, ParameterError, ParameterSet, Tunable, Variable};

            /// An expression of the law that is chosen, or of it and its memory.
            macro_rules! of_law {
                ($self_:expr, |$l:ident| $body:expr) => {
                    match $self_ { $(Friction::$law($l) => $body),* }
                };
                ($self_:expr, $memory:expr, |$l:ident, $m:ident| $body:expr) => {
                    match $self_ {
                        $(Friction::$law($l) => match $memory {
                            Memory::$law($m) => $body,
                            #[allow(unreachable_patterns, reason = "a catalogue may have one law")]
                            _ => unreachable!("the memory of a contact is made by its own law"),
                        })*
                    }
                };
            }

            /// The choice of the law, then the parameters of every law in a group of its own.
            impl ParameterSet for Friction {
                const LEN: usize = 1 $(+ <$type as ParameterSet>::LEN)*;

                fn table() -> Vec<Variable> {
                    let first = [$(Law::$law),*][0];
                    let law = Variable::choice(0, "law", first).text("Friction law of the contact");
                    let mut table = vec![law.meaning(Meaning::FrictionLaw)];
                    $({
                        let own = <$type as ParameterSet>::table().into_iter();
                        table.extend(own.map(|variable| variable.within($group, 100 * $id).counts_for(0, $id)));
                    })*
                    table
                }

                fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
                    let id = values[0].value;
                    let chosen = Law::from_id(id)
                        .ok_or_else(|| ParameterError::new("law", id, "it must be one of the items of FrictionLaw"))?;
                    let rest = &values[1..];
                    $(
                        let (own, rest) = rest.split_at(<$type as ParameterSet>::LEN);
                        if chosen == Law::$law {
                            let law = <$type as ParameterSet>::read(own).and_then($crate::friction::catalogue::checked);
                            return law.map(Friction::$law).map_err(|error| error.within($group));
                        }
                    )*
                    unreachable!("every law has its line; {} values are left", rest.len())
                }
            }

            impl FrictionLaw for Friction {
                type Memory<S: Varying> = Memory<S>;

                const NAMED: usize = 0 $(+ <$type as FrictionLaw>::NAMED)*;

                fn title(&self) -> &'static str {
                    match self { $(Friction::$law(_) => concat!("friction law ", stringify!($law))),* }
                }
                fn owns<S: Varying>(&self, memory: &Memory<S>) -> bool {
                    matches!((self, memory), $((Friction::$law(_), Memory::$law(_)))|*)
                }
                fn states(&self) -> usize {
                    of_law!(self, |law| law.states())
                }
                fn couples_states() -> bool {
                    // Of named states the variables say it themselves.
                    false $(|| (<$type as FrictionLaw>::NAMED == 0 && <$type as FrictionLaw>::couples_states()))*
                }
                fn named_states(_group: &str, _law: u32) -> Vec<NamedState> {
                    #[allow(unused_mut, reason = "a catalogue has laws")]
                    let mut named = Vec::new();
                    $(named.extend(<$type as FrictionLaw>::named_states($group, $id));)*
                    named
                }
                fn id(&self) -> u32 {
                    match self { $(Friction::$law(_) => $id),* }
                }
                // By itself, as the scale of all states: in a loop over states the quotient of a law would be computed before it
                // is known that the law is this one, and under another law its divisor may be 0, which traps in some hosts.
                #[inline(never)]
                fn scale_of(&self, state: usize) -> f64 {
                    of_law!(self, |law| law.scale_of(state))
                }
                fn range_of(&self, state: usize) -> [f64; 2] {
                    of_law!(self, |law| law.range_of(state))
                }
                fn start_states<S: Varying>(&self, contact: &Contact<S>, z: &mut [S]) {
                    of_law!(self, |law| law.start_states(contact, z))
                }
                fn events(&self) -> &'static [Event] {
                    of_law!(self, |law| law.events())
                }
                fn stiction(&self) -> Stiction {
                    of_law!(self, |law| law.stiction())
                }
                fn asks_for_applied_force(&self) -> bool {
                    of_law!(self, |law| law.asks_for_applied_force())
                }
                fn may_differ_by_direction(&self) -> bool {
                    of_law!(self, |law| law.may_differ_by_direction())
                }
                fn is_set_valued(&self) -> bool {
                    of_law!(self, |law| law.is_set_valued())
                }
                fn is_lubricated(&self) -> bool {
                    of_law!(self, |law| law.is_lubricated())
                }
                fn sliding_direction<S: Varying>(memory: &Memory<S>) -> Option<f64> {
                    match memory { $(Memory::$law(memory) => <$type as FrictionLaw>::sliding_direction::<S>(memory)),* }
                }
                fn is_non_stiff(&self) -> bool {
                    of_law!(self, |law| law.is_non_stiff())
                }
                fn follows(&self) -> &'static [Drive] {
                    of_law!(self, |law| law.follows())
                }
                fn state_kind(&self) -> StateKind {
                    of_law!(self, |law| law.state_kind())
                }
                #[inline(never)]
                fn state_scale(&self) -> f64 {
                    of_law!(self, |law| law.state_scale())
                }
                fn max_step(&self) -> f64 {
                    of_law!(self, |law| law.max_step())
                }
                fn depends_on_time(&self) -> bool {
                    of_law!(self, |law| law.depends_on_time())
                }
                fn notice(&self) -> Option<Notice> {
                    of_law!(self, |law| law.notice())
                }
                fn start<S: Varying>(&self, contact: &Contact<S>) -> Memory<S> {
                    match self { $(Friction::$law(law) => Memory::$law(law.start(contact))),* }
                }
                fn is_sticking<S: Varying>(memory: &Memory<S>) -> bool {
                    match memory { $(Memory::$law(memory) => <$type as FrictionLaw>::is_sticking::<S>(memory)),* }
                }
                fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Memory<S::Held>, rates: &mut [S]) -> S {
                    of_law!(self, memory, |law, memory| {
                        $crate::friction::catalogue::force(law, contact, z, memory, rates)
                    })
                }
                fn lubricated_force<S: Scalar>(
                    &self,
                    contact: &Contact<S>,
                    film: impl Film<S>,
                    z: &[S],
                    memory: &Memory<S::Held>,
                    rates: &mut [S],
                ) -> S {
                    of_law!(self, memory, |law, memory| {
                        $crate::friction::catalogue::lubricated_force(law, contact, film, z, memory, rates)
                    })
                }
                fn relaxation_rate<S: Varying>(&self, contact: &Contact<S>, state: [S; 2], memory: &Memory<S>) -> f64 {
                    of_law!(self, memory, |law, memory| law.relaxation_rate(contact, state, memory))
                }
                #[inline(always)]
                fn indicators<S: Varying>(&self, contact: &Contact<S>, z: &[S], memory: &Memory<S>, out: &mut Indicators<S>) {
                    of_law!(self, memory, |law, memory| law.indicators(contact, z, memory, out))
                }
                fn switch<S: Varying>(
                    &self,
                    event: Event,
                    contact: &Contact<S>,
                    velocity: &mut S,
                    z: &mut [S],
                    memory: &mut Memory<S>,
                ) {
                    of_law!(self, memory, |law, memory| law.switch(event, contact, velocity, z, memory))
                }
                fn follow<S: Varying>(&self, contact: &Contact<S>, z: &[S], memory: &mut Memory<S>) -> bool {
                    of_law!(self, memory, |law, memory| law.follow(contact, z, memory))
                }
                fn next_sample<S: Varying>(&self, memory: &Memory<S>) -> Sample<S> {
                    of_law!(self, memory, |law, memory| law.next_sample::<S>(memory))
                }
                fn sample<S: Varying>(&self, contact: &Contact<S>, z: &[S], memory: &mut Memory<S>) {
                    of_law!(self, memory, |law, memory| law.sample(contact, z, memory))
                }
            }
        };
    };
    ($($other:tt)*) => {
        compile_error!(
            "each line of `laws!` has an id, a name, the group of the parameters, the type and one sentence: \
             1000 Mine \"mine\" OfVelocity<Mine>, \"What it does\";"
        );
    };
}
