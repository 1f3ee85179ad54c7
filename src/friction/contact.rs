//! A friction law in a model: the indices of its states in the model's vector, and its interface to the model.

use std::ops::Range;

use super::event::{Event, Indicators};
use super::law::{Contact, Drive, FrictionLaw, MAX_STATES, StateKind, Stiction};
use super::lubrication::Lubrication;
use super::registry::Friction;
use super::states::{self, Named};
use crate::numbers::{Dual, Real, Scalar, Varying};
use crate::system::{Indicator, Limits, Part, PartFacts, Sample, StateIndex};
use crate::variables::{Notice, Variable};

/// A friction law and the place of its states; a model may hold several.
///
/// It is a [`Part`] of the model, which says how the contact moves and what loads it ([`Contact`]), and keeps a
/// [memory](FrictionLaw::Memory) for each among its own.
#[derive(Clone, Debug)]
pub struct FrictionContact<L = Friction> {
    law: L,
    drive: Drive,
    /// Whether the position is exactly constant while the law holds the mass.
    holds_exactly: bool,
    /// Whether the memory of the law follows the motion.
    follows: bool,
    /// Whether the force changes gently within a mode.
    is_non_stiff: bool,
    /// Whether the law has one state that it does not name, which may relax.
    relaxes: bool,
    /// Whether any mode of the law can end.
    has_events: bool,
    /// Longest step in s the solver may take.
    max_step: f64,
    /// Index of the first state of the law among the states of the model.
    first: usize,
    /// Number of states of the law.
    count: usize,
    /// The velocity among the states of the model.
    velocity: StateIndex,
    /// Factor on the magnitudes of the law's states.
    allowance: f64,
    /// Value reference that the variables of its states count from.
    references: u32,
    /// The place of its named states among the named states of all laws.
    named: Named,
}

impl<L: FrictionLaw> FrictionContact<L> {
    /// A contact under a law, whose states begin at the index `first` of the state vector, whose events may change the velocity,
    /// and whose variables count from the value reference `references`.
    pub fn new(law: L, drive: Drive, first: usize, velocity: StateIndex, references: u32) -> Self {
        let holds_exactly = law.stiction() == Stiction::Exact;
        // Answers that the solver needs at every step are kept, since asking the law takes longer.
        Self {
            drive,
            holds_exactly,
            follows: law.follows().contains(&drive),
            is_non_stiff: law.is_non_stiff(),
            relaxes: law.states() == 1 && law.state_kind() != StateKind::Named,
            has_events: !law.events().is_empty(),
            max_step: law.max_step(),
            count: law.states(),
            named: Named::of(&law),
            law,
            first,
            velocity,
            allowance: 1.0,
            references,
        }
    }

    /// The same with states whose errors may exceed those of other states by a factor.
    pub fn allowing(self, allowance: f64) -> Self {
        Self { allowance, ..self }
    }

