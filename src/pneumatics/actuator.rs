//! What feeds the chambers of a cylinder, on a voltage: actuators to choose from.

use serde::{Serialize, de::DeserializeOwned};

pub use super::actuating::{Actuating, FLOW, Ports, STATES, SUPPLY, VOLTAGE};
use super::gas::GasState;
use super::orifice::Inflow;
use super::{regulator, switching, valve};
use crate::hybrid::{Led, Sample, Stride};
use crate::numbers::{Pair, Real, Scalar};
use crate::variables::{Choice, ParameterError, Tunable, Values, Variable};

/// An actuator chosen at run time among those of a catalogue, with its parameters.
///
/// [`actuators!`](crate::actuators) writes the implementation; each method without a text of its own does what that of
/// [`Actuating`] does.
#[allow(missing_docs, reason = "each method is that of the actuator, where it is described")]
pub trait Actuators: Clone + std::fmt::Debug + Send + Sync + 'static {
    /// The choice of an actuator.
    type Choice: Choice;

    /// The memory of the actuator that is chosen.
    type Memory: Clone + PartialEq + std::fmt::Debug + Serialize + DeserializeOwned + Send;

    /// Number of all parameters, that of the choice included.
    const LEN: usize;

    /// The choice and the parameters of every actuator; value reference of the choice.
    fn parameters(choice: u32) -> Vec<Variable>;

    /// The computed variables of every actuator; those of the others show 0.
    fn computed() -> Vec<Variable>;

    /// Value references on which the inflow of a chamber depends, whatever the actuator.
    fn feeds(chamber: usize) -> Vec<u32>;

    /// Builds the chosen actuator from values in the order of [`parameters`](Self::parameters); those of the others must fit
    /// together, too.
    ///
    /// # Errors
    /// [`ParameterError`] when values do not fit together.
    fn new(values: &[Tunable]) -> Result<Self, ParameterError>;

    /// The same from the next values of a model.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    fn read(values: &mut Values) -> Result<Self, ParameterError> {
        Self::new(values.take(Self::LEN)?)
    }

    /// Whether the supply pressure, an input, has a part in what flows.
    fn has_supply(&self) -> bool;

    /// Place of the state that a variable stands for, if the actuator has it.
    fn state_at(&self, reference: u32) -> Option<usize>;

    /// Whether it changes by itself at points in time.
    fn is_sampled(&self) -> bool;

    /// Whether its states have a closed form while the voltage is held.
    fn has_closed_form(&self) -> bool;

    /// Whether what flows depends on the state that as a rule only leads to the other one.
    fn feeds_by_both_states(&self) -> bool;

    /// What flows into the chambers. Compiled without `SAMPLED`, it is for the other actuators only, which then pay nothing
    /// for those that change by themselves.
    fn feed<const SAMPLED: bool, S: Scalar>(
        &self,
        states: [S; STATES],
        ports: &Ports<S>,
        gas: GasState<Pair<S>>,
    ) -> Inflow<Pair<S>>;

    /// Writes the computed variables of every actuator, and returns the rest of the slots.
    fn write<'s, S: Scalar>(
        &self,
        states: [S; STATES],
        voltage: S,
        memory: &Self::Memory,
        slots: &'s mut [S],
    ) -> &'s mut [S];

    /// Whether a memory can belong to this actuator.
    fn fits(&self, memory: &Self::Memory) -> bool;

    #[doc(hidden)]
    fn scales(&self) -> [f64; STATES];
    #[doc(hidden)]
    fn start(&self, voltage: f64) -> ([f64; STATES], Self::Memory);
    #[doc(hidden)]
    fn piece(&self, states: [f64; STATES], ports: &Ports<Real>, pressures: Pair<Real>) -> Pair<Real>;
    #[doc(hidden)]
    fn half(&self, step: f64) -> [[f64; STATES]; STATES];
    #[doc(hidden)]
    fn drawn<S: Scalar>(&self, states: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S>;
    #[doc(hidden)]
    fn rates<S: Scalar>(&self, states: [S; STATES], voltage: S, memory: &Self::Memory) -> [S; STATES];
    #[doc(hidden)]
    fn later(&self, states: [f64; STATES], voltage: f64, memory: &Self::Memory, stride: &Stride) -> Led<[f64; STATES]>;
    #[doc(hidden)]
    fn stays_in_piece(&self, ends: [[f64; STATES]; 2], voltage: f64, memory: &Self::Memory, step: f64) -> bool;
    #[doc(hidden)]
    fn is_hasty(&self, memory: &Self::Memory) -> bool;
    #[doc(hidden)]
    fn follow(&self, voltage: f64, memory: &mut Self::Memory);
    #[doc(hidden)]
    fn next_sample(&self, memory: &Self::Memory) -> Sample;
    #[doc(hidden)]
    fn sample(&self, states: &mut [f64; STATES], voltage: f64, memory: &mut Self::Memory);
}

