//! Friction laws: one file each, all behind [`FrictionLaw`], listed once in the registry below.
//!
//! A law is given the [`Contact`] (position, velocity, applied force, load level) and answers with the friction
//! force, which is positive when it opposes a positive velocity. What it remembers is of two kinds: continuous
//! states (bristle deflections), integrated by the solver, and a memory (modes, stacks, generators) that only
//! changes at events. Laws know neither models nor solvers; a model may hold several contacts.

pub mod anchored;
pub mod bounded;
pub mod delay;
pub mod elements;
pub mod levels;
pub mod list;
pub mod ramp;
pub mod stick_slip;
pub mod stribeck;

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::scalar::Scalar;
use crate::variables::{Enumeration, ParameterError, ParameterSet, Variable};

/// The largest number of continuous states a law may have.
pub const MAX_STATES: usize = 10;

/// What sets the contact in motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A mass moves under forces; friction can hold it.
    Force,
    /// The velocity is prescribed; friction is only read.
    Motion,
}

/// The contact as a friction law sees it.
#[derive(Clone, Copy, Debug)]
pub struct Contact<S> {
    /// Time in s.
    pub time: S,
    /// Position in m.
    pub position: S,
    /// Relative velocity in m/s.
    pub velocity: S,
    /// Sum of all other forces on the mass in N, positive towards positive velocity.
    pub applied: S,
    /// Load level (1 at rated load), which multiplies every force-valued parameter of the law.
    pub level: S,
    /// Whether the contact is moved by forces or by a prescribed motion.
    pub drive: Drive,
}

/// Event indicators: each is positive (or zero) while the present mode is valid, and an event when it turns negative.
#[derive(Clone, Copy, Debug, Default)]
pub struct Indicators {
    values: [f64; Self::CAPACITY],
    len: usize,
}

impl Indicators {
    /// Few, since they are copied in every step; three contacts under laws with three each and three links need most.
    const CAPACITY: usize = 12;

    /// Appends an indicator.
    pub fn push(&mut self, value: f64) {
        self.values[self.len] = value;
        self.len += 1;
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.len
    }

    /// The indicators, in the order in which they were appended.
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.len]
    }
}

/// A friction law: its parameters and its hybrid equations.
pub trait FrictionLaw: Sized {
    /// What the law remembers apart from its continuous states; changes at events and accepted steps only.
    type Memory: Clone + PartialEq + std::fmt::Debug + Serialize + DeserializeOwned;

    /// The law's parameters, named relative to its group; value references count from 0 and are never reused.
    type Parameters: ParameterSet;

    /// Builds the law.
    ///
    /// # Errors
    /// [`ParameterError`] when values that are legal one by one do not fit together.
    fn new(parameters: Self::Parameters) -> Result<Self, ParameterError>;

    /// Number of continuous states, at most [`MAX_STATES`].
    fn states(&self) -> usize {
        0
    }

    /// Magnitude of the continuous states, for error control.
    fn state_scale(&self) -> f64 {
        1.0
    }

    /// The memory a run starts with; may set the continuous states, which are zero.
    fn start(&self, contact: &Contact<f64>, z: &mut [f64]) -> Self::Memory;

    /// The friction force in N; writes the time derivatives of the continuous states.
    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Self::Memory, rates: &mut [S]) -> S;

    /// Appends the event indicators of the present mode.
    fn indicators(&self, _contact: &Contact<f64>, _z: &[f64], _memory: &Self::Memory, _out: &mut Indicators) {}

    /// Handles the event whose indicator turned negative; may set the velocity (to exactly 0) and the states.
    fn switch(
        &self,
        _event: usize,
        _contact: &Contact<f64>,
        _velocity: &mut f64,
        _z: &mut [f64],
        _memory: &mut Self::Memory,
    ) {
    }

    /// Lets the memory follow an accepted step; must leave the indicators as they are.
    fn follow(&self, _contact: &Contact<f64>, _z: &[f64], _memory: &mut Self::Memory) {}

    /// Time in s at which the law takes its next sample.
    fn next_sample(&self, _memory: &Self::Memory) -> f64 {
        f64::INFINITY
    }

    /// Takes a sample.
    fn sample(&self, _contact: &Contact<f64>, _z: &[f64], _memory: &mut Self::Memory) {}

    /// Longest step in s the solver may take.
    fn max_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether the force depends on time otherwise than through contact and states.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// Whether the law holds the mass (the output `sticking`).
    fn is_sticking(&self, _memory: &Self::Memory) -> bool {
        false
    }

    /// Whether the position is exactly constant, so that the velocity to report is 0.
    fn holds_position(&self, memory: &Self::Memory) -> bool {
        self.is_sticking(memory)
    }
}

