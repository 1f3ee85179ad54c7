//! Models: equations with tables. Nothing here knows how a model is run.
//!
//! | item | contents |
//! |---|---|
//! | [`System`] | a model: its tables, start, rates, events, outputs, and hints for speed |
//! | [`Part`], [`Holds`] | what has states, modes or samples of its own, and how a model holds it |
//! | [`Event`], [`Indicator`], [`Sample`] | ends of modes, and samples: names, indicators, times |
//! | [`Couplings`], [`LongestSteps`], [`ClosedForm`] | speed: zeros of the Jacobian, stable steps, closed forms |
//! | [`Tables`] | the variables of a model |

mod closed_form;
mod couplings;
mod discrete_state;
mod event;
mod held_inputs;
mod hints;
mod indicators;
mod jacobian;
mod limits;
mod longest_steps;
mod part;
mod sample;
mod solving;
mod state_index;
mod tables;

use std::ops::Range;

use serde::{Serialize, de::DeserializeOwned};

pub use self::closed_form::{ClosedForm, Stride};
pub(crate) use self::couplings::bits;
pub use self::couplings::{Couplings, Groups};
pub use self::discrete_state::{LabelledNumber, StateLabel};
#[cfg(feature = "sensitivities")]
pub(crate) use self::discrete_state::{Stilling, are_alike, kept};
pub(crate) use self::discrete_state::{labelled, plain, slopes_of, still, varied};
pub use self::event::Event;
pub(crate) use self::event::assert_sound;
#[doc(hidden)]
pub use self::held_inputs::Held;
pub use self::hints::Hints;
pub use self::indicators::{Indicator, IndicatorSet, UNUSED};
#[cfg(feature = "sensitivities")]
pub(crate) use self::jacobian::rates_by_inputs;
pub(crate) use self::jacobian::{jacobian_by_couplings, jacobian_by_duals};
pub use self::limits::Limits;
pub use self::longest_steps::LongestSteps;
pub use self::part::{Holder, Holds, MemoryOf, NoPart, Part, PartFacts};
pub use self::sample::Sample;
pub use self::solving::{Counters, DEFAULT_TOLERANCE, Scheme, Tuning};
pub use self::state_index::StateIndex;
pub use self::tables::Tables;
pub(crate) use self::tables::{references, shared_table, state_name, table};
use crate::numbers::{Real, Scalar, Varying};
use crate::variables::{Notices, ParameterError, StateSet, Values};

/// Conserved quantities a system can have.
pub const QUANTITIES: usize = 2;

/// The largest number of [kinks](System::kinks) of a model.
pub const MAX_KINKS: usize = 6;

/// All indicators of a model for an importer's solver: of its events, then of its kinks.
pub(crate) fn indicators<E: System<U>, const U: usize>() -> Vec<Indicator> {
    [E::indicator_list(), E::kink_list()].concat()
}