    /// The variables of the states of a contact in a group of a model and of their rates, in the order in which
    /// [`Observation::write`] writes them. `base` is the reference from which [`new`](Self::new) counts them: 460 of the first
    /// contact, 40 more for each further one. `sliding` lists the states and inputs that velocity and load factor depend on.
    pub fn variables(group: &str, base: u32, sliding: &[u32]) -> Vec<Variable> {
        states::table::<L>(group, base, [sliding, &[]])
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// Cause of the contact's motion.
    #[inline(always)]
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// Whether the force changes gently within a mode.
    #[inline(always)]
    pub fn is_non_stiff(&self) -> bool {
        self.is_non_stiff
    }

    /// Whether the law has one state that it does not name, which may relax.
    #[inline(always)]
    pub fn relaxes(&self) -> bool {
        self.relaxes
    }

    /// Rate in 1/s at which the state of a law that has one relaxes, given all states and their rates; only for such a law the
    /// contact is worked out.
    #[inline(always)]
    pub fn relaxation_rate<S: Varying>(
        &self,
        contact: impl Fn() -> Contact<S>,
        [x, rates]: [&[S]; 2],
        memory: &L::Memory<S>,
    ) -> f64 {
        if !self.relaxes() {
            return 0.0;
        }
        self.law.relaxation_rate(&contact(), [x[self.first], rates[self.first]], memory)
    }

    /// Stiffness in N/m and damping in N.s/m of the contact at rest, before anything slides, at load factor 1.
    pub fn resistance(&self) -> [f64; 2] {
        let (time, position, velocity, applied, level) = (0.0, 0.0, 0.0, 0.0, 1.0);
        let still = Contact { time, position, velocity, applied, level, drive: self.drive };
        let mut start = [Real::of(0.0); MAX_STATES];
        self.law.start_states(&still.still::<Real>(), &mut start[..self.count]);
        let start = start.map(|state| Dual::<1>::of(state.value));
        let memory = self.law.start(&still.still::<Real>());
        let mut rates = [Dual::<1>::of(0.0); MAX_STATES];
        let mut slope = |contact: Contact<Dual<1>>, states: [Dual<1>; MAX_STATES]| {
            rates.fill(Dual::of(0.0));
            let force = self.law.force(&contact, &states[..self.count], &memory, &mut rates[..self.count]);
            (force.slope[0], rates)
        };
        let unit = Dual::variable(0.0, 0);
        let (damping, bending) = slope(Contact { velocity: unit, ..still.still() }, start);
        let bent = std::array::from_fn(|state| Dual::new(start[state].value, bending[state].slope));
        let (stiffness, _) = slope(Contact { position: unit, ..still.still() }, bent);
        [stiffness, damping]
    }

    /// Indices of the law's states in the state vector.
    #[inline(always)]
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// The memory a run starts with; writes the start values of the law's states, which are zero before, to
    /// the state vector.
    pub fn start<S: Varying>(&self, contact: &Contact<S>, x: &mut [S]) -> L::Memory<S> {
        self.law.start_states(contact, &mut x[self.range()]);
        self.law.start(contact)
    }

    /// Whether the law holds the position.
    #[inline(always)]
    fn is_held<S: Varying>(&self, memory: &L::Memory<S>) -> bool {
        self.holds_exactly && L::is_sticking::<S>(memory)
    }

    /// Velocity of the mass: its state, or 0 where the law holds the position.
    #[inline(always)]
    pub fn rate<S: Scalar>(&self, velocity: S, memory: &L::Memory<S::Held>) -> S {
        if self.is_held::<S::Held>(memory) { S::zero() } else { velocity }
    }

    /// The friction force in N; writes the rates of the law's states.
    #[inline(always)]
    pub fn force<S: Scalar>(&self, contact: &Contact<S>, x: &[S], memory: &L::Memory<S::Held>, rates: &mut [S]) -> S {
        self.law.force(contact, &x[self.range()], memory, &mut rates[self.range()])
    }

    /// The friction force in N of the law in its own states, under factors on Stribeck velocity and viscous friction, if there are
    /// any; writes the rates of the states.
    #[inline(always)]
    pub fn force_on<S: Scalar>(
        &self,
        contact: &Contact<S>,
        lubrication: Option<Lubrication<S>>,
        z: &[S],
        memory: &L::Memory<S::Held>,
        rates: &mut [S],
    ) -> S {
        match lubrication {
            None => self.law.force(contact, z, memory, rates),
            Some(lubrication) => self.law.lubricated_force(contact, lubrication, z, memory, rates),
        }
    }

    /// Outputs of the contact.
    pub fn observe<S: Scalar>(&self, contact: &Contact<S>, x: &[S], memory: &L::Memory<S::Held>) -> Observation<S> {
        self.observe_on(contact, None, x, memory)
    }

    /// Outputs of the contact under factors on Stribeck velocity and viscous friction, if there are any.
    #[inline(always)]
    pub fn observe_on<S: Scalar>(
        &self,
        contact: &Contact<S>,
        lubrication: Option<Lubrication<S>>,
        x: &[S],
        memory: &L::Memory<S::Held>,
    ) -> Observation<S> {
        let mut observation = Observation {
            force: S::zero(),
            sticking: S::constant(f64::from(L::is_sticking::<S::Held>(memory))),
            is_held: self.is_held::<S::Held>(memory),
            kind: self.law.state_kind(),
            named: self.named,
            states: [S::zero(); MAX_STATES],
            rates: [S::zero(); MAX_STATES],
        };
        let states = &x[self.range()];
        observation.states[..self.count].copy_from_slice(states);
        observation.force = self.force_on(contact, lubrication, states, memory, &mut observation.rates[..self.count]);
        observation
    }

    /// Magnitude of the states of a law that does not name them.
    pub fn state_scale(&self) -> f64 {
        self.law.state_scale()
    }
}

impl<L: FrictionLaw> PartFacts for FrictionContact<L> {
    fn states(&self) -> usize {
        self.count
    }

