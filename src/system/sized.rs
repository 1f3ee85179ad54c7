//! A model as the solver sees it, with a number of states that is known when compiling.

use nalgebra::SMatrix;

use super::{Place, Shortcuts, System, state_name};
use crate::hybrid::{Groups, HybridSystem, Led, LongestSteps, QUANTITIES, Sample, Stride};
use crate::numbers::Scalar;
use crate::variables::StateSet;

/// The index of a state that counts where a friction law has states: with more states than the others.
const fn with_friction(place: Option<Place>, n: usize, others: usize) -> Option<usize> {
    match place {
        Some(place) if n > others => Some(place.among(n)),
        _ => None,
    }
}

impl<E: Shortcuts<U>, const N: usize, const U: usize> HybridSystem<N, U> for E {
    type Memory = <E as System<U>>::Memory;
    type Indicators = <E as System<U>>::Indicators;

    const GROUPS: Groups = E::GROUPS;
    const LED: usize = E::LED;
    const RELAXING: Option<usize> = with_friction(E::RELAXING, N, E::State::OTHERS);
    const TURNING: Option<usize> = with_friction(E::TURNING, N, E::State::OTHERS);

    #[inline(always)]
    fn is_chain(&self) -> bool {
        Shortcuts::is_chain(self)
    }

    #[inline(always)]
    fn derivatives<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; U], memory: &Self::Memory) -> [S; N] {
        System::derivatives(self, time, x, u, memory)
    }

    #[inline(always)]
    fn driven(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> [f64; N] {
        Shortcuts::driven(self, time, x, u, memory)
    }

    #[inline(always)]
    fn jacobian(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; U],
        memory: &Self::Memory,
        jacobian: &mut SMatrix<f64, N, N>,
    ) -> [f64; N] {
        Shortcuts::jacobian(self, time, x, u, memory, jacobian)
    }

    #[inline(always)]
    fn indicators(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> Self::Indicators {
        System::indicators(self, time, x, u, memory)
    }

    #[inline(always)]
    fn has_events(&self) -> bool {
        System::has_events(self)
    }

    #[inline(always)]
    fn switch(&self, event: usize, time: f64, x: &mut [f64; N], u: &[f64; U], memory: &mut Self::Memory) {
        System::switch(self, event, time, x, u, memory);
    }

    #[inline(always)]
    fn indicators_hold(&self, inputs: [&[f64; U]; 2]) -> bool {
        Shortcuts::indicators_hold(self, inputs)
    }

    #[inline(always)]
    fn follow(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &mut Self::Memory) -> bool {
        System::follow(self, time, x, u, memory)
    }

    #[inline(always)]
    fn begin(&self, duration: f64, u: &[f64; U], memory: &mut Self::Memory) -> bool {
        System::begin(self, duration, u, memory)
    }

    #[inline(always)]
    fn next_sample(&self, memory: &Self::Memory) -> Sample {
        System::next_sample(self, memory)
    }

    #[inline(always)]
    fn sample(&self, time: f64, x: &mut [f64; N], u: &[f64; U], memory: &mut Self::Memory) {
        System::sample(self, time, x, u, memory);
    }

    #[inline(always)]
    fn arrive(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &mut Self::Memory) {
        System::arrive(self, time, x, u, memory);
    }

    #[inline(always)]
    fn max_step(&self) -> f64 {
        System::max_step(self)
    }

    #[inline(always)]
    fn admit(&self, x: &[f64; N]) -> Result<(), &'static str> {
        System::admit(self, x)
    }

    fn state_name(&self, state: usize) -> &'static str {
        state_name::<E, U>(self, state, N)
    }

    fn event_name(&self, event: usize) -> &'static str {
        System::event_name(self, event)
    }

    fn variant(&self) -> &'static str {
        System::variant(self)
    }

    #[inline(always)]
    fn refresh(&self, x: &[f64; N], inputs: [&[f64; U]; 2], memory: &Self::Memory, derivatives: &mut [f64; N]) -> bool {
        Shortcuts::refresh(self, x, inputs, memory, derivatives)
    }

    #[inline(always)]
    fn stride(&self, size: f64) -> Stride {
        Shortcuts::stride(self, size)
    }

    #[inline(always)]
    fn led(&self, x: &[f64; N], u: &[f64; U], memory: &Self::Memory, stride: &Stride) -> Led<[f64; N]> {
        Shortcuts::led(self, x, u, memory, stride)
    }

    #[inline(always)]
    fn is_gentle(&self) -> bool {
        Shortcuts::is_gentle(self)
    }

    #[inline(always)]
    fn is_hasty(&self, memory: &Self::Memory) -> bool {
        Shortcuts::is_hasty(self, memory)
    }

    #[inline(always)]
    fn relaxation(&self, time: f64, x: &[f64; N], rates: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> f64 {
        Shortcuts::relaxation(self, time, x, rates, u, memory)
    }

    #[inline(always)]
    fn longest_gentle_steps(&self, x: &[f64; N]) -> LongestSteps {
        Shortcuts::longest_gentle_steps(self, x)
    }

    #[inline(always)]
    fn is_smooth(&self, x: [&[f64; N]; 2], u: [&[f64; U]; 2], memory: &Self::Memory, step: f64) -> bool {
        Shortcuts::is_smooth(self, x, u, memory, step)
    }

    #[inline(always)]
    fn scales(&self) -> [f64; N] {
        System::scales(self)
    }

    #[inline(always)]
    fn content(&self, x: &[f64; N], memory: &Self::Memory) -> [f64; QUANTITIES] {
        System::content(self, x, memory)
    }

    #[inline(always)]
    fn inflow(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> [f64; QUANTITIES] {
        System::inflow(self, time, x, u, memory)
    }

    fn fits(&self, memory: &Self::Memory) -> bool {
        System::fits(self, memory)
    }

    #[inline(always)]
    fn depends_on_time(&self) -> bool {
        System::depends_on_time(self)
    }
}
