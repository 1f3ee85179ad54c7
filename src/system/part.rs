//! Parts: what has states, modes, samples or limits of its own in a model, such as a contact.
//!
//! A model says where each [`Part`] and its memory are, and what it tells it ([`holds!`](crate::holds)); then the defaults of
//! [`System`] ask the parts, too. What a model adds of its own it writes in place of a default, and there asks its parts by the
//! methods of [`Holds`].

use super::{Indicator, IndicatorSet, Limits, Sample, System};
use crate::numbers::{Scalar, Varying};
use crate::variables::Notice;

/// Facts about a part, which hold for all its memories. A part without states, limits or the like leaves the methods about these
/// out.
pub trait PartFacts {
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

    /// Longest step in s that the solver may take.
    fn max_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether its equations depend on time other than through what it sees.
    fn depends_on_time(&self) -> bool {
        false
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

/// A part of a model. One without events, samples or the like leaves the methods about these out.
pub trait Part: PartFacts + Clone + Send + 'static {
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

    /// Whether its samples are taken on arrival at a communication point, too: they show there, and the equations do not depend on
    /// them.
    const SHOWS: bool = false;

    /// Takes the sample that is due at a time in s, if any.
    fn sample<S: Varying>(&self, _time: f64, _sees: &Self::Sees<S>, _x: &mut [S], _memory: &mut Self::Memory<S>) {}

    /// Whether a memory, read from a saved state, can belong to it.
    fn fits<S: Varying>(&self, _memory: &Self::Memory<S>) -> bool {
        true
    }
}

impl<P: Part, const K: usize> PartFacts for [P; K] {
    fn states(&self) -> usize {
        self.iter().map(PartFacts::states).sum()
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

    fn max_step(&self) -> f64 {
        self.iter().map(PartFacts::max_step).fold(f64::INFINITY, f64::min)
    }

    fn depends_on_time(&self) -> bool {
        self.iter().any(PartFacts::depends_on_time)
    }

    fn variant(&self) -> &'static str {
        self.first().map_or("", PartFacts::variant)
    }

    fn notice(&self) -> Option<Notice> {
        self.iter().find_map(PartFacts::notice)
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

    fn sample<S: Varying>(&self, time: f64, sees: &Self::Sees<S>, x: &mut [S], memory: &mut Self::Memory<S>) {
        for (place, part) in self.iter().enumerate() {
            if let Some(sees) = &sees[place] {
                part.sample(time, sees, x, &mut memory[place]);
            }
        }
    }

    fn fits<S: Varying>(&self, memory: &Self::Memory<S>) -> bool {
        self.iter().zip(memory).all(|(part, memory)| part.fits(memory))
    }
}

/// The memory of a model.
#[doc(hidden)]
pub type MemoryOf<E, const U: usize, S> = <E as System<U>>::Memory<S>;

/// How a model holds its parts, which [`holds!`](crate::holds) says.
pub trait Holds<E: System<U>, const U: usize>: Copy {
    /// Number of their events, which come behind those of the model itself.
    const EVENTS: usize;

    /// Number of events of the model itself.
    #[inline(always)]
    fn events_before<S: Varying>(self) -> usize {
        E::Indicators::<S>::unused().as_ref().len().saturating_sub(Self::EVENTS)
    }

    /// Descriptions of their events.
    fn indicator_list(self) -> Vec<Indicator>;

    /// The parts of a model.
    fn list(self, model: &E) -> impl Iterator<Item = &dyn PartFacts>;

    /// Whether any of their modes can end.
    fn has_events(self, model: &E) -> bool;

    /// Name of an event, by its place among theirs.
    fn event_name(self, model: &E, event: usize) -> &'static str;

    /// Writes the indicators of their events among those of the model.
    fn write_indicators<S: Varying, const N: usize>(
        self,
        model: &E,
        at: (S, &[S; N], &[S; U]),
        memory: &E::Memory<S>,
        indicators: &mut E::Indicators<S>,
    );

    /// Handles an event, by its place among theirs.
    fn switch<S: Varying, const N: usize>(
        self,
        model: &E,
        event: usize,
        at: (S, &mut [S; N], &[S; U]),
        memory: &mut E::Memory<S>,
    );

