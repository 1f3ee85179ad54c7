//! The registry: one line for each law, from which the enumeration, the parameter table and the dispatch are made.

use serde::{Deserialize, Serialize};

use super::event::{Event, Indicators};
use super::law::{Contact, Drive, FrictionLaw, StateKind, Stiction};
use super::laws::*;
use super::parts::of_velocity::OfVelocity;
use super::parts::one_bristle::OneBristle;
use super::parts::stick_slip::StickSlip;
use crate::enumeration;
use crate::hybrid::Sample;
use crate::numbers::Scalar;
use crate::variables::{Choice, Enumeration, Notice, ParameterError, ParameterSet, Tunable, Variable};

/// Makes the enumeration of laws, the parameter table and the dispatch from one line per law.
macro_rules! registry {
    ($($id:literal $law:ident $group:literal $type:ty, $summary:literal;)*) => {
        enumeration! {
            /// The choice of a friction law; ids are never reused.
            Law "FrictionLaw": "Friction law of the contact" {
                $($id $law: $summary;)*
            }
        }

        /// A friction law chosen at run time.
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "each variant is described by the law it names")]
        #[expect(clippy::large_enum_variant, reason = "a plant holds one, and a box would cost each evaluation")]
        pub enum Friction {
            $($law($type)),*
        }

        /// The memory of a friction law chosen at run time.
        // The law is asked for at every evaluation: by a number of its own it is told quicker than by a gap in a variant.
        #[repr(u64)]
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[allow(missing_docs, reason = "each variant is described by the law it names")]
        #[allow(clippy::large_enum_variant, reason = "made once per run and never moved while stepping")]
        pub enum Memory {
            $($law(<$type as FrictionLaw>::Memory)),*
        }

        /// Runs an expression with the law and its memory, whatever law it is.
        macro_rules! dispatch {
            ($self_:expr, $memory:expr, |$l:ident, $m:ident| $body:expr) => {
                match $self_ {
                    $(Friction::$law($l) => match $memory {
                        Memory::$law($m) => $body,
                        _ => unreachable!("the memory of a contact is made by its own law"),
                    })*
                }
            };
        }

        impl Friction {
            /// Variables of the choice and of every law, in groups below `group`; value references from `base`.
            pub fn table(group: &str, base: u32, default: Law) -> Vec<Variable> {
                let law = Variable::choice(0, "law", default).text("Friction law of the contact");
                let mut table = vec![law.within(group, base)];
                $(table.extend(
                    <$type as ParameterSet>::table()
                        .into_iter()
                        .map(|variable| variable.within(&format!("{group}.{}", $group), base + 100 * $id)),
                );)*
                table
            }

            /// Builds the chosen law from values in the order of the table.
            ///
            /// # Errors
            /// [`ParameterError`] when the values of the chosen law do not fit together.
            pub fn new(values: &[Tunable], group: &str) -> Result<Self, ParameterError> {
                let id = values[0].value;
                let chosen = Law::from_id(id).ok_or_else(|| {
                    ParameterError::new("law", id, "it must be one of the items of FrictionLaw").within(group)
                })?;
                let rest = &values[1..];
                $(
                    let (own, rest) = rest.split_at(<$type as ParameterSet>::LEN);
                    if chosen == Law::$law {
                        let law = <$type as ParameterSet>::read(own).and_then(|law| law.check().map(|()| law));
                        return law.map(Friction::$law).map_err(|error| error.within($group).within(group));
                    }
                )*
                unreachable!("every law has its line; {} values are left", rest.len())
            }

            /// The law in words, for messages.
            pub fn title(&self) -> &'static str {
                match self { $(Friction::$law(_) => concat!("friction law ", stringify!($law))),* }
            }

            /// Whether a memory belongs to this law.
            pub fn owns(&self, memory: &Memory) -> bool {
                matches!((self, memory), $((Friction::$law(_), Memory::$law(_)))|*)
            }

            /// Number of continuous states.
            pub fn states(&self) -> usize {
                match self { $(Friction::$law(law) => law.states()),* }
            }

            /// The events that can end a mode.
            pub fn events(&self) -> &'static [Event] {
                match self { $(Friction::$law(law) => law.events()),* }
            }

            /// How the law holds the mass.
            pub fn stiction(&self) -> Stiction {
                match self { $(Friction::$law(_) => <$type as FrictionLaw>::STICTION),* }
            }

            /// Whether the force changes gently within a mode.
            pub fn is_gentle(&self) -> bool {
                match self { $(Friction::$law(law) => law.is_gentle()),* }
            }

            /// Whether the memory follows the motion under a drive.
            pub fn follows(&self, drive: Drive) -> bool {
                match self { $(Friction::$law(_) => <$type as FrictionLaw>::FOLLOWS.contains(&drive)),* }
            }

            /// What the continuous states are.
            pub fn state_kind(&self) -> StateKind {
                match self { $(Friction::$law(law) => law.state_kind()),* }
            }

            /// Magnitude of the continuous states.
            pub fn state_scale(&self) -> f64 {
                match self { $(Friction::$law(law) => law.state_scale()),* }
            }

            /// Longest step in s the solver may take.
            pub fn max_step(&self) -> f64 {
                match self { $(Friction::$law(law) => law.max_step()),* }
            }

            /// Whether the force depends on time otherwise than through contact and states.
            pub fn depends_on_time(&self) -> bool {
                match self { $(Friction::$law(law) => law.depends_on_time()),* }
            }

            /// What is unusual about the parameters.
            pub fn notice(&self) -> Option<Notice> {
                match self { $(Friction::$law(law) => law.notice()),* }
            }

            /// The memory a run starts with.
            pub fn start(&self, contact: &Contact<f64>) -> Memory {
                match self { $(Friction::$law(law) => Memory::$law(law.start(contact))),* }
            }
        }

        impl Memory {
            /// Whether the law holds the mass.
            pub fn is_sticking(&self) -> bool {
                match self { $(Memory::$law(memory) => <$type as FrictionLaw>::is_sticking(memory)),* }
            }
        }
    };
}

