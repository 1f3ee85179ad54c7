//! A run replayed with numbers that have slopes: internal numerical differentiation.
//!
//! A run leaves a trail of its steps, events and samples. The same methods take the same steps with [`Varied`] numbers, so that
//! what comes out is the derivative of the scheme with its adaptive choices held. At an event with the indicator `g`,
//! `tau = -g'/gdot` and `x+ = switch(x + f-*tau) - f+*tau`, with a `tau` of value 0.

use crate::hybrid::Stride;
use crate::numbers::{Dual, Number, Scalar, Varied};
use crate::solver::{How, Mark, Method, Relaxing};
use crate::system::System;

/// A model whose runs can be replayed.
pub trait Replayed<const U: usize>: System<U> {
    /// The number of the memory that has slopes.
    fn held(&self, memory: &Self::Memory) -> f64;
    /// The same with slopes, after it has followed inputs.
    fn followed<S: Scalar>(&self, u: &[S; U], held: S) -> S;
    /// The states with a closed form in the middle and at the end of a step.
    fn led_of<S: Scalar, const N: usize>(&self, x: &[S; N], held: S, stride: &Stride) -> [[S; 2]; 2];
    /// The rates but for the states with a closed form.
    fn driven_of<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], u: &[S; U], memory: &Self::Memory) -> [S; N];
    /// The indicator of an event; `None` where there is none for such numbers.
    fn indicator_of<S: Scalar, const N: usize>(
        &self,
        event: usize,
        time: S,
        x: &[S; N],
        u: &[S; U],
        memory: &Self::Memory,
    ) -> Option<S>;
    /// What an event does to states; the memory is the one behind it.
    fn switched_of<S: Scalar, const N: usize>(
        &self,
        event: usize,
        time: S,
        x: &mut [S; N],
        u: &[S; U],
        memory: &Self::Memory,
    );
}

/// Why a replay ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// A step of a method, or under inputs, that is not replayed.
    Method,
    /// An event without a derivative.
    Event,
    /// The values are not those of the run.
    Values,
}

/// A replay in `K` directions.
pub struct Replay<H: Replayed<U>, const N: usize, const U: usize, const K: usize> {
    system: H,
    /// Time in s.
    pub time: f64,
    /// States.
    pub x: [Varied<K>; N],
    /// Inputs, which are held.
    pub u: [Varied<K>; U],
    memory: H::Memory,
    /// The number of the memory that has slopes.
    pub held: Varied<K>,
    /// Rates here, if they are known.
    first: Option<[Varied<K>; N]>,
    stride: Stride,
    /// How many states at ends of steps have not had the bits of the run, ends at events aside.
    pub other_bits: usize,
    /// How many steps have been replayed.
    pub steps: usize,
}

impl<H: Replayed<U>, const N: usize, const U: usize, const K: usize> Replay<H, N, U, K> {
    /// A replay of a run from its start, with slopes of its states and inputs, and of its parameters in the system.
    pub fn new(system: H, time: f64, x: [Varied<K>; N], u: [Varied<K>; U], memory: H::Memory) -> Self {
        let held = Varied::of(system.held(&memory));
        let stride = Stride { size: f64::NAN, half: [[0.0; 2]; 2] };
        Self { system, time, x, u, memory, held, first: None, stride, other_bits: 0, steps: 0 }
    }

    /// Holds other inputs from now on. `drives_led_alone`: they act on states with a closed form alone.
    pub fn set_inputs(&mut self, u: [Varied<K>; U], drives_led_alone: bool) {
        self.u = u;
        if !drives_led_alone {
            self.first = None;
        }
    }

    fn values(&self) -> ([f64; N], [f64; U]) {
        (self.x.map(Varied::value), self.u.map(Varied::value))
    }