    /// Lets their memories follow an accepted step; returns whether the derivatives may have changed.
    fn follow<S: Varying, const N: usize>(
        self,
        model: &E,
        at: (S, &[S; N], &[S; U]),
        memory: &mut E::Memory<S>,
    ) -> bool;

    /// The next sample of any of them.
    fn next_sample<S: Varying>(self, model: &E, memory: &E::Memory<S>) -> Sample<S>;

    /// Takes the sample of the part whose sample is the next; others at the same time are the next ones then.
    fn sample<S: Varying, const N: usize>(self, model: &E, at: (S, &mut [S; N], &[S; U]), memory: &mut E::Memory<S>);

    /// Takes the samples that are due at a communication point and [show](Part::SHOWS) there.
    fn arrive<S: Varying, const N: usize>(self, model: &E, at: (S, &[S; N], &[S; U]), memory: &mut E::Memory<S>);

    /// Whether memories, read from a saved state, can belong to them.
    fn fits<S: Varying>(self, model: &E, memory: &E::Memory<S>) -> bool;
}

/// How a model holds the parts that [`holds!`](crate::holds) lists.
#[derive(Clone, Copy, Debug)]
pub struct Holder;

/// How a model holds no part.
#[derive(Clone, Copy, Debug)]
pub struct NoPart;

crate::holds! { @by NoPart; [E: System<U>, const U: usize] E, U; |model, time, x, u, memory| }

/// Lists the parts of a model: the generic parameters of the model, the model and its number of inputs; then of each part its field
/// and its type, the group of its variables (`[]` stands for the numbers of a row of parts), the place of its memory, and what it
/// sees.
///
/// ```text
/// holds! {
///     [L: FrictionLaw] Slider<L>, 1; |slider, time, x, u, memory|
///     friction: FrictionContact<L>, "friction", memory.friction, slider.contact(time, x, &Inputs::read(u));
/// }
/// ```
///
/// The model then has `fn parts() -> impl Holds<Self, 1> { Holder }`. A condition in brackets before a part, a constant, says where
/// it may have memories that follow steps, or samples; without it, it always may.
#[macro_export]
macro_rules! holds {
    (@sees $part:ty, [$($name:ident),*], $sees:expr) => {{
        $(let $name = &*$name;)*
        let sees: <$part as Part>::Sees<S> = $sees;
        sees
    }};
    (
        @by $holder:ty; [$($generic:tt)*] $model:ty, $inputs:expr;
        |$it:ident, $time:ident, $x:ident, $u:ident, $all:ident|
        $($([$is_used:expr])? $($field:ident).+: $part:ty, $group:expr, $memory:expr, $sees:expr;)*
    ) => {
        #[allow(unused, reason = "a model may have no part, and a part see nothing")]
        const _: () = {
            use $crate::numbers::Varying;
            use $crate::system::{Holds, Indicator, MemoryOf, Part, PartFacts, Sample, System};

            impl<$($generic)*> Holds<$model, { $inputs }> for $holder {
                const EVENTS: usize = 0 $(+ <$part as Part>::EVENTS)*;

                fn indicator_list(self) -> Vec<Indicator> {
                    let lists: &[Vec<Indicator>] = &[$(<$part as Part>::indicator_list($group)),*];
                    lists.concat()
                }

                #[inline(always)]
                fn list(self, $it: &$model) -> impl Iterator<Item = &dyn PartFacts> {
                    [$(&$it.$($field).+ as &dyn PartFacts),*].into_iter()
                }

                #[inline(always)]
                fn has_events(self, $it: &$model) -> bool {
                    false $(|| Part::has_events(&$it.$($field).+))*
                }

                fn event_name(self, $it: &$model, event: usize) -> &'static str {
                    $(let Some(event) = event.checked_sub(<$part as Part>::EVENTS) else {
                        return Part::event_name(&$it.$($field).+, event);
                    };)*
                    ""
                }

                #[inline(always)]
                fn write_indicators<S: Varying, const N: usize>(
                    self,
                    $it: &$model,
                    ($time, $x, $u): (S, &[S; N], &[S; $inputs]),
                    $all: &MemoryOf<$model, { $inputs }, S>,
                    indicators: &mut <$model as System<{ $inputs }>>::Indicators<S>,
                ) {
                    let before = Holds::<$model, { $inputs }>::events_before::<S>(self);
                    let rest = &mut indicators.as_mut()[before..];
                    $(let (own, rest) = rest.split_at_mut(<$part as Part>::EVENTS);
                    if !own.is_empty() {
                        let sees = $crate::holds!(@sees $part, [], $sees);
                        Part::write_indicators(&$it.$($field).+, &sees, $x, &$memory, own);
                    })*
                }

                #[inline(always)]
                fn switch<S: Varying, const N: usize>(
                    self,
                    $it: &$model,
                    event: usize,
                    ($time, $x, $u): (S, &mut [S; N], &[S; $inputs]),
                    $all: &mut MemoryOf<$model, { $inputs }, S>,
                ) {
                    $(let Some(event) = event.checked_sub(<$part as Part>::EVENTS) else {
                        let sees = $crate::holds!(@sees $part, [$x, $all], $sees);
                        return Part::switch(&$it.$($field).+, event, &sees, $x, &mut $memory);
                    };)*
                }

                #[inline(always)]
                fn follow<S: Varying, const N: usize>(
                    self,
                    $it: &$model,
                    ($time, $x, $u): (S, &[S; N], &[S; $inputs]),
                    $all: &mut MemoryOf<$model, { $inputs }, S>,
                ) -> bool {
                    let mut has_changed = false;
                    $(if $($is_used &&)? Part::follows(&$it.$($field).+) {
                        let sees = $crate::holds!(@sees $part, [$all], $sees);
                        has_changed |= Part::follow(&$it.$($field).+, &sees, $x, &mut $memory);
                    })*
                    has_changed
                }

                #[inline(always)]
                fn next_sample<S: Varying>(
                    self,
                    $it: &$model,
                    $all: &MemoryOf<$model, { $inputs }, S>,
                ) -> Sample<S> {
                    let mut next = Sample::never();
                    $(if $($is_used &&)? true {
                        next = next.earlier(Part::next_sample::<S>(&$it.$($field).+, &$memory));
                    })*
                    next
                }

                #[inline(always)]
                fn sample<S: Varying, const N: usize>(
                    self,
                    $it: &$model,
                    ($time, $x, $u): (S, &mut [S; N], &[S; $inputs]),
                    $all: &mut MemoryOf<$model, { $inputs }, S>,
                ) {
                    let next = Holds::<$model, { $inputs }>::next_sample::<S>(self, $it, $all);
                    $(if $($is_used &&)? Part::next_sample::<S>(&$it.$($field).+, &$memory) == next {
                        let sees = $crate::holds!(@sees $part, [$x, $all], $sees);
                        return Part::sample(&$it.$($field).+, $time.value(), &sees, $x, &mut $memory);
                    })*
                }

                #[inline(always)]
                fn arrive<S: Varying, const N: usize>(
                    self,
                    $it: &$model,
                    ($time, $x, $u): (S, &[S; N], &[S; $inputs]),
                    $all: &mut MemoryOf<$model, { $inputs }, S>,
                ) {
                    $(if $($is_used &&)? <$part as Part>::SHOWS
                        && Part::next_sample::<S>(&$it.$($field).+, &$memory).is_due_at($time.value())
                    {
                        let sees = $crate::holds!(@sees $part, [$all], $sees);
                        Part::sample(&$it.$($field).+, $time.value(), &sees, &mut $x.clone(), &mut $memory);
                    })*
                }

                fn fits<S: Varying>(self, $it: &$model, $all: &MemoryOf<$model, { $inputs }, S>) -> bool {
                    true $(&& Part::fits::<S>(&$it.$($field).+, &$memory))*
                }
            }
        };
    };
    ($($parts:tt)*) => { $crate::holds! { @by $crate::system::Holder; $($parts)* } };
}
