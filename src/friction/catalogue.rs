//! A catalogue of friction laws: one line for each law, from which the enumeration, the parameter table and the dispatch are
//! made. The laws of this library are one catalogue; another crate makes its own with [`laws!`](crate::laws).

use serde::{Serialize, de::DeserializeOwned};

use super::event::{Event, Indicators};
use super::law::{Contact, Drive, FrictionLaw, MAX_STATES, StateKind, Stiction};
use crate::hybrid::Sample;
use crate::numbers::Scalar;
use crate::variables::{Choice, Notice, ParameterError, Tunable, Values, Variable};

/// A friction law chosen at run time among those of a catalogue, with its parameters.
///
/// [`laws!`](crate::laws) writes the implementation; each method does what that of [`FrictionLaw`] does.
#[allow(missing_docs, reason = "each method is that of the law, where it is described")]
pub trait Laws: Clone + std::fmt::Debug + Send + Sync + 'static {
    /// The choice of a law.
    type Law: Choice + std::fmt::Debug + PartialEq;

    /// The memory of the law that is chosen.
    type Memory: Clone + PartialEq + std::fmt::Debug + Serialize + DeserializeOwned + Send;

    /// Number of all parameters, that of the choice included.
    const LEN: usize;

    /// Variables of the choice and of every law, in groups below `group`; value references from `base`. The default is the
    /// law of an id, or the first one if the catalogue has no such law.
    fn table(group: &str, base: u32, default: i32) -> Vec<Variable>;

    /// Builds the chosen law from values in the order of the table.
    ///
    /// # Errors
    /// [`ParameterError`] when the values of the chosen law do not fit together.
    fn new(values: &[Tunable], group: &str) -> Result<Self, ParameterError>;

    /// The same from the next values of a model.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    fn read(values: &mut Values, group: &str) -> Result<Self, ParameterError> {
        Self::new(values.take(Self::LEN)?, group)
    }

    /// The law in words, for messages.
    fn title(&self) -> &'static str;

    /// Whether a memory belongs to this law.
    fn owns(&self, memory: &Self::Memory) -> bool;

    #[doc(hidden)]
    fn states(&self) -> usize;
    #[doc(hidden)]
    fn events(&self) -> &'static [Event];
    #[doc(hidden)]
    fn stiction(&self) -> Stiction;
    #[doc(hidden)]
    fn asks_for_applied_force(&self) -> bool;
    #[doc(hidden)]
    fn is_gentle(&self) -> bool;
    #[doc(hidden)]
    fn follows(&self, drive: Drive) -> bool;
    #[doc(hidden)]
    fn state_kind(&self) -> StateKind;
    #[doc(hidden)]
    fn state_scale(&self) -> f64;
    #[doc(hidden)]
    fn max_step(&self) -> f64;
    #[doc(hidden)]
    fn depends_on_time(&self) -> bool;
    #[doc(hidden)]
    fn notice(&self) -> Option<Notice>;
    #[doc(hidden)]
    fn start(&self, contact: &Contact<f64>) -> Self::Memory;
    #[doc(hidden)]
    fn is_sticking(memory: &Self::Memory) -> bool;
    #[doc(hidden)]
    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Self::Memory, rates: &mut [S]) -> S;
    #[doc(hidden)]
    fn relaxation(&self, contact: &Contact<f64>, state: [f64; 2], memory: &Self::Memory) -> f64;
    #[doc(hidden)]
    fn indicators(&self, contact: &Contact<f64>, z: &[f64], memory: &Self::Memory) -> Indicators;
    #[doc(hidden)]
    fn switch(&self, event: Event, at: &Contact<f64>, velocity: &mut f64, z: &mut [f64], memory: &mut Self::Memory);
    #[doc(hidden)]
    fn follow(&self, contact: &Contact<f64>, z: &[f64], memory: &mut Self::Memory) -> bool;
    #[doc(hidden)]
    fn next_sample(&self, memory: &Self::Memory) -> Sample;
    #[doc(hidden)]
    fn sample(&self, contact: &Contact<f64>, z: &[f64], memory: &mut Self::Memory);
}

/// The force of one law: a function of its own, so that a short law does not save the registers that a long one needs.
#[doc(hidden)]
#[inline(never)]
pub fn force<L: FrictionLaw, S: Scalar>(
    law: &L,
    contact: &Contact<S>,
    z: &[S],
    memory: &L::Memory,
    rates: &mut [S],
) -> S {
    law.force(contact, z, memory, rates)
}

