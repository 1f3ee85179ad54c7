//! Parts: what has states, modes, samples or limits of its own in a model, such as a contact.
//!
//! A model says where its [`Part`] and its memory are, and what it tells it ([`Holds`]); then the defaults of [`System`] ask the
//! part, too. What a model adds of its own it writes in place of a default, and there asks its part by the methods of [`Holds`].

use super::{Indicator, IndicatorSet, Limits, Sample, System};
use crate::numbers::{Scalar, Varying};
use crate::variables::Notice;

/// A part of a model. One without states, events, samples or the like leaves the methods about these out.
pub trait Part: Clone + Send + 'static {
    /// Its discrete state.
    type Memory<S: Varying>;
    /// What the model tells it.
    type Sees<S: Scalar>;

    /// Number of its events.
    const EVENTS: usize = 0;

    /// Descriptions of its events in a group of variables.
    fn indicator_list(_group: &str) -> Vec<Indicator> {
        Vec::new()
    }

    /// Number of its states.
    fn states(&self) -> usize {
        0
    }

    /// The index among `n` states of the model of its state that a variable stands for, if it is integrated.
    fn state_at(&self, _reference: u32, _n: usize) -> Option<usize> {
        None
    }

    /// Writes the magnitudes of its states among those of the model.
    fn write_scales(&self, _scales: &mut [f64]) {}

    /// Writes the limits of its states among those of the model.
    fn write_limits(&self, _limits: &mut [Limits]) {}

    /// Whether any of its modes can end.
    fn has_events(&self) -> bool {
        Self::EVENTS > 0
    }

    /// Name of an event, for messages.
    fn event_name(&self, _event: usize) -> &'static str {
        ""
    }

    /// Writes the event indicators, which are unused before.
    fn write_indicators<S: Varying>(
        &self,
        _sees: &Self::Sees<S>,
        _x: &[S],
        _memory: &Self::Memory<S>,
        _indicators: &mut [S],
    ) {
    }

    /// Handles an event, whose indicator fell below zero.
    fn switch<S: Varying>(&self, _event: usize, _sees: &Self::Sees<S>, _x: &mut [S], _memory: &mut Self::Memory<S>) {}

    /// Whether its memory follows accepted steps; only then the model tells it what it sees.
    fn follows(&self) -> bool {
        false
    }

    /// Lets its memory follow an accepted step; returns whether the derivatives may have changed.
    fn follow<S: Varying>(&self, _sees: &Self::Sees<S>, _x: &[S], _memory: &mut Self::Memory<S>) -> bool {
        false
    }

    /// Its next sample.
    fn next_sample<S: Varying>(&self, _memory: &Self::Memory<S>) -> Sample<S> {
        Sample::never()
    }

    /// Takes the sample that is due at a time in s, if any.
    fn sample<S: Varying>(&self, _time: f64, _sees: &Self::Sees<S>, _x: &[S], _memory: &mut Self::Memory<S>) {}

    /// Longest step in s that the solver may take.
    fn max_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether its equations depend on time other than through what it sees.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// Whether a memory, read from a saved state, can belong to it.
    fn fits<S: Varying>(&self, _memory: &Self::Memory<S>) -> bool {
        true
    }

    /// The choice on which its equations depend most, for messages.
    fn variant(&self) -> &'static str {
        ""
    }

    /// A warning about its parameters.
    fn notice(&self) -> Option<Notice> {
        None
    }
}

/// A row of equal parts, of which some may be absent: they see nothing, and their memories rest.
impl<P: Part, const K: usize> Part for [P; K] {
    type Memory<S: Varying> = [P::Memory<S>; K];
    type Sees<S: Scalar> = [Option<P::Sees<S>>; K];

    const EVENTS: usize = K * P::EVENTS;

    fn indicator_list(group: &str) -> Vec<Indicator> {
        (1..=K).flat_map(|number| P::indicator_list(&group.replacen("[]", &format!("[{number}]"), 1))).collect()
    }

    fn states(&self) -> usize {
        self.iter().map(Part::states).sum()
    }

    fn state_at(&self, reference: u32, n: usize) -> Option<usize> {
        self.iter().find_map(|part| part.state_at(reference, n))
    }

    fn write_scales(&self, scales: &mut [f64]) {
        self.iter().for_each(|part| part.write_scales(scales));
    }

    fn write_limits(&self, limits: &mut [Limits]) {
        self.iter().for_each(|part| part.write_limits(limits));
    }

    fn has_events(&self) -> bool {
        self.iter().any(Part::has_events)
    }