registry! {
    1 None "none" OfVelocity<none::NoFriction>, "No friction";
    2 Coulomb "coulomb" StickSlip<coulomb::Coulomb>, "Constant kinetic friction, true stiction at the same force";
    3 CoulombStiction "coulombStiction" StickSlip<coulomb_stiction::CoulombStiction>, "Coulomb friction with a higher break-away force";
    4 SmoothCoulomb "smoothCoulomb" OfVelocity<smooth_coulomb::SmoothCoulomb>, "Coulomb friction smoothed by a hyperbolic tangent (creeps)";
    5 VelocityBased "velocityBased" OfVelocity<velocity_based::VelocityBased>, "Magic-formula curve through zero with Stribeck peak (creeps)";
    6 StribeckRegularised "stribeckRegularised" OfVelocity<stribeck_regularised::StribeckRegularised>, "Stribeck curve with a linear part through zero (creeps)";
    7 Stribeck "stribeck" stribeck_law::Stribeck, "Stribeck curve with true stiction";
    8 Karnopp "karnopp" karnopp::Karnopp, "Stribeck curve with a zero-velocity band that holds the mass";
    9 Polito "polito" polito::Polito, "Different Stribeck curves while accelerating and decelerating, true stiction";
    10 Dahl "dahl" OneBristle<dahl::Dahl>, "Bristle with rate-independent presliding, no stiction peak";
    11 Bristle "bristle" bristle::Bristle, "Bonds that break and form at random";
    12 ResetIntegrator "resetIntegrator" OneBristle<reset_integrator::ResetIntegrator>, "Bond that yields at a limit, with stiction peak, without drift";
    13 Armstrong "armstrong" armstrong::Armstrong, "Spring while sticking, Stribeck friction with dwell time and delay while sliding";
    14 LuGre "lugre" OneBristle<lugre::LuGre>, "Bristle with presliding, Stribeck effect and frictional lag";
    15 Leuven "leuven" OneBristle<leuven::Leuven>, "Hysteresis with nested loops and non-local memory, blended into a Stribeck curve";
    16 GMS "gms" gms::Gms, "Maxwell-slip elements with Stribeck effect, frictional lag and non-local memory";
    17 MaxwellSlip "maxwellSlip" maxwell_slip::MaxwellSlip, "Spring-slider elements: rate-independent hysteresis without drift";
    18 DNLRX "dnlrx" dnlrx::Dnlrx, "Sampled Maxwell-slip springs through impulse responses";
    19 BlimanSorine "blimanSorine" bliman_sorine::BlimanSorine, "Difference of two Dahl elements: stiction peak as a function of the path";
    20 ElastoPlastic "elastoPlastic" OneBristle<elasto_plastic::ElastoPlastic>, "Bristle with a purely elastic range: presliding without drift, Stribeck effect";
    21 StepRegularised "stepRegularised" OfVelocity<step_regularised::StepRegularised>, "Static peak and kinetic friction as cubic steps of velocity (creeps)";
    22 SineRegularised "sineRegularised" OfVelocity<sine_regularised::SineRegularised>, "Static peak and kinetic friction as half sine waves of velocity (creeps)";
    23 StickSlipSpring "stickSlipSpring" stick_slip_spring::StickSlipSpring, "Spring-damper while sticking, Coulomb friction while sliding";
    24 StickSlipCreep "stickSlipCreep" OneBristle<stick_slip_creep::StickSlipCreep>, "Bounded stiction displacement at low speed, Coulomb friction at high speed";
}