    fn state_at(&self, reference: u32, _n: usize) -> Option<usize> {
        let number = match self.law.state_kind() {
            StateKind::Named => self.named.number_of(self.references, reference)?,
            kind => states::number_of(kind, reference.checked_sub(self.references)?)?,
        };
        (number < self.count).then_some(self.first + number)
    }

    fn write_scales(&self, scales: &mut [f64]) {
        for state in 0..self.count {
            scales[self.first + state] = self.allowance * self.law.scale_of(state);
        }
    }

    fn write_limits(&self, limits: &mut [Limits]) {
        for state in 0..self.named.own() {
            limits[self.first + state] = Limits::within(self.law.range_of(state), self.law.scale_of(state));
        }
    }

    #[inline(always)]
    fn max_step(&self) -> f64 {
        self.max_step
    }

    fn depends_on_time(&self) -> bool {
        self.law.depends_on_time()
    }

    fn variant(&self) -> &'static str {
        self.law.title()
    }

    fn notice(&self) -> Option<Notice> {
        self.law.notice()
    }
}

impl<L: FrictionLaw> Part for FrictionContact<L> {
    type Memory<S: Varying> = L::Memory<S>;
    type Sees<S: Scalar> = Contact<S>;

    const EVENTS: usize = Event::COUNT;

    fn indicator_list(group: &str) -> Vec<Indicator> {
        Event::indicators(group)
    }

    fn has_events(&self) -> bool {
        self.has_events
    }

    fn event_name(&self, event: usize) -> &'static str {
        Event::ALL[event].name()
    }

    #[inline(always)]
    fn write_indicators<S: Varying>(&self, contact: &Contact<S>, x: &[S], memory: &L::Memory<S>, indicators: &mut [S]) {
        let mut own = Indicators::default();
        self.law.indicators(contact, &x[self.range()], memory, &mut own);
        indicators.copy_from_slice(own.as_ref());
    }

    #[inline(always)]
    fn switch<S: Varying>(&self, event: usize, contact: &Contact<S>, x: &mut [S], memory: &mut L::Memory<S>) {
        let velocity = self.velocity.among(x.len());
        let mut rate = x[velocity];
        self.law.switch(Event::ALL[event], contact, &mut rate, &mut x[self.range()], memory);
        x[velocity] = rate;
    }

    #[inline(always)]
    fn follows(&self) -> bool {
        self.follows
    }

    #[inline(always)]
    fn follow<S: Varying>(&self, contact: &Contact<S>, x: &[S], memory: &mut L::Memory<S>) -> bool {
        self.law.follow(contact, &x[self.range()], memory)
    }

    #[inline(always)]
    fn next_sample<S: Varying>(&self, memory: &L::Memory<S>) -> Sample<S> {
        self.law.next_sample::<S>(memory)
    }

    #[inline(always)]
    fn sample<S: Varying>(&self, time: f64, contact: &Contact<S>, x: &mut [S], memory: &mut L::Memory<S>) {
        if self.law.next_sample::<S>(memory).time.value() <= time {
            self.law.sample(contact, &x[self.range()], memory);
        }
    }

    fn fits<S: Varying>(&self, memory: &L::Memory<S>) -> bool {
        self.law.owns::<S>(memory)
    }
}

/// Outputs of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Observation<S> {
    /// The friction force in N.
    pub force: S,
    /// 1 while the law holds the mass, otherwise 0.
    pub sticking: S,
    /// Whether the position is exactly constant.
    pub is_held: bool,
    /// Kind of the states of the law.
    pub kind: StateKind,
    /// The place of its named states among the named states of all laws.
    named: Named,
    /// The states of the law; those it does not have are 0.
    pub states: [S; MAX_STATES],
    /// Their rates.
    pub rates: [S; MAX_STATES],
}

impl<S: Scalar> Observation<S> {
    /// Writes the states and their rates in the order of `states::table`, and returns the rest of the slots.
    pub fn write<'s>(&self, slots: &'s mut [S]) -> &'s mut [S] {
        states::write(self.kind, [self.states, self.rates], self.named, slots)
    }

    /// An acceleration while the mass moves, 0 while the law holds its position.
    pub fn unless_held(&self, acceleration: S) -> S {
        if self.is_held { S::zero() } else { acceleration }
    }
}