    fn event_name(&self, event: usize) -> &'static str {
        self[event / P::EVENTS].event_name(event % P::EVENTS)
    }

    fn write_indicators<S: Varying>(
        &self,
        sees: &Self::Sees<S>,
        x: &[S],
        memory: &Self::Memory<S>,
        indicators: &mut [S],
    ) {
        for (place, own) in indicators.chunks_mut(P::EVENTS.max(1)).enumerate() {
            let Some(sees) = &sees[place] else { continue };
            self[place].write_indicators(sees, x, &memory[place], own);
        }
    }

    fn switch<S: Varying>(&self, event: usize, sees: &Self::Sees<S>, x: &mut [S], memory: &mut Self::Memory<S>) {
        let place = event / P::EVENTS;
        if let Some(sees) = &sees[place] {
            self[place].switch(event % P::EVENTS, sees, x, &mut memory[place]);
        }
    }

    fn follows(&self) -> bool {
        self.iter().any(Part::follows)
    }

    fn follow<S: Varying>(&self, sees: &Self::Sees<S>, x: &[S], memory: &mut Self::Memory<S>) -> bool {
        let mut has_changed = false;
        for (place, part) in self.iter().enumerate() {
            let Some(sees) = sees[place].as_ref().filter(|_| part.follows()) else { continue };
            has_changed |= part.follow(sees, x, &mut memory[place]);
        }
        has_changed
    }

    fn next_sample<S: Varying>(&self, memory: &Self::Memory<S>) -> Sample<S> {
        self.iter().zip(memory).map(|(part, memory)| part.next_sample(memory)).fold(Sample::never(), Sample::earlier)
    }

    fn sample<S: Varying>(&self, time: f64, sees: &Self::Sees<S>, x: &[S], memory: &mut Self::Memory<S>) {
        for (place, part) in self.iter().enumerate() {
            if let Some(sees) = &sees[place] {
                part.sample(time, sees, x, &mut memory[place]);
            }
        }
    }

    fn max_step(&self) -> f64 {
        self.iter().map(Part::max_step).fold(f64::INFINITY, f64::min)
    }

    fn depends_on_time(&self) -> bool {
        self.iter().any(Part::depends_on_time)
    }

    fn fits<S: Varying>(&self, memory: &Self::Memory<S>) -> bool {
        self.iter().zip(memory).all(|(part, memory)| part.fits(memory))
    }

    fn variant(&self) -> &'static str {
        self.first().map_or("", Part::variant)
    }

    fn notice(&self) -> Option<Notice> {
        self.iter().find_map(Part::notice)
    }
}

/// How a model holds its part: where it and its memory are, and what it sees.
pub trait Holds<E: System<U>, const U: usize>: Copy {
    /// The part.
    type Part: Part;

    /// The group of its variables; `[]` stands for the numbers of a row of parts.
    const GROUP: &'static str;

    /// The part of a model.
    fn part(self, model: &E) -> &Self::Part;

    /// Its memory.
    fn memory<S: Varying>(self, memory: &E::Memory<S>) -> &<Self::Part as Part>::Memory<S>;

    /// Its memory, to change it.
    fn memory_mut<S: Varying>(self, memory: &mut E::Memory<S>) -> &mut <Self::Part as Part>::Memory<S>;

    /// What it sees.
    fn sees<S: Scalar, const N: usize>(
        self,
        model: &E,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &E::Memory<S::Held>,
    ) -> <Self::Part as Part>::Sees<S>;

    /// Number of events of the model itself, which come before those of the part.
    #[inline(always)]
    fn events_before<S: Varying>(self) -> usize {
        E::Indicators::<S>::unused().as_ref().len().saturating_sub(Self::Part::EVENTS)
    }

    /// Descriptions of its events.
    fn indicator_list(self) -> Vec<Indicator> {
        Self::Part::indicator_list(Self::GROUP)
    }

    /// Writes the indicators of its events among those of the model.
    #[inline(always)]
    fn write_indicators<S: Varying, const N: usize>(
        self,
        model: &E,
        (time, x, u): (S, &[S; N], &[S; U]),
        memory: &E::Memory<S>,
        indicators: &mut E::Indicators<S>,
    ) {
        if Self::Part::EVENTS > 0 {
            let own = &mut indicators.as_mut()[self.events_before::<S>()..];
            self.part(model).write_indicators(&self.sees(model, time, x, u, memory), x, self.memory(memory), own);
        }
    }