/// All laws: ids, names and summaries.
pub static LAWS: &Enumeration = Law::ENUMERATION;

impl Friction {
    /// The friction force in N; writes the time derivatives of the continuous states.
    pub fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Memory, rates: &mut [S]) -> S {
        dispatch!(self, memory, |law, memory| force(law, contact, z, memory, rates))
    }

    /// Rate in 1/s at which the state of a law that has one relaxes, given the state and its rate.
    pub fn relaxation(&self, contact: &Contact<f64>, state: [f64; 2], memory: &Memory) -> f64 {
        dispatch!(self, memory, |law, memory| law.relaxation(contact, state, memory))
    }

    /// The event indicators in the present mode.
    #[inline(always)]
    pub fn indicators(&self, contact: &Contact<f64>, z: &[f64], memory: &Memory) -> Indicators {
        let mut indicators = Indicators::default();
        dispatch!(self, memory, |law, memory| law.indicators(contact, z, memory, &mut indicators));
        indicators
    }

    /// Handles an event, whose indicator fell below zero.
    pub fn switch(&self, event: Event, contact: &Contact<f64>, velocity: &mut f64, z: &mut [f64], memory: &mut Memory) {
        dispatch!(self, memory, |law, memory| law.switch(event, contact, velocity, z, memory));
    }

    /// Lets the memory follow an accepted step; returns whether the force may have changed.
    pub fn follow(&self, contact: &Contact<f64>, z: &[f64], memory: &mut Memory) -> bool {
        dispatch!(self, memory, |law, memory| law.follow(contact, z, memory))
    }

    /// The next sample.
    pub fn next_sample(&self, memory: &Memory) -> Sample {
        dispatch!(self, memory, |law, memory| law.next_sample(memory))
    }

    /// Takes a sample.
    pub fn sample(&self, contact: &Contact<f64>, z: &[f64], memory: &mut Memory) {
        dispatch!(self, memory, |law, memory| law.sample(contact, z, memory));
    }
}

/// The force of one law: a function of its own, so that a short law does not save the registers that a long one needs.
#[inline(never)]
fn force<L: FrictionLaw, S: Scalar>(law: &L, contact: &Contact<S>, z: &[S], memory: &L::Memory, rates: &mut [S]) -> S {
    law.force(contact, z, memory, rates)
}