    /// Does again what a run has done.
    ///
    /// # Errors
    /// [`End`] where it cannot.
    pub fn follow(&mut self, marks: &[Mark]) -> Result<(), End> {
        for (place, mark) in marks.iter().enumerate() {
            match mark {
                Mark::Begins(duration) => {
                    let (_, u) = self.values();
                    self.system.begin(*duration, &u, &mut self.memory);
                }
                Mark::Follows => self.follow_inputs(),
                Mark::Moves { time, end, how } => {
                    let ends_at_event = matches!(marks.get(place + 1), Some(Mark::Switches(_)));
                    self.step(how, *time, end, ends_at_event)?;
                    self.follow_inputs();
                }
                Mark::Switches(event) => self.switch(*event)?,
                Mark::Samples(_) => return Err(End::Method),
                Mark::Arrives => {
                    let (x, u) = self.values();
                    self.system.arrive(self.time, &x, &u, &mut self.memory);
                }
            }
        }
        Ok(())
    }

    fn follow_inputs(&mut self) {
        self.held = self.system.followed(&self.u, self.held);
        let (x, u) = self.values();
        if self.system.follow(self.time, &x, &u, &mut self.memory) {
            self.first = None;
        }
    }

    fn rates(&self, time: f64, x: &[Varied<K>; N]) -> [Varied<K>; N] {
        self.driven(Varied::of(time), x)
    }

    // Compiled once for all stages.
    #[inline(never)]
    fn driven(&self, time: Varied<K>, x: &[Varied<K>; N]) -> [Varied<K>; N] {
        self.system.driven_of(time, x, &self.u, &self.memory)
    }

    fn step(&mut self, how: &How, time: f64, end: &[f64], ends_at_event: bool) -> Result<(), End> {
        if !how.is_led || how.method == Method::Other {
            return Err(End::Method);
        }
        let first = self.first.take().unwrap_or_else(|| self.rates(self.time, &self.x));
        if self.stride.size != how.h {
            self.stride = self.system.stride(how.h);
        }
        let led = self.system.led_of(&self.x, self.held, &self.stride);
        let (mut x, slope) = match how.method {
            Method::Classical => self.classical(&first, how, &led),
            _ => self.midpoint(&first, how, &led),
        };
        if !ends_at_event {
            self.other_bits += x.iter().zip(end).filter(|(own, run)| own.value().to_bits() != run.to_bits()).count();
            self.first = Some(slope);
        }
        // At an event the run takes the cubic in place of the step.
        x.iter_mut().zip(end).for_each(|(own, run)| own.0.value = *run);
        self.x = x;
        self.time = time;
        self.steps += 1;
        Ok(())
    }

    #[inline(always)]
    fn along(&self, step: f64, slope: &[Varied<K>; N]) -> [Varied<K>; N] {
        std::array::from_fn(|i| self.x[i] + slope[i] * step)
    }

    fn classical(
        &self,
        first: &[Varied<K>; N],
        how: &How,
        [middle, last]: &[[Varied<K>; 2]; 2],
    ) -> ([Varied<K>; N], [Varied<K>; N]) {
        let (x, h) = (&self.x, how.h);
        let at = |fraction: f64| self.time + fraction * h;
        let relaxing = how.relaxing.as_ref();
        let drive = |x: &[Varied<K>; N], slope: &[Varied<K>; N]| {
            relaxing.map_or(Varied::zero(), |(state, weights)| weights.drive_of(x[*state], slope[*state]))
        };
        let relaxed = |x: &mut [Varied<K>; N], value: &dyn Fn(usize, &Relaxing) -> Varied<K>| {
            if let Some((state, weights)) = relaxing {
                x[*state] = value(*state, weights);
            }
        };
        let drive_1 = drive(x, first);
        let mut x_2 = self.along(0.5 * h, first);
        x_2[..2].copy_from_slice(middle);
        relaxed(&mut x_2, &|state, weights| weights.second_of(x[state], drive_1));
        let second = self.rates(at(0.5), &x_2);
        let drive_2 = drive(&x_2, &second);
        let mut x_3 = self.along(0.5 * h, &second);
        x_3[..2].copy_from_slice(middle);
        relaxed(&mut x_3, &|state, weights| weights.third_of(x_2[state], [drive_1, drive_2]));
        let third = self.rates(at(0.5), &x_3);
        let drive_3 = drive(&x_3, &third);
        let mut x_4 = self.along(1.0 * h, &third);
        x_4[..2].copy_from_slice(last);
        relaxed(&mut x_4, &|state, weights| weights.fourth_of(x[state], [drive_1, drive_3]));
        let fourth = self.rates(at(1.0), &x_4);
        let drives = [drive_1, drive_2, drive_3, drive(&x_4, &fourth)];
        let sixth = h / 6.0;
        let mut end: [Varied<K>; N] = std::array::from_fn(|i| {
            let (outer, inner) = (first[i] + fourth[i], second[i] + third[i]);
            x[i] + (outer + inner * 2.0) * sixth
        });
        end[..2].copy_from_slice(last);
        relaxed(&mut end, &|state, weights| weights.end_of(x[state], drives));
        let slope = self.rates(at(1.0), &end);
        (end, slope)
    }

