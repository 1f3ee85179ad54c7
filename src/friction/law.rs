//! The trait of friction laws: from the state of the contact to the friction force.

use serde::{Serialize, de::DeserializeOwned};

use super::event::{Event, Indicators};
use super::lubrication::Film;
use crate::numbers::{Scalar, Varying};
use crate::system::{Sample, references};
use crate::variables::{Kind, Meaning, Notice, ParameterError, ParameterSet, Tunable, Unit, Variable};

/// The largest number of continuous states a law may have.
pub const MAX_STATES: usize = 10;

/// Kind of the continuous states of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateKind {
    /// A deflection in m.
    Deflection,
    /// Forces in N.
    Force,
    /// The [states](FrictionLaw::STATES) that the law itself names.
    Named,
}

impl StateKind {
    /// The largest number of states of this kind.
    pub const fn most(self) -> usize {
        match self {
            Self::Deflection => 1,
            Self::Force | Self::Named => MAX_STATES,
        }
    }
}

/// A continuous state that a law names: its variable is in the group of the law.
#[derive(Clone, Copy, Debug)]
pub struct LawState<L> {
    pub(super) name: &'static str,
    pub(super) unit: Unit,
    pub(super) scale: fn(&L) -> f64,
    pub(super) range: [f64; 2],
    pub(super) is_alone: bool,
    pub(super) text: &'static str,
}

impl<L> LawState<L> {
    /// A state of a name and a unit, with its magnitude under given parameters, for error control.
    pub const fn new(name: &'static str, unit: Unit, scale: fn(&L) -> f64) -> Self {
        Self { name, unit, scale, range: [f64::NEG_INFINITY, f64::INFINITY], is_alone: false, text: "" }
    }

    /// The values between which the equations of the law have a meaning; a run does not leave them.
    pub const fn range(self, low: f64, high: f64) -> Self {
        Self { range: [low, high], ..self }
    }

    /// A state whose rate depends on the velocity and the state itself: on no other state of the law, nor on the load factor.
    pub const fn alone(self) -> Self {
        Self { is_alone: true, ..self }
    }

    /// Description for an engineer.
    pub const fn text(self, text: &'static str) -> Self {
        Self { text, ..self }
    }
}

/// A state that a law of a catalogue names.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct NamedState {
    /// Id of the law, 0 of one without a catalogue.
    pub law: u32,
    /// Name, in the group of the law.
    pub name: String,
    /// Unit.
    pub unit: Unit,
    /// Description.
    pub text: &'static str,
    /// Whether its rate depends on the other states of the law.
    pub is_coupled: bool,
    /// Whether its rate depends on the velocity and the state itself.
    pub is_alone: bool,
}

/// Cause of the contact's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A mass moves under forces; friction can hold it.
    Force,
    /// The velocity is prescribed; friction is only read.
    Motion,
}

/// Mode in which a law holds the mass at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stiction {
    /// Not at all, or by a bristle that is a state.
    None,
    /// By a spring: while it sticks, the mass still moves.
    Elastic,
    /// Exactly: while it sticks, its position is constant.
    Exact,
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
    /// Load factor `lambda` (1 at rated load), which multiplies every force-valued parameter of the law, or the limits of
    /// its deflections where these stand for forces.
    pub level: S,
    /// Whether the contact is moved by forces or by a prescribed motion.
    pub drive: Drive,
}

impl Contact<f64> {
    /// The same contact in numbers of the equations, none of which varies.
    #[inline(always)]
    pub fn still<S: Scalar>(&self) -> Contact<S> {
        let Self { time, position, velocity, applied, level, drive } = *self;
        let [time, position, velocity, applied, level] = [time, position, velocity, applied, level].map(S::constant);
        Contact { time, position, velocity, applied, level, drive }
    }
}

impl<S: Scalar> Contact<S> {
    /// The same contact in plain numbers.
    #[inline(always)]
    pub fn values(&self) -> Contact<f64> {
        let Self { time, position, velocity, applied, level, drive } = *self;
        let [time, position, velocity, applied, level] = [time, position, velocity, applied, level].map(S::value);
        Contact { time, position, velocity, applied, level, drive }
    }
}

/// The law of a contact as parameters of a model: in the group `friction`, with the law of the id `LAW` chosen at first.
#[derive(Clone, Debug)]
pub struct ContactLaw<L, const LAW: i32>(pub L);

const GROUP: &str = "friction";

impl<L: FrictionLaw, const LAW: i32> ParameterSet for ContactLaw<L, LAW> {
    const LEN: usize = L::LEN;

    fn table() -> Vec<Variable> {
        L::table_within(GROUP, references::FRICTION, LAW)
    }

    fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
        L::read(values).and_then(checked).map(Self).map_err(|error| error.within(GROUP))
    }
}