/// A model with `U` inputs: a hybrid system that is built from parameters and shows computed variables.
///
/// Between events the states follow [`derivatives`](Self::derivatives) with a constant memory; a mode is valid while all
/// [indicators](Self::indicators) are positive or zero. A model without events writes the methods that have no default.
///
/// Arrays of states have a length `N` that the library chooses: at least the number of [states](Self::states), and more where
/// a friction law has states. [`states!`](crate::states) knows the place of each.
pub trait System<const U: usize>: Clone + Send + 'static {
    /// The parameters of the model itself, without parts like a friction law.
    type Parameters;

    /// The states of the model itself, made by [`states!`](crate::states).
    type State: StateSet<Self::Parameters>;

    /// The discrete state: modes, stacks, delay lines, generators, everything that changes at events and accepted steps only; `()`
    /// for nothing. What varies little by little with parameters and start values is a number `S`; a side or a count is not.
    type Memory<S: Varying>: Clone + PartialEq + Serialize + DeserializeOwned + Send;

    /// Values of the event indicators, each in a fixed place: an array of as many as there are, `[S; 0]` for none.
    type Indicators<S: Varying>: IndicatorSet<S>;

    /// The events of the model itself, in the order of their indicators. Those of its [parts](Self::parts) follow.
    const EVENTS: &'static [Event] = &[];

    /// Number of inputs of the table, of which the equations read the first `U`.
    const INPUTS: usize = U;

    /// Conserved quantities whose residuals are the last of the computed variables.
    const RESIDUALS: usize = 0;

    /// The variables.
    fn tables() -> Tables;

    /// Builds the equations from the values of the parameters, in the order of the table.
    ///
    /// # Errors
    /// [`ParameterError`] when values that are legal one by one do not fit together.
    fn new(values: &mut Values) -> Result<Self, ParameterError>;

    /// The parameters of the model itself.
    fn parameters(&self) -> &Self::Parameters;

    /// What has states, modes or samples of its own in the model, such as a contact, or a row of contacts: the defaults below
    /// ask these parts, too.
    fn parts() -> impl Holds<Self, U> {
        NoPart
    }

    /// The states and the memory a run starts with, under inputs.
    fn start<S: Varying, const N: usize>(&self, u: &[S; U]) -> ([S; N], Self::Memory<S>);

    /// Time derivatives of the states. They must be smooth functions of the states within a mode. A number of the memory is taken
    /// into an equation by [`S::held`](Scalar::held).
    fn derivatives<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &Self::Memory<S::Held>,
    ) -> [S; N];

    /// Writes the computed variables in the order of the table, but for the residuals.
    fn outputs<S: Scalar, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &Self::Memory<S::Held>,
        computed: &mut [S],
    );

    /// Number of states under these parameters.
    fn states(&self) -> usize {
        Self::State::OTHERS + Self::parts().list(self).map(PartFacts::states).sum::<usize>()
    }

    /// The places among `n` of states that are compiled along, but that nothing uses under these parameters. They are left out
    /// of what is saved, so that a saved state is the same wherever it is taken.
    #[doc(hidden)]
    fn unused(&self, _n: usize) -> Range<usize> {
        0..0
    }

    /// Magnitudes of the states: the solver keeps the error per step of state `i` below
    /// `relative tolerance * max(scale, |x|)`.
    fn scales<const N: usize>(&self) -> [f64; N] {
        let mut scales = [1.0; N];
        Self::parts().list(self).for_each(|part| part.write_scales(&mut scales));
        Self::State::ALL.iter().for_each(|state| scales[state.at(N)] = state.scale(self.parameters()));
        scales
    }

    /// The index among `n` states of the one that a variable stands for, if it is integrated: with other parameters
    /// (another friction law, another rig) it may not be, and keeps its start value.
    fn state_at(&self, reference: u32, n: usize) -> Option<usize> {
        let own = Self::State::of(reference).map(|state| state.at(n));
        own.or_else(|| Self::parts().list(self).find_map(|part| part.state_at(reference, n)))
    }

    /// Descriptions of the indicators, in the order of their indices.
    fn indicator_list() -> Vec<Indicator> {
        Self::EVENTS.iter().map(Event::indicator).chain(Self::parts().indicator_list()).collect()
    }

    /// The event indicators: positive or zero while the present mode is valid, [`UNUSED`] where the mode has no use for them.
    fn indicators<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &Self::Memory<S>,
    ) -> Self::Indicators<S> {
        let mut indicators = Self::Indicators::unused();
        Self::parts().write_indicators(self, (time, x, u), memory, &mut indicators);
        indicators
    }

    /// Handles the event in a place of the indicators, whose value fell below zero.
    fn switch<S: Varying, const N: usize>(
        &self,
        event: usize,
        time: S,
        x: &mut [S; N],
        u: &[S; U],
        memory: &mut Self::Memory<S>,
    ) {
        if let Some(event) = event.checked_sub(Self::parts().events_before::<S>()) {
            Self::parts().switch(self, event, (time, x, u), memory);
        }
    }

    /// Name of the event in a place of the indicators, for messages.
    fn event_name(&self, event: usize) -> &'static str {
        match event.checked_sub(Self::parts().events_before::<Real>()) {
            Some(event) => Self::parts().event_name(self, event),
            None => Self::EVENTS[event].name,
        }
    }

    /// Whether the limit of the event in a place of the indicators is a kink: the event leaves the states as they are, and the
    /// derivatives are equal there in the modes on both sides, as where a spring without preload is touched. A motion that passes
    /// such a limit has slopes even if it grazes it.
    fn is_kink(&self, _event: usize) -> bool {
        false
    }

    /// Whether two discrete states differ in numbers alone, and in modes whose limits are [kinks](Self::is_kink).
    #[cfg(feature = "sensitivities")]
    #[doc(hidden)]
    fn are_alike<S: Varying>(&self, one: &Self::Memory<S>, other: &Self::Memory<S>) -> bool {
        discrete_state::are_alike(one, other)
    }

    /// Descriptions of the kinks of the equations, in the order in which [`kinks`](Self::kinks) writes them: at most
    /// [`MAX_KINKS`].
    fn kink_list() -> Vec<Indicator> {
        Vec::new()
    }

    /// Writes quantities whose signs tell on which side of its kinks the equations are taken, such as what is left of the
    /// way to a stop; [`UNUSED`] where there is none. No mode ends there, and the solver inside takes
    /// no notice; one outside would step over it, so that it sees an indicator that falls to zero on its way to the other side.
    fn kinks<const N: usize>(&self, _x: &[f64; N], _kinks: &mut [f64]) {}

    /// Whether any mode can end: if not, nobody looks at the indicators.
    fn has_events(&self) -> bool {
        Self::parts().events_before::<Real>() > 0 || Self::parts().has_events(self)
    }

    /// Lets the memory follow an accepted step, or a change of the inputs; must leave the indicators as they are. Returns
    /// whether the derivatives may have changed, apart from those that [`update_derivatives`](Self::update_derivatives) renews.
    fn follow<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &mut Self::Memory<S>,
    ) -> bool {
        Self::parts().follow(self, (time, x, u), memory)
    }

    /// Takes notice of a communication step that begins at a time and lasts for a duration, both in s, with its states, its
    /// inputs and their slopes; returns whether the memory may have changed.
    fn begin<S: Varying, const N: usize>(
        &self,
        _span: [f64; 2],
        _x: &[S; N],
        _u: &[S; U],
        _slopes: &[f64; U],
        _memory: &mut Self::Memory<S>,
    ) -> bool {
        false
    }

    /// The next sample of a sampled part.
    fn next_sample<S: Varying>(&self, memory: &Self::Memory<S>) -> Sample<S> {
        Self::parts().next_sample(self, memory)
    }

    /// Takes the samples that are due at a time in s.
    fn sample<S: Varying, const N: usize>(&self, time: S, x: &mut [S; N], u: &[S; U], memory: &mut Self::Memory<S>) {
        Self::parts().sample(self, (time, x, u), memory);
    }

    /// Names of the numbers of the memory that samples round, such as `sensors[1].reading`: they change in jumps, and have no
    /// derivative.
    fn rounded(&self) -> Vec<String> {
        Vec::new()
    }

    /// Label, among the states of a transition, of the number of the memory at a path of fields such as `sensors[1].reading`.
    fn state_label(&self, _fields: &str) -> StateLabel {
        StateLabel::Fields
    }

    /// Takes notice of a communication point at which a run arrives: samples that show there are taken. It must leave
    /// alone all that the equations depend on.
    fn arrive<S: Varying, const N: usize>(&self, time: S, x: &[S; N], u: &[S; U], memory: &mut Self::Memory<S>) {
        Self::parts().arrive(self, (time, x, u), memory);
    }

    /// Longest step in s the solver may take.
    fn max_step(&self) -> f64 {
        Self::parts().list(self).map(PartFacts::max_step).fold(f64::INFINITY, f64::min)
    }

    /// Whether the equations have a meaning at these states (positive pressures, for example).
    ///
    /// # Errors
    /// What has no meaning, as part of a sentence.
    fn admit<const N: usize>(&self, _x: &[f64; N]) -> Result<(), &'static str> {
        Ok(())
    }

    /// Values of the states between which the equations hold for an importer's solver. Beyond them it gets the equations of a
    /// state nearby, which must have a meaning, and is led back: so every state that it tries has an answer, and none that
    /// it accepts may lie where the equations lose their meaning. All states that are admitted and that a run can come to lie
    /// between them.
    fn limits<const N: usize>(&self) -> [Limits; N] {
        let mut limits = self.scales().map(Limits::of_magnitude);
        Self::parts().list(self).for_each(|part| part.write_limits(&mut limits));
        limits
    }

    /// The choice on which the equations depend most, for messages: the friction law, for example.
    fn variant(&self) -> &'static str {
        Self::parts().list(self).map(PartFacts::variant).find(|name| !name.is_empty()).unwrap_or_default()
    }

    /// Whether the equations depend on time other than through the inputs.
    fn depends_on_time(&self) -> bool {
        Self::parts().list(self).any(PartFacts::depends_on_time)
    }

    /// Whether an account of the conserved quantities is kept.
    fn keeps_balance(&self) -> bool {
        false
    }

    /// Content of each conserved quantity; quantities that the system does not have stay 0.
    fn content<S: Varying, const N: usize>(&self, _x: &[S; N], _memory: &Self::Memory<S>) -> [f64; QUANTITIES] {
        [0.0; QUANTITIES]
    }

    /// Inflow of each per second.
    fn inflow<S: Varying, const N: usize>(
        &self,
        _time: S,
        _x: &[S; N],
        _u: &[S; U],
        _memory: &Self::Memory<S>,
    ) -> [f64; QUANTITIES] {
        [0.0; QUANTITIES]
    }

    /// Whether a memory, read from a saved state, can belong to this system.
    fn fits<S: Varying>(&self, memory: &Self::Memory<S>) -> bool {
        Self::parts().fits(self, memory)
    }

    /// Warnings about the parameters and the inputs.
    fn notices(&self, _u: &[f64; U]) -> Notices {
        [Self::parts().list(self).find_map(PartFacts::notice), None, None]
    }

    // Hints for speed. A model may leave all of it out: nothing here changes results, but for rounding and the error that
    // the tolerance allows.
    //
    // Worth on the cylinder, whose plain step takes 4,300 instructions:
    // - `hints` with `is_smooth`: explicit steps in place of implicit ones with their Jacobian, a factor of two to four;
    // - `CLOSED_FORM` with `closed_form` and `derivatives_besides_closed_form`: a fast actuator costs no small steps;
    // - `RELAXING` with `relaxation_rate`: explicit steps for a stiff bristle that slides;
    // - `GROUPS` and `jacobian`: a sparse elimination and fewer directions, a third of an implicit step;
    // - where an input jumps at every step, `update_derivatives` 10 % of a step, `indicators_hold` 4 % (5 % under Polito's law);
    // - where one output is read after each step, `at_hand` 1,400 instructions, a quarter of both.

    /// Which couplings between states the Jacobian has; all of them unless a system says so.
    const GROUPS: Groups = [0, 0];

    /// Hints for the solver in the present mode.
    fn hints<S: Varying, const N: usize>(&self, _x: &[S; N], _memory: &Self::Memory<S>) -> Hints {
        Hints::default()
    }

    /// Number of states, the first ones, that follow the inputs alone, and have a closed form while these are held.
    const CLOSED_FORM: usize = 0;

    /// A state that may relax within a step that is non-stiff otherwise; only where there are more [states](Self::states) than
    /// the model's own, as those of a friction law.
    const RELAXING: Option<StateIndex> = None;

    /// The index among `n` states of one at whose zeros the equations have most of their kinks: a velocity that bends bristles.
    fn turning(&self, _n: usize) -> Option<usize> {
        None
    }

    /// The index among `n` states of one that counts what others do, such as a meter: no rate depends on it. Its error does not
    /// change the steps, so that counting changes nothing else.
    fn counting(&self, _n: usize) -> Option<usize> {
        None
    }

    /// The [derivatives](Self::derivatives) of the states behind the first [`CLOSED_FORM`](Self::CLOSED_FORM), whose own entries are
    /// not used.
    fn derivatives_besides_closed_form<S: Varying, const N: usize>(
        &self,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &Self::Memory<S>,
    ) -> [S; N] {
        self.derivatives(time, x, u, memory)
    }

    /// Time derivatives of the states, and their Jacobian column by column, of which a system may leave out entries that are
    /// always zero: the matrix given is zero at first and written by this system only.
    fn jacobian<S: Varying, const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; U],
        memory: &Self::Memory<S>,
        jacobian: &mut [[f64; N]; N],
    ) -> [f64; N] {
        jacobian_by_duals(self, time, x, u, memory, jacobian)
    }

    /// Whether the indicators stay as they are where the inputs change from the first values to the second, and the memory
    /// follows them.
    fn indicators_hold<S: Varying>(&self, _inputs: [&[S; U]; 2]) -> bool {
        false
    }

    /// Updates derivatives that [`derivatives_besides_closed_form`](Self::derivatives_besides_closed_form) gave at the end of a step,
    /// after the discrete state has followed the step and the inputs have changed from the first values to the second: to the bits of
    /// [`derivatives`](Self::derivatives). Returns `false`, with nothing changed, where an evaluation costs no more.
    fn update_derivatives<S: Varying, const N: usize>(
        &self,
        _x: &[S; N],
        _inputs: [&[S; U]; 2],
        _memory: &Self::Memory<S>,
        _derivatives: &mut [S; N],
    ) -> bool {
        false
    }

    /// Facts for [`closed_form`](Self::closed_form) about a step of a size in s, independent of the states and the inputs.
    fn stride<S: Varying>(&self, size: f64) -> Stride<S> {
        Stride { size, half: [[S::zero(); 2]; 2] }
    }

    /// The states in a step, under inputs that are held and that the memory has followed; of each array the first
    /// [`CLOSED_FORM`](Self::CLOSED_FORM).
    fn closed_form<S: Varying, const N: usize>(
        &self,
        x: &[S; N],
        _u: &[S; U],
        _memory: &Self::Memory<S>,
        _stride: &Stride<S>,
    ) -> ClosedForm<[S; N]> {
        ClosedForm { middle: *x, end: *x, defect: [S::zero(); N] }
    }

    /// Rate constant in 1/s of the [relaxing](Self::RELAXING) state: minus the partial derivative of its rate by the state itself.
    /// An inexact rate constant costs steps, not accuracy. Explicit steps alone call it, after the derivatives were evaluated.
    fn relaxation_rate<S: Varying, const N: usize>(
        &self,
        _time: S,
        _x: &[S; N],
        _rates: &[S; N],
        _u: &[S; U],
        _memory: &Self::Memory<S>,
    ) -> f64 {
        0.0
    }

    /// Whether the equations are smooth, without a kink, along a step of a size in s from the first of these states, with
    /// the first of these inputs, to the second.
    fn is_smooth<S: Varying, const N: usize>(
        &self,
        _x: [&[f64; N]; 2],
        _u: [&[f64; U]; 2],
        _memory: &Self::Memory<S>,
        _step: f64,
    ) -> bool {
        true
    }

    /// The value of a computed variable, given by its place, if it takes no evaluation of the equations: as a rule a
    /// state. It has the bits of [`outputs`](Self::outputs).
    fn at_hand<S: Varying, const N: usize>(&self, _place: usize, _x: &[S; N], _memory: &Self::Memory<S>) -> Option<S> {
        None
    }
}