    /// Handles an event, by its place among its own.
    #[inline(always)]
    fn switch<S: Varying, const N: usize>(
        self,
        model: &E,
        event: usize,
        (time, x, u): (S, &mut [S; N], &[S; U]),
        memory: &mut E::Memory<S>,
    ) {
        let sees = self.sees(model, time, x, u, memory);
        self.part(model).switch(event, &sees, x, self.memory_mut(memory));
    }

    /// Lets its memory follow an accepted step; returns whether the derivatives may have changed.
    #[inline(always)]
    fn follow<S: Varying, const N: usize>(
        self,
        model: &E,
        (time, x, u): (S, &[S; N], &[S; U]),
        memory: &mut E::Memory<S>,
    ) -> bool {
        let part = self.part(model);
        part.follows() && {
            let sees = self.sees(model, time, x, u, memory);
            part.follow(&sees, x, self.memory_mut(memory))
        }
    }

    /// Takes the samples that are due.
    #[inline(always)]
    fn sample<S: Varying, const N: usize>(
        self,
        model: &E,
        (time, x, u): (S, &[S; N], &[S; U]),
        memory: &mut E::Memory<S>,
    ) {
        let (part, now) = (self.part(model), time.value());
        if part.next_sample(self.memory(memory)).time.value() <= now {
            let sees = self.sees(model, time, x, u, memory);
            part.sample(now, &sees, x, self.memory_mut(memory));
        }
    }
}

/// How a model holds the part that [`holds!`](crate::holds) names.
#[derive(Clone, Copy, Debug)]
pub struct Holder;

/// How a model holds no part.
#[derive(Clone, Copy, Debug)]
pub struct NoPart;

impl Part for NoPart {
    type Memory<S: Varying> = [u8; 0];
    type Sees<S: Scalar> = ();
}

impl<E: System<U>, const U: usize> Holds<E, U> for NoPart {
    type Part = Self;

    const GROUP: &'static str = "";

    fn part(self, _: &E) -> &Self {
        &Self
    }

    fn memory<S: Varying>(self, _: &E::Memory<S>) -> &[u8; 0] {
        &[]
    }

    fn memory_mut<S: Varying>(self, _: &mut E::Memory<S>) -> &mut [u8; 0] {
        &mut []
    }

    fn sees<S: Scalar, const N: usize>(self, _: &E, _: S, _: &[S; N], _: &[S; U], _: &E::Memory<S::Held>) {}
}

/// Says how a model holds its part: the generic parameters of the model, the model and its number of inputs, the field of the part
/// and its type, the group of its variables (`[]` stands for the numbers of a row of parts), the place of its memory, and what it sees.
///
/// ```text
/// holds! {
///     [L: FrictionLaw] Slider<L>, 1; friction: FrictionContact<L>, "friction", |memory| memory.friction,
///     |slider, time, x, u, _memory| slider.contact(time, x, &Inputs::read(u))
/// }
/// ```
///
/// The model then has `fn parts() -> impl Holds<Self, 1> { Holder }`.
#[macro_export]
macro_rules! holds {
    (
        [$($generic:tt)*] $model:ty, $inputs:expr; $field:ident: $part:ty, $group:expr, |$all:ident| $memory:expr,
        |$it:ident, $time:ident, $x:ident, $u:ident, $seen:ident| $sees:expr
    ) => {
        impl<$($generic)*> $crate::system::Holds<$model, { $inputs }> for $crate::system::Holder {
            type Part = $part;

            const GROUP: &'static str = $group;

            #[inline(always)]
            fn part(self, model: &$model) -> &$part {
                &model.$field
            }

            #[inline(always)]
            fn memory<S: $crate::numbers::Varying>(
                self,
                $all: &<$model as $crate::system::System<{ $inputs }>>::Memory<S>,
            ) -> &<$part as $crate::system::Part>::Memory<S> {
                &$memory
            }

            #[inline(always)]
            fn memory_mut<S: $crate::numbers::Varying>(
                self,
                $all: &mut <$model as $crate::system::System<{ $inputs }>>::Memory<S>,
            ) -> &mut <$part as $crate::system::Part>::Memory<S> {
                &mut $memory
            }

            #[inline(always)]
            fn sees<S: $crate::numbers::Scalar, const N: usize>(
                self,
                $it: &$model,
                $time: S,
                $x: &[S; N],
                $u: &[S; $inputs],
                $seen: &<$model as $crate::system::System<{ $inputs }>>::Memory<S::Held>,
            ) -> <$part as $crate::system::Part>::Sees<S> {
                $sees
            }
        }
    };
}