/// A law whose parameters fit together, and for whose states there is room.
///
/// # Errors
/// [`ParameterError`] when they do not, or when it asks for more states than [`MAX_STATES`].
#[doc(hidden)]
pub fn checked<L: FrictionLaw>(law: L) -> Result<L, ParameterError> {
    law.check()?;
    if law.states() <= MAX_STATES {
        return Ok(law);
    }
    let reason = format!("the law asks for more states than the {MAX_STATES} that a contact has");
    Err(ParameterError::new("states", law.states() as f64, &reason))
}

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
        pub enum Memory {
            $($law(<$type as $crate::friction::FrictionLaw>::Memory)),*
        }

        const _: () = {
            use $crate::friction::{Contact, Drive, Event, FrictionLaw, Indicators, Laws, StateKind, Stiction};
            use $crate::hybrid::Sample;
            use $crate::numbers::Scalar;
            use $crate::variables::{Choice, Meaning, Notice, ParameterError, ParameterSet, Tunable, Variable};

            /// Runs an expression with the law and its memory, whatever law it is.
            macro_rules! dispatch {
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

            impl Laws for Friction {
                type Law = Law;
                type Memory = Memory;

                const LEN: usize = 1 $(+ <$type as ParameterSet>::LEN)*;

                fn table(group: &str, base: u32, default: i32) -> Vec<Variable> {
                    let default = Law::from_id(default.into()).unwrap_or([$(Law::$law),*][0]);
                    let law = Variable::choice(0, "law", default).text("Friction law of the contact").meaning(Meaning::FrictionLaw);
                    let mut table = vec![law.within(group, base)];
                    $({
                        let (group, first) = (format!("{group}.{}", $group), base.saturating_add(100 * $id));
                        let own = <$type as ParameterSet>::table().into_iter();
                        table.extend(own.map(|variable| variable.within(&group, first).counts_for(base, $id)));
                    })*
                    table
                }

                fn new(values: &[Tunable], group: &str) -> Result<Self, ParameterError> {
                    let id = values[0].value;
                    let chosen = Law::from_id(id).ok_or_else(|| {
                        ParameterError::new("law", id, "it must be one of the items of FrictionLaw").within(group)
                    })?;
                    let rest = &values[1..];
                    $(
                        let (own, rest) = rest.split_at(<$type as ParameterSet>::LEN);
                        if chosen == Law::$law {
                            let law = <$type as ParameterSet>::read(own).and_then($crate::friction::catalogue::checked);
                            return law.map(Friction::$law).map_err(|error| error.within($group).within(group));
                        }
                    )*
                    unreachable!("every law has its line; {} values are left", rest.len())
                }

                fn title(&self) -> &'static str {
                    match self { $(Friction::$law(_) => concat!("friction law ", stringify!($law))),* }
                }

                fn owns(&self, memory: &Memory) -> bool {
                    matches!((self, memory), $((Friction::$law(_), Memory::$law(_)))|*)
                }

                fn states(&self) -> usize {
                    match self { $(Friction::$law(law) => law.states()),* }
                }

                fn events(&self) -> &'static [Event] {
                    match self { $(Friction::$law(law) => law.events()),* }
                }

                fn stiction(&self) -> Stiction {
                    match self { $(Friction::$law(_) => <$type as FrictionLaw>::STICTION),* }
                }

                fn asks_for_applied_force(&self) -> bool {
                    match self { $(Friction::$law(_) => <$type as FrictionLaw>::ASKS_FOR_APPLIED_FORCE),* }
                }

                fn is_gentle(&self) -> bool {
                    match self { $(Friction::$law(law) => law.is_gentle()),* }
                }

                fn follows(&self, drive: Drive) -> bool {
                    match self { $(Friction::$law(_) => <$type as FrictionLaw>::FOLLOWS.contains(&drive)),* }
                }

                fn state_kind(&self) -> StateKind {
                    match self { $(Friction::$law(law) => law.state_kind()),* }
                }

                fn state_scale(&self) -> f64 {
                    match self { $(Friction::$law(law) => law.state_scale()),* }
                }

                fn max_step(&self) -> f64 {
                    match self { $(Friction::$law(law) => law.max_step()),* }
                }

                fn depends_on_time(&self) -> bool {
                    match self { $(Friction::$law(law) => law.depends_on_time()),* }
                }

                fn notice(&self) -> Option<Notice> {
                    match self { $(Friction::$law(law) => law.notice()),* }
                }

                fn start(&self, contact: &Contact<f64>) -> Memory {
                    match self { $(Friction::$law(law) => Memory::$law(law.start(contact))),* }
                }

                fn is_sticking(memory: &Memory) -> bool {
                    match memory { $(Memory::$law(memory) => <$type as FrictionLaw>::is_sticking(memory)),* }
                }

                fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Memory, rates: &mut [S]) -> S {
                    dispatch!(self, memory, |law, memory| {
                        $crate::friction::catalogue::force(law, contact, z, memory, rates)
                    })
                }

                fn relaxation(&self, contact: &Contact<f64>, state: [f64; 2], memory: &Memory) -> f64 {
                    dispatch!(self, memory, |law, memory| law.relaxation(contact, state, memory))
                }

                #[inline(always)]
                fn indicators(&self, contact: &Contact<f64>, z: &[f64], memory: &Memory) -> Indicators {
                    let mut indicators = Indicators::default();
                    dispatch!(self, memory, |law, memory| law.indicators(contact, z, memory, &mut indicators));
                    indicators
                }

                fn switch(
                    &self,
                    event: Event,
                    contact: &Contact<f64>,
                    velocity: &mut f64,
                    z: &mut [f64],
                    memory: &mut Memory,
                ) {
                    dispatch!(self, memory, |law, memory| law.switch(event, contact, velocity, z, memory));
                }

                fn follow(&self, contact: &Contact<f64>, z: &[f64], memory: &mut Memory) -> bool {
                    dispatch!(self, memory, |law, memory| law.follow(contact, z, memory))
                }

                fn next_sample(&self, memory: &Memory) -> Sample {
                    dispatch!(self, memory, |law, memory| law.next_sample(memory))
                }

                fn sample(&self, contact: &Contact<f64>, z: &[f64], memory: &mut Memory) {
                    dispatch!(self, memory, |law, memory| law.sample(contact, z, memory));
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