/// A law whose parameters fit together, and for whose states there is room.
///
/// # Errors
/// [`ParameterError`] when they do not, or when it asks for more states than a contact has of their kind.
#[doc(hidden)]
pub fn checked<L: FrictionLaw>(law: L) -> Result<L, ParameterError> {
    law.check()?;
    let (states, kind) = (law.states(), law.state_kind());
    let refused = |reason: &str| Err(ParameterError::new("states", states as f64, reason));
    // A catalogue names none itself; each of its laws has been checked.
    let names_states = kind == StateKind::Named && L::NAMED > 0;
    let names_all = L::STATES.is_empty() || L::STATES.len() == states;
    if (kind == StateKind::Named || !L::STATES.is_empty()) && !(names_states && names_all) {
        return refused(&format!("the law names {} states in STATES, which is all that it may have", L::STATES.len()));
    }
    if states > kind.most() {
        let [deflections, others] = [StateKind::Deflection, StateKind::Force].map(StateKind::most);
        return refused(&format!(
            "a law may have {deflections} state of the kind Deflection, or {others} of the kind Force or with names"
        ));
    }
    Ok(law)
}

/// A friction law: its parameters and its hybrid equations.
///
/// The parameters are named relative to the group of the law; value references count from 0 and are never reused.
///
/// Simpler laws have simpler traits: [`VelocityLaw`](super::parts::of_velocity::VelocityLaw),
/// [`SetValued`](super::parts::stick_slip::SetValued), [`BristleLaw`](super::parts::one_bristle::BristleLaw).
#[diagnostic::on_unimplemented(
    note = "in a catalogue a `VelocityLaw` is an `OfVelocity<{Self}>`, a `SetValued` law a `StickSlip<{Self}>`, a `BristleLaw` a `OneBristle<{Self}>`"
)]
pub trait FrictionLaw: ParameterSet {
    /// Discrete state of the law; changes at events and accepted steps only. A value that varies continuously with
    /// parameters and start values, such as the position of an anchor, is a number `S`; a side or a count is not.
    type Memory<S: Varying>: Clone + PartialEq + std::fmt::Debug + Serialize + DeserializeOwned + Send;

    /// The continuous states by name, of a law whose states are others than the deflection of a bristle or the forces of elements;
    /// at most [`MAX_STATES`].
    const STATES: &'static [LawState<Self>] = &[];

    /// Number of the named states of all laws of a catalogue.
    #[doc(hidden)]
    const NAMED: usize = Self::STATES.len();

    /// Mode in which the law holds the mass.
    fn stiction(&self) -> Stiction {
        Stiction::None
    }

    /// Whether the law asks the applied force of a sliding mass, too, where others only do at rest. Under a prescribed motion,
    /// which has none, it is then given one beyond all friction, towards the velocity while the speed grows, else against it.
    fn asks_for_applied_force(&self) -> bool {
        false
    }