/// Makes the enumeration of laws, the parameter table and the dispatch from one line per law.
macro_rules! registry {
    ($($id:literal $law:ident $group:literal $module:ident::$type:ident $summary:literal;)*) => {
        $(pub mod $module;)*

        /// The choice of a friction law; ids are never reused.
        pub static LAWS: Enumeration = Enumeration {
            name: "FrictionLaw",
            description: "Friction law of the contact",
            items: &[$(($id, stringify!($law), $summary)),*],
        };

        /// A friction law chosen at run time.
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "each variant is described by the module it names")]
        pub enum Friction {
            $($law($module::$type)),*
        }

        /// The memory of a friction law chosen at run time.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[allow(missing_docs, reason = "each variant is described by the module it names")]
        #[allow(clippy::large_enum_variant, reason = "made once per run and never moved while stepping")]
        pub enum Memory {
            $($law(<$module::$type as FrictionLaw>::Memory)),*
        }

        /// Runs an expression with the law and its memory, whatever law it is.
        macro_rules! dispatch {
            ($self_:expr, $memory:expr, |$l:ident, $m:ident| $body:expr) => {
                match ($self_, $memory) {
                    $((Friction::$law($l), Memory::$law($m)) => $body,)*
                    _ => unreachable!("the memory of a contact is made by its own law"),
                }
            };
        }

        impl Friction {
            /// Variables of the choice and of every law, in groups below `group`; value references from `base`.
            pub fn table(group: &str, base: u32, default: i32) -> Vec<Variable> {
                let law = Variable::choice(0, "law", &LAWS, default).text("Friction law of the contact");
                let mut table = vec![law.within(group, base)];
                $(table.extend(
                    <<$module::$type as FrictionLaw>::Parameters as ParameterSet>::table()
                        .into_iter()
                        .map(|variable| variable.within(&format!("{group}.{}", $group), base + 100 * $id)),
                );)*
                table
            }

            /// Builds the chosen law from values in the order of the table.
            ///
            /// # Errors
            /// [`ParameterError`] when the values of the chosen law do not fit together.
            pub fn new(values: &[f64], group: &str) -> Result<Self, ParameterError> {
                let mut next = 1;
                $(
                    let end = next + <<$module::$type as FrictionLaw>::Parameters as ParameterSet>::LEN;
                    if values[0] == f64::from($id) {
                        let parameters = ParameterSet::read(&values[next..end]);
                        return <$module::$type as FrictionLaw>::new(parameters)
                            .map(Friction::$law)
                            .map_err(|error| error.within($group).within(group));
                    }
                    next = end;
                )*
                let _ = next;
                Err(ParameterError::new("law", values[0], "it must be one of the items of FrictionLaw").within(group))
            }

            /// Whether a memory belongs to this law.
            pub fn owns(&self, memory: &Memory) -> bool {
                matches!((self, memory), $((Friction::$law(_), Memory::$law(_)))|*)
            }

            /// Number of continuous states.
            pub fn states(&self) -> usize {
                match self { $(Friction::$law(law) => law.states()),* }
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

            /// The memory a run starts with; may set the continuous states.
            pub fn start(&self, contact: &Contact<f64>, z: &mut [f64]) -> Memory {
                match self { $(Friction::$law(law) => Memory::$law(law.start(contact, z))),* }
            }
        }
    };
}

