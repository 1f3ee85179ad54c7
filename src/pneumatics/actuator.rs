//! The catalogue of actuators: valves and regulators that feed the chambers of a cylinder on a voltage, on one for each chamber, or on
//! coils.

pub use super::actuation::{
    ACTUATION, Actuating, COIL, COILS, Commands, FLOW, Ports, STATES, SUPPLY, VOLTAGE, VOLTAGE_A, VOLTAGE_B,
};
use super::{regulator, switching, two_regulators, two_valves, valve};

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
            use $crate::pneumatics::{regulator, switching, two_regulators, two_valves, valve};
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
            4 TwoValves two_valves::TwoValves, "A 3/2 proportional valve for each chamber, on valveVoltageA and valveVoltageB";
            5 TwoRegulators two_regulators::TwoRegulators, "A pressure regulator for each chamber, on valveVoltageA and valveVoltageB";
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
            Actuation "Actuation": "Actuator of the cylinder" {
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
        #[serde(bound(serialize = "", deserialize = ""))]
        pub enum Memory<S: $crate::numbers::Varying = $crate::numbers::Real> {
            $($item(<$type as $crate::pneumatics::actuator::Actuating>::Memory<S>)),*
        }

        /// The choice of an actuator and the parameters of each.
        #[derive(Clone, Debug)]
        #[allow(non_snake_case, missing_docs, reason = "each field has the name of its actuator, where it is described")]
        pub struct Parameters {
            choice: Actuation,
            $($item: <$type as $crate::pneumatics::actuator::Actuating>::Parameters),*
        }

        const _: () = {
            use $crate::system::{ClosedForm, Sample, Stride};
            use $crate::numbers::{Pair, Real, Scalar, Varying};
            use $crate::pneumatics::actuator::{ACTUATION, Actuating, Commands, Ports, STATES};
            use $crate::pneumatics::gas::GasState;
            use $crate::pneumatics::orifice::Inflow;
            use $crate::variables::{Choice, ParameterError, ParameterSet, Tunable, Variable};

            /// An expression of the actuator that is chosen, or of it and its memory.
            macro_rules! of_actuator {
                ($self_:expr, |$a:ident| $body:expr) => {
                    match $self_ { $(Actuator::$item($a) => $body),* }
                };
                ($self_:expr, $memory:expr, |$a:ident, $m:ident| $body:expr) => {
                    match ($self_, $memory) {
                        $((Actuator::$item($a), Memory::$item($m)) => $body,)*
                        #[allow(unreachable_patterns, reason = "a catalogue may have one actuator")]
                        _ => unreachable!("the memory of a rig is made by its own actuator"),
                    }
                };
            }

            impl ParameterSet for Parameters {
                const LEN: usize = 1 $(+ <<$type as Actuating>::Parameters as ParameterSet>::LEN)*;

                fn table() -> Vec<Variable> {
                    let start = [$(Actuation::$item),*][0];
                    let mut table = vec![Variable::choice(ACTUATION, "actuation", start).text("Actuator of the cylinder")];
                    $({
                        let own = <$type as Actuating>::Parameters::table().into_iter();
                        table.extend(own.map(|variable| variable.counts_for(ACTUATION, $id)));
                    })*
                    table
                }

                #[allow(non_snake_case, reason = "each field has the name of its actuator")]
                fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
                    let (id, rest) = (values[0].value, &values[1..]);
                    let choice = Actuation::from_id(id)
                        .ok_or_else(|| ParameterError::new("actuation", id, "it must be one of the items of Actuation"))?;
                    $(
                        let (own, rest) = rest.split_at(<<$type as Actuating>::Parameters as ParameterSet>::LEN);
                        let $item = ParameterSet::read(own)?;
                    )*
                    debug_assert!(rest.is_empty(), "all values belong to an actuator");
                    Ok(Self { choice, $($item),* })
                }
            }

            impl Actuating for Actuator {
                type Memory<S: Varying> = Memory<S>;
                type Parameters = Parameters;

                const COMPUTED: usize = 0 $(+ <$type as Actuating>::COMPUTED)*;

                /// Parameters of actuators that are not chosen must fit together, too.
                fn new(parameters: Parameters) -> Result<Self, ParameterError> {
                    let mut actuator = None;
                    $(
                        let built = <$type as Actuating>::new(parameters.$item)?;
                        if parameters.choice == Actuation::$item {
                            actuator = Some(Self::$item(built));
                        }
                    )*
                    Ok(actuator.expect("every item has its line"))
                }

                /// The computed variables of every actuator; those that are not chosen show 0.
                fn computed() -> Vec<Variable> {
                    let mut table = Vec::new();
                    $(table.extend(<$type as Actuating>::computed());)*
                    table
                }
                fn feeds(chamber: usize) -> Vec<u32> {
                    let mut references: Vec<u32> = [$(<$type as Actuating>::feeds(chamber)),*].concat();
                    references.sort_unstable();
                    references.dedup();
                    references
                }
                fn variables(&self) -> [Option<u32>; STATES] {
                    of_actuator!(self, |actuator| actuator.variables())
                }
                fn has_supply(&self) -> bool {
                    of_actuator!(self, |actuator| actuator.has_supply())
                }
                fn scales(&self) -> [f64; STATES] {
                    of_actuator!(self, |actuator| actuator.scales())
                }
                fn start<S: Varying>(&self, commands: Commands<S>) -> ([S; STATES], Memory<S>) {
                    match self {
                        $(Self::$item(actuator) => {
                            let (states, memory) = actuator.start(commands);
                            (states, Memory::$item(memory))
                        })*
                    }
                }
                fn takes_commands_of_chambers(&self) -> bool {
                    of_actuator!(self, |actuator| actuator.takes_commands_of_chambers())
                }
                fn depends_on_time(&self) -> bool {
                    of_actuator!(self, |actuator| actuator.depends_on_time())
                }
                fn is_sampled(&self) -> bool {
                    of_actuator!(self, |actuator| actuator.is_sampled())
                }
                fn has_closed_form(&self) -> bool {
                    of_actuator!(self, |actuator| actuator.has_closed_form())
                }
                #[inline(always)]
                fn feed<S: Scalar>(&self, states: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
                    of_actuator!(self, |actuator| actuator.feed(states, ports, gas))
                }
                #[inline(always)]
                fn feed_at<S: Scalar>(&self, time: S, states: [S; STATES], memory: &Memory<S::Held>, ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>> {
                    of_actuator!(self, memory, |actuator, memory| actuator.feed_at(time, states, memory, ports, gas))
                }
                #[inline(always)]
                fn smooth_region(&self, states: [f64; STATES], ports: &Ports<Real>, pressures: Pair<Real>) -> Pair<Real> {
                    of_actuator!(self, |actuator| actuator.smooth_region(states, ports, pressures))
                }
                fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
                    of_actuator!(self, |actuator| actuator.half(step))
                }
                fn drawn<S: Scalar>(&self, states: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
                    of_actuator!(self, |actuator| actuator.drawn(states, ports, gas))
                }
                fn write<S: Scalar>(&self, states: [S; STATES], commands: Commands<S>, memory: &Memory<S::Held>, slots: &mut [S]) {
                    let rest = slots;
                    $(
                        let (own, rest) = rest.split_at_mut(<$type as Actuating>::COMPUTED);
                        match (self, memory) {
                            (Self::$item(actuator), Memory::$item(memory)) => actuator.write(states, commands, memory, own),
                            #[allow(unreachable_patterns, reason = "a catalogue may have one actuator")]
                            _ => own.fill(S::zero()),
                        }
                    )*
                    debug_assert!(rest.is_empty(), "all slots belong to an actuator");
                }
                fn variable_of(&self, fields: &str) -> Option<&'static str> {
                    of_actuator!(self, |actuator| actuator.variable_of(fields))
                }
                fn fits<S: Varying>(&self, memory: &Memory<S>) -> bool {
                    match (self, memory) {
                        $((Self::$item(actuator), Memory::$item(memory)) => actuator.fits::<S>(memory),)*
                        #[allow(unreachable_patterns, reason = "a catalogue may have one actuator")]
                        _ => false,
                    }
                }
                #[inline(always)]
                fn rates<S: Scalar>(&self, states: [S; STATES], commands: Commands<S>, memory: &Memory<S::Held>) -> [S; STATES] {
                    of_actuator!(self, memory, |actuator, memory| actuator.rates(states, commands, memory))
                }
                #[inline(always)]
                fn later<S: Varying>(&self, states: [S; STATES], commands: Commands<S>, memory: &Memory<S>, stride: &Stride<S>) -> ClosedForm<[S; STATES]> {
                    of_actuator!(self, memory, |actuator, memory| actuator.later(states, commands, memory, stride))
                }
                #[inline(always)]
                fn stays_in_piece<S: Varying>(&self, ends: [[f64; STATES]; 2], commands: Commands<f64>, memory: &Memory<S>, step: f64) -> bool {
                    of_actuator!(self, memory, |actuator, memory| actuator.stays_in_piece::<S>(ends, commands, memory, step))
                }
                #[inline(always)]
                fn is_fast<S: Varying>(&self, memory: &Memory<S>) -> bool {
                    of_actuator!(self, memory, |actuator, memory| actuator.is_fast::<S>(memory))
                }
                #[inline(always)]
                fn follow<S: Varying>(&self, commands: Commands<S>, memory: &mut Memory<S>) {
                    of_actuator!(self, memory, |actuator, memory| actuator.follow(commands, memory))
                }
                fn command<S: Varying>(&self, time: S, commands: Commands<S>, memory: &mut Memory<S>) {
                    of_actuator!(self, memory, |actuator, memory| actuator.command(time, commands, memory))
                }
                fn next_sample<S: Varying>(&self, memory: &Memory<S>) -> Sample<S> {
                    of_actuator!(self, memory, |actuator, memory| actuator.next_sample::<S>(memory))
                }
                fn sample<S: Varying>(&self, states: &mut [S; STATES], commands: Commands<S>, memory: &mut Memory<S>) {
                    of_actuator!(self, memory, |actuator, memory| actuator.sample(states, commands, memory))
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