    /// The drives under which the memory [follows](Self::follow) the motion.
    fn follows(&self) -> &'static [Drive] {
        &[]
    }

    /// The variables of the parameters in a group, with value references from `base`. Of a catalogue the law of an id is
    /// chosen at first, if there is one.
    fn table_within(group: &str, base: u32, default: i32) -> Vec<Variable> {
        let chosen = |variable: Variable| match &variable.kind {
            Kind::Enumeration(laws) if variable.meaning == Some(Meaning::FrictionLaw) && laws.has(default.into()) => {
                Variable { start: Some(default.into()), ..variable }
            }
            _ => variable,
        };
        Self::table().into_iter().map(|variable| chosen(variable).within(group, base)).collect()
    }

    /// Checks that parameters which are legal one by one fit together.
    ///
    /// # Errors
    /// [`ParameterError`] if they do not.
    fn check(&self) -> Result<(), ParameterError> {
        Ok(())
    }

    /// The events that can end a mode of the law under its parameters.
    fn events(&self) -> &'static [Event] {
        &[]
    }

    /// Whether the load factor may depend on the direction of motion. The force must then be continuous where the motion turns, but for
    /// the modes of a set-valued law, and a closed path must take energy: a law whose limits shrink while a spring holds a force beyond
    /// them would give some.
    fn may_differ_by_direction(&self) -> bool {
        false
    }

    /// Whether the law is stuck or slides, without a third mode, and its force while sliding depends on no applied force.
    fn is_set_valued(&self) -> bool {
        false
    }

    /// Whether the law has a Stribeck velocity and a viscous friction that may be multiplied by factors, with a
    /// [force](Self::lubricated_force) for it, and neither decides on its modes.
    fn is_lubricated(&self) -> bool {
        false
    }

    /// Direction, +1 or -1, of a mode that slides: it decides the load factor beyond the velocity 0, where the mode is to end. Nothing at
    /// rest, or of a law without such modes.
    fn sliding_direction<S: Varying>(_memory: &Self::Memory<S>) -> Option<f64> {
        None
    }

    /// Whether the force changes gently with velocity, position and states within a mode: not like a bristle that
    /// settles within microseconds, or a line through zero velocity.
    fn is_non_stiff(&self) -> bool {
        false
    }

    /// Rate in 1/s at which the state of a law that has one, and does not name it, relaxes towards where the motion leads it: minus
    /// the derivative of its own rate by itself, given the state and its rate. It makes steps longer; none is less accurate for it,
    /// nor if it is not exact.
    fn relaxation_rate<S: Varying>(&self, _contact: &Contact<S>, _state: [S; 2], _memory: &Self::Memory<S>) -> f64 {
        0.0
    }

    /// Number of continuous states, at most [`MAX_STATES`].
    fn states(&self) -> usize {
        Self::STATES.len()
    }

    /// Whether the rate of one continuous state depends on others of the law; otherwise each rate depends on its own state, the
    /// motion and the load factor. Several named states count as coupled.
    fn couples_states() -> bool {
        Self::STATES.len() > 1
    }

    /// Kind of the continuous states.
    fn state_kind(&self) -> StateKind {
        if Self::STATES.is_empty() { StateKind::Deflection } else { StateKind::Named }
    }

    /// Magnitude of the continuous states, for error control, of a law that does not name them.
    fn state_scale(&self) -> f64 {
        1.0
    }

    /// Magnitude of one of the continuous states.
    #[doc(hidden)]
    fn scale_of(&self, state: usize) -> f64 {
        Self::STATES.get(state).map_or_else(|| self.state_scale(), |named| (named.scale)(self))
    }

    /// The values between which one of the continuous states has a meaning.
    #[doc(hidden)]
    fn range_of(&self, state: usize) -> [f64; 2] {
        Self::STATES.get(state).map_or([f64::NEG_INFINITY, f64::INFINITY], |named| named.range)
    }

    /// The named states of all laws of a catalogue, of a law with a group of its own and an id.
    #[doc(hidden)]
    fn named_states(group: &str, law: u32) -> Vec<NamedState> {
        let named = |state: &LawState<Self>| NamedState {
            law,
            name: if group.is_empty() { state.name.to_owned() } else { format!("{group}.{}", state.name) },
            unit: state.unit,
            text: state.text,
            is_coupled: Self::couples_states() && !state.is_alone,
            is_alone: state.is_alone,
        };
        Self::STATES.iter().map(named).collect()
    }

    /// Id of the law in its catalogue, 0 without one.
    #[doc(hidden)]
    fn id(&self) -> u32 {
        0
    }

    /// Gives the continuous states, which are zero before, the values that a run starts with.
    fn start_states<S: Varying>(&self, _contact: &Contact<S>, _z: &mut [S]) {}

    /// The memory a run starts with.
    fn start<S: Varying>(&self, contact: &Contact<S>) -> Self::Memory<S>;

    /// The friction force in N; writes the time derivatives of the continuous states, which are zero before. A number of the
    /// memory is taken into the equation by [`S::held`](Scalar::held).
    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &Self::Memory<S::Held>, rates: &mut [S]) -> S;

    /// The same with factors on Stribeck velocity and viscous friction, of a law that [follows](Self::is_lubricated) them; its
    /// [`force`](Self::force) is that with [`Rated`](super::Rated).
    fn lubricated_force<S: Scalar>(
        &self,
        contact: &Contact<S>,
        _film: impl Film<S>,
        z: &[S],
        memory: &Self::Memory<S::Held>,
        rates: &mut [S],
    ) -> S {
        self.force(contact, z, memory, rates)
    }

    /// Sets the event indicators that the present mode uses.
    fn indicators<S: Varying>(
        &self,
        _contact: &Contact<S>,
        _z: &[S],
        _memory: &Self::Memory<S>,
        _out: &mut Indicators<S>,
    ) {
    }

    /// Handles an event, whose indicator fell below zero; may set the velocity (to exactly 0) and the states.
    fn switch<S: Varying>(
        &self,
        _event: Event,
        _contact: &Contact<S>,
        _velocity: &mut S,
        _z: &mut [S],
        _memory: &mut Self::Memory<S>,
    ) {
    }

    /// Lets the memory follow an accepted step; must leave the indicators as they are. Returns whether the force may have
    /// changed.
    fn follow<S: Varying>(&self, _contact: &Contact<S>, _z: &[S], _memory: &mut Self::Memory<S>) -> bool {
        false
    }

    /// The next sample the law takes.
    fn next_sample<S: Varying>(&self, _memory: &Self::Memory<S>) -> Sample<S> {
        Sample::never()
    }

    /// Takes a sample.
    fn sample<S: Varying>(&self, _contact: &Contact<S>, _z: &[S], _memory: &mut Self::Memory<S>) {}

    /// Longest step in s the solver may take.
    fn max_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether the force depends on time otherwise than through contact and states.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// Warning about the parameters.
    fn notice(&self) -> Option<Notice> {
        None
    }

    /// Whether the law holds the mass now (the output `sticking`), if it has any [stiction](Self::stiction).
    fn is_sticking<S: Varying>(_memory: &Self::Memory<S>) -> bool {
        false
    }

    /// The law in words, for messages.
    fn title(&self) -> &'static str {
        ""
    }

    /// Whether a memory, read from a saved state, can belong to this law.
    fn owns<S: Varying>(&self, _memory: &Self::Memory<S>) -> bool {
        true
    }
}