/// Makes a catalogue of actuators, a module with the enumeration `Actuation`, the actuators `Actuator` and their memories
/// `Memory`.
///
/// Each line has an id, the name of the item, its type and one sentence. With `..builtin` the actuators of this library come
/// first; ids from 1000 on belong to other crates.
#[macro_export]
macro_rules! actuators {
    ($(#[$doc:meta])* $vis:vis mod $name:ident { ..builtin; $($own:tt)* }) => {
        $(#[$doc])*
        $vis mod $name {
            use super::*;
            use $crate::pneumatics::{regulator, switching, valve};
            $crate::own_ids! { $($own)* }
            $crate::builtin_actuators! { $($own)* }
        }
    };
    ($(#[$doc:meta])* $vis:vis mod $name:ident { ..$other:ident $($own:tt)* }) => {
        compile_error!(concat!("the actuators of the library join by the line `..builtin;`, not by `..", stringify!($other), "`"));
    };
    ($(#[$doc:meta])* $vis:vis mod $name:ident { $($own:tt)* }) => {
        $(#[$doc])*
        $vis mod $name {
            use super::*;
            $crate::own_ids! { $($own)* }
            $crate::actuator_items! { $($own)* }
        }
    };
}

/// The actuators of this library, with further lines behind them.
#[doc(hidden)]
#[macro_export]
macro_rules! builtin_actuators {
    ($($own:tt)*) => {
        $crate::actuator_items! {
            1 ProportionalValve valve::ProportionalValve, "5/3 proportional valve between supply and both chambers";
            2 PressureRegulator regulator::PressureRegulator, "Pressure regulator feeding chamber A, chamber B plugged";
            3 SwitchingValves switching::SwitchingValves, "Two switching valves driven by pulses, between supply and both chambers";
            $($own)*
        }
    };
}

/// The enumeration, the actuators and the memories of a catalogue.
#[doc(hidden)]
#[macro_export]
macro_rules! actuator_items {
    ($($id:literal $item:ident $type:ty, $summary:literal;)*) => {
        $crate::enumeration! {
            /// The choice of the rig; ids are never reused.
            Actuation "Actuation": "What moves the cylinder" {
                $($id $item: $summary;)*
            }
        }

        /// An actuator chosen at run time.
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "each variant is described by the type it names")]
        #[allow(clippy::large_enum_variant, reason = "a plant holds one, and a box would cost each evaluation")]
        pub enum Actuator {
            $($item($type)),*
        }

        /// The memory of an actuator chosen at run time.
        #[doc(hidden)]
        #[derive(Clone, Debug, PartialEq, $crate::serde::Serialize, $crate::serde::Deserialize)]
        #[serde(crate = "pneumatic_servo::serde")]
        #[allow(missing_docs, reason = "each variant is described by the type it names")]
        pub enum Memory {
            $($item(<$type as $crate::pneumatics::actuator::Actuating>::Memory)),*
        }

        const _: () = {
            use $crate::hybrid::{Led, Sample, Stride};
            use $crate::numbers::{Pair, Real, Scalar};
            use $crate::pneumatics::actuator::{Actuating, Actuators, Ports, STATES, SUPPLY};
            use $crate::pneumatics::gas::GasState;
            use $crate::pneumatics::orifice::Inflow;
            use $crate::variables::{Choice, ParameterError, ParameterSet, Tunable, Variable};

            /// Runs an expression with the actuator and its memory, whatever actuator it is.
            macro_rules! dispatch {
                ($self_:expr, $memory:expr, |$a:ident, $m:ident| $body:expr) => {
                    match ($self_, $memory) {
                        $((Actuator::$item($a), Memory::$item($m)) => $body,)*
                        #[allow(unreachable_patterns, reason = "a catalogue may have one actuator")]
                        _ => unreachable!("the memory of a rig is made by its own actuator"),
                    }
                };
            }

            impl Actuators for Actuator {
                type Choice = Actuation;
                type Memory = Memory;

                const LEN: usize = 1 $(+ <<$type as Actuating>::Parameters as ParameterSet>::LEN)*;

                fn parameters(choice: u32) -> Vec<Variable> {
                    let start = [$(Actuation::$item),*][0];
                    let mut table = vec![Variable::choice(choice, "actuation", start).text("What moves the cylinder")];
                    $({
                        let own = <$type as Actuating>::Parameters::table().into_iter();
                        table.extend(own.map(|variable| variable.counts_for(choice, $id)));
                    })*
                    table
                }

                fn computed() -> Vec<Variable> {
                    let mut table = Vec::new();
                    $(table.extend(<$type as Actuating>::computed());)*
                    table
                }

                fn feeds(chamber: usize) -> Vec<u32> {
                    let mut references: Vec<u32> =
                        [$(<$type as Actuating>::FEEDS[chamber]),*].concat();
                    references.sort_unstable();
                    references.dedup();
                    references
                }

                fn new(values: &[Tunable]) -> Result<Self, ParameterError> {
                    let id = values[0].value;
                    let chosen = Actuation::from_id(id)
                        .ok_or_else(|| ParameterError::new("actuation", id, "it must be one of the items of Actuation"))?;
                    let (mut actuator, mut rest) = (None, &values[1..]);
                    $(
                        let own = <<$type as Actuating>::Parameters as ParameterSet>::LEN;
                        let built = <$type as Actuating>::new(ParameterSet::read(&rest[..own])?)?;
                        if chosen == Actuation::$item {
                            actuator = Some(Self::$item(built));
                        }
                        rest = &rest[own..];
                    )*
                    debug_assert!(rest.is_empty(), "all values belong to an actuator");
                    Ok(actuator.expect("every item has its line"))
                }

                fn has_supply(&self) -> bool {
                    let [of_a, _] = match self { $(Self::$item(_) => <$type as Actuating>::FEEDS),* };
                    of_a.contains(&SUPPLY)
                }

                fn state_at(&self, reference: u32) -> Option<usize> {
                    let own = match self { $(Self::$item(_) => <$type as Actuating>::VARIABLES),* };
                    own.iter().position(|variable| *variable == Some(reference))
                }

                fn scales(&self) -> [f64; STATES] {
                    match self { $(Self::$item(actuator) => actuator.scales()),* }
                }

                fn start(&self, voltage: f64) -> ([f64; STATES], Memory) {
                    match self {
                        $(Self::$item(actuator) => {
                            let (states, memory) = actuator.start(voltage);
                            (states, Memory::$item(memory))
                        })*
                    }
                }

                fn is_sampled(&self) -> bool {
                    match self { $(Self::$item(_) => <$type as Actuating>::IS_SAMPLED),* }
                }

                fn has_closed_form(&self) -> bool {
                    match self { $(Self::$item(_) => <$type as Actuating>::HAS_CLOSED_FORM),* }
                }

                fn feeds_by_both_states(&self) -> bool {
                    let (leading, feeds) = match self {
                        $(Self::$item(_) => (<$type as Actuating>::VARIABLES[0], <$type as Actuating>::FEEDS)),*
                    };
                    leading.is_some_and(|state| feeds.iter().any(|of_chamber| of_chamber.contains(&state)))
                }

                #[inline(always)]
                fn feed<const SAMPLED: bool, S: Scalar>(
                    &self,
                    states: [S; STATES],
                    ports: &Ports<S>,
                    gas: GasState<Pair<S>>,
                ) -> Inflow<Pair<S>> {
                    match self {
                        $(Self::$item(actuator) => {
                            if !SAMPLED && <$type as Actuating>::IS_SAMPLED {
                                unreachable!("a sampled actuator has equations of its own");
                            }
                            actuator.feed(states, ports, gas)
                        })*
                    }
                }

                #[inline(always)]
                fn piece(&self, states: [f64; STATES], ports: &Ports<Real>, pressures: Pair<Real>) -> Pair<Real> {
                    match self { $(Self::$item(actuator) => actuator.piece(states, ports, pressures)),* }
                }

                fn half(&self, step: f64) -> [[f64; STATES]; STATES] {
                    match self { $(Self::$item(actuator) => actuator.half(step)),* }
                }

                fn drawn<S: Scalar>(
                    &self,
                    states: [S; STATES],
                    ports: &Ports<S>,
                    gas: GasState<Pair<S>>,
                ) -> Pair<S> {
                    match self { $(Self::$item(actuator) => actuator.drawn(states, ports, gas)),* }
                }

                fn write<'s, S: Scalar>(
                    &self,
                    states: [S; STATES],
                    voltage: S,
                    memory: &Memory,
                    slots: &'s mut [S],
                ) -> &'s mut [S] {
                    let rest = slots;
                    $(
                        let (own, rest) = rest.split_at_mut(<$type as Actuating>::COMPUTED);
                        match (self, memory) {
                            (Self::$item(actuator), Memory::$item(memory)) => actuator.write(states, voltage, memory, own),
                            #[allow(unreachable_patterns, reason = "a catalogue may have one actuator")]
                            _ => own.fill(S::zero()),
                        }
                    )*
                    rest
                }

                fn fits(&self, memory: &Memory) -> bool {
                    match (self, memory) {
                        $((Self::$item(actuator), Memory::$item(memory)) => actuator.fits(memory),)*
                        #[allow(unreachable_patterns, reason = "a catalogue may have one actuator")]
                        _ => false,
                    }
                }

                #[inline(always)]
                fn rates<S: Scalar>(&self, states: [S; STATES], voltage: S, memory: &Memory) -> [S; STATES] {
                    dispatch!(self, memory, |actuator, memory| actuator.rates(states, voltage, memory))
                }

                #[inline(always)]
                fn later(&self, states: [f64; STATES], voltage: f64, memory: &Memory, stride: &Stride) -> Led<[f64; STATES]> {
                    dispatch!(self, memory, |actuator, memory| actuator.later(states, voltage, memory, stride))
                }

                #[inline(always)]
                fn stays_in_piece(&self, ends: [[f64; STATES]; 2], voltage: f64, memory: &Memory, step: f64) -> bool {
                    dispatch!(self, memory, |actuator, memory| actuator.stays_in_piece(ends, voltage, memory, step))
                }

                #[inline(always)]
                fn is_hasty(&self, memory: &Memory) -> bool {
                    dispatch!(self, memory, |actuator, memory| actuator.is_hasty(memory))
                }

                #[inline(always)]
                fn follow(&self, voltage: f64, memory: &mut Memory) {
                    dispatch!(self, memory, |actuator, memory| actuator.follow(voltage, memory));
                }

                fn next_sample(&self, memory: &Memory) -> Sample {
                    dispatch!(self, memory, |actuator, memory| actuator.next_sample(memory))
                }

                fn sample(&self, states: &mut [f64; STATES], voltage: f64, memory: &mut Memory) {
                    dispatch!(self, memory, |actuator, memory| actuator.sample(states, voltage, memory));
                }
            }
        };
    };
    ($($other:tt)*) => {
        compile_error!(
            "each line of `actuators!` has an id, a name, the type and one sentence: 1000 Mine Mine, \"What it is\";"
        );
    };
}

builtin_actuators! {}