    fn midpoint(
        &self,
        first: &[Varied<K>; N],
        how: &How,
        [middle, last]: &[[Varied<K>; 2]; 2],
    ) -> ([Varied<K>; N], [Varied<K>; N]) {
        let (x, h) = (&self.x, how.h);
        let mut x_2 = self.along(0.5 * h, first);
        for i in 0..2 {
            x_2[i] = (x[i] + middle[i] * 4.0 + last[i]) / 6.0;
        }
        let mut drives = None;
        if let Some((state, weights)) = how.relaxing {
            let drive = weights.drive_of(x[state], first[state]);
            x_2[state] = weights.second_of(x[state], drive);
            drives = Some(drive);
        }
        let second = self.rates(self.time + 0.5 * h, &x_2);
        let mut end = self.along(h, &second);
        end[..2].copy_from_slice(last);
        if let (Some((state, weights)), Some(drive)) = (how.relaxing, drives) {
            end[state] = weights.fourth_of(x[state], [drive, weights.drive_of(x_2[state], second[state])]);
        }
        let slope = self.rates(self.time + 1.0 * h, &end);
        (end, slope)
    }

    fn switch(&mut self, event: usize) -> Result<(), End> {
        let (mut x, u) = self.values();
        let before = self.system.rates(self.time, &x, &u, &self.memory);
        let time = Varied::of(self.time);
        let indicator = self.system.indicator_of(event, time, &self.x, &self.u, &self.memory).ok_or(End::Event)?;
        let along: [Dual<1>; N] = std::array::from_fn(|i| Dual { value: x[i], slope: [before[i]] });
        let (now, held) = (Dual::variable(self.time, 0), u.map(Dual::<1>::of));
        let fall = self.system.indicator_of(event, now, &along, &held, &self.memory).ok_or(End::Event)?.slope[0];
        if fall >= 0.0 {
            return Err(End::Event);
        }
        let delay = indicator.0.slope.map(|slope| -slope / fall);
        self.system.switch(event, self.time, &mut x, &u, &mut self.memory);
        let mut states = self.x;
        for (state, rate) in states.iter_mut().zip(before) {
            state.0.slope.iter_mut().zip(delay).for_each(|(slope, delay)| *slope += rate * delay);
        }
        self.system.switched_of(event, time, &mut states, &self.u, &self.memory);
        // Events that this one sets off happen at the same time.
        for _ in 0..100 {
            let indicators = self.system.indicators(self.time, &x, &u, &self.memory);
            let Some(event) = indicators.as_ref().iter().position(|value| *value < 0.0) else { break };
            self.system.switch(event, self.time, &mut x, &u, &mut self.memory);
            self.system.switched_of(event, time, &mut states, &self.u, &self.memory);
        }
        let behind = self.system.rates(self.time, &x, &u, &self.memory);
        for ((state, value), rate) in states.iter_mut().zip(x).zip(behind) {
            state.0.value = value;
            state.0.slope.iter_mut().zip(delay).for_each(|(slope, delay)| *slope -= rate * delay);
        }
        (self.x, self.first) = (states, None);
        Ok(())
    }
}