registry! {
    1 None "none" none::NoFriction "No friction";
    2 Coulomb "coulomb" coulomb::Coulomb "Constant kinetic friction, true stiction at the same level";
    3 CoulombStiction "coulombStiction" coulomb_stiction::CoulombStiction "Coulomb friction with a higher break-away force";
    4 SmoothCoulomb "smoothCoulomb" smooth_coulomb::SmoothCoulomb "Coulomb friction smoothed by a hyperbolic tangent (creeps)";
    5 VelocityBased "velocityBased" velocity_based::VelocityBased "Magic-formula curve through zero with Stribeck peak (creeps)";
    6 StribeckRegularised "stribeckRegularised" stribeck_regularised::StribeckRegularised "Stribeck curve with a linear part through zero (creeps)";
    7 Stribeck "stribeck" stribeck_law::Stribeck "Stribeck curve with true stiction";
    8 Karnopp "karnopp" karnopp::Karnopp "Stribeck curve with a zero-velocity band that holds the mass";
    9 Polito "polito" polito::Polito "Different Stribeck curves while accelerating and decelerating, true stiction";
    10 Dahl "dahl" dahl::Dahl "Bristle with rate-independent presliding, no stiction peak";
    11 Bristle "bristle" bristle::Bristle "Bonds that break and form at random";
    12 ResetIntegrator "resetIntegrator" reset_integrator::ResetIntegrator "Bond that yields at a limit, with stiction peak, without drift";
    13 Armstrong "armstrong" armstrong::Armstrong "Spring while sticking, Stribeck friction with dwell time and delay while sliding";
    14 LuGre "lugre" lugre::LuGre "Bristle with presliding, Stribeck effect and frictional lag";
    15 Leuven "leuven" leuven::Leuven "Hysteresis with nested loops and non-local memory, blended into a Stribeck curve";
    16 GMS "gms" gms::Gms "Maxwell-slip elements with Stribeck effect, frictional lag and non-local memory";
    17 MaxwellSlip "maxwellSlip" maxwell_slip::MaxwellSlip "Spring-slider elements: rate-independent hysteresis without drift";
    18 DNLRX "dnlrx" dnlrx::Dnlrx "Sampled Maxwell-slip springs through impulse responses";
    19 BlimanSorine "blimanSorine" bliman_sorine::BlimanSorine "Difference of two Dahl elements: stiction peak as a function of the path";
    20 ElastoPlastic "elastoPlastic" elasto_plastic::ElastoPlastic "Bristle with a purely elastic range: presliding without drift, Stribeck effect";
    21 StepRegularised "stepRegularised" step_regularised::StepRegularised "Static peak and kinetic level as cubic steps of velocity (creeps)";
    22 SineRegularised "sineRegularised" sine_regularised::SineRegularised "Static peak and kinetic level as half sine waves of velocity (creeps)";
    23 StickSlipSpring "stickSlipSpring" stick_slip_spring::StickSlipSpring "Spring-damper while sticking, Coulomb friction while sliding";
    24 StickSlipCreep "stickSlipCreep" stick_slip_creep::StickSlipCreep "Bounded stiction displacement at low speed, Coulomb friction at high speed";
}

impl Friction {
    /// The friction force in N; writes the time derivatives of the continuous states.
    pub fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Memory, rates: &mut [S]) -> S {
        dispatch!(self, memory, |law, memory| law.force(contact, z, memory, rates))
    }

    /// Appends the event indicators of the present mode.
    pub fn indicators(&self, contact: &Contact<f64>, z: &[f64], memory: &Memory, out: &mut Indicators) {
        dispatch!(self, memory, |law, memory| law.indicators(contact, z, memory, out));
    }

    /// Handles the event whose indicator turned negative.
    pub fn switch(&self, event: usize, contact: &Contact<f64>, velocity: &mut f64, z: &mut [f64], memory: &mut Memory) {
        dispatch!(self, memory, |law, memory| law.switch(event, contact, velocity, z, memory));
    }

    /// Lets the memory follow an accepted step; few laws do, and only for them the contact is worked out.
    #[inline(always)]
    pub fn follow(&self, contact: impl Fn() -> Contact<f64>, z: &[f64], memory: &mut Memory) {
        dispatch!(self, memory, |law, memory| law.follow(&contact(), z, memory));
    }

    /// Time in s of the next sample.
    pub fn next_sample(&self, memory: &Memory) -> f64 {
        dispatch!(self, memory, |law, memory| law.next_sample(memory))
    }

    /// Takes a sample.
    pub fn sample(&self, contact: &Contact<f64>, z: &[f64], memory: &mut Memory) {
        dispatch!(self, memory, |law, memory| law.sample(contact, z, memory));
    }

    /// Whether the law holds the mass.
    pub fn is_sticking(&self, memory: &Memory) -> bool {
        dispatch!(self, memory, |law, memory| law.is_sticking(memory))
    }

    /// Whether the position is exactly constant.
    pub fn holds_position(&self, memory: &Memory) -> bool {
        dispatch!(self, memory, |law, memory| law.holds_position(memory))
    }
}
