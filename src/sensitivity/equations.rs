//! The equations of any model behind one interface, so that what carries slopes along is compiled once.

use std::any::Any;

use nalgebra::SMatrix;

use super::leaves::{Leaf, Leaves};
use super::variation::Piece;
use crate::numbers::{Real, Scalar, Tangent};
use crate::session::{Start, build, differentiate_varied, still};
use crate::solver::Counters;
use crate::system::System;

/// What a run does to states and memory at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act {
    /// A communication step of a duration in s begins.
    Begin(f64),
    /// The memory follows.
    Follow,
    /// The event in a place of the indicators happens.
    Switch(usize),
    /// The sample is taken that is `due` at a time in s, in a run that is `now` at another, but for rounding.
    Sample {
        /// When it is due.
        due: f64,
        /// When the run takes it.
        now: f64,
    },
    /// A communication point is reached.
    Arrive,
}

/// A point at which equations are evaluated, but for the memory.
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    /// Time in s.
    pub time: f64,
    /// States.
    pub x: &'a [f64],
    /// Inputs.
    pub u: &'a [f64],
}

/// The equations of a model under some parameters, with a memory.
pub trait Equations: Send {
    /// Those under other parameters, in the order of the table, which vary with slopes or (without any) not at all, with the same
    /// memory; nothing if they do not fit together.
    fn under(&self, parameters: &[f64], slopes: &[f64]) -> Option<Box<dyn Equations>>;
    /// Number of states.
    fn states(&self) -> usize;
    /// Magnitudes of the states.
    fn scales(&self) -> Vec<f64>;
    /// States and memory at the start.
    fn start(&self, u: &[f64]) -> (Vec<f64>, Leaves);
    /// The memory.
    fn memory(&self) -> Leaves;
    /// The same, faster where it is alike another one.
    fn memory_like(&self, other: &Leaves) -> Leaves;
    /// The numbers of the memory, and what all else in it is: the same for memories that are alike.
    fn numbers(&self, numbers: &mut Vec<f64>) -> u64;
    /// The same equations with a memory of their own.
    fn twin(&self) -> Box<dyn Equations>;
    /// The memory as it is held.
    fn held(&self) -> &dyn Any;
    /// Takes on a memory that is held by other equations of the model.
    ///
    /// # Panics
    /// If it is none of this model.
    fn adopt(&mut self, held: &dyn Any);
    /// Whether the memory is another one that is held.
    fn holds(&self, held: &dyn Any) -> bool;
    /// The places among the numbers of the memory of those that are rounded, and so change in jumps.
    fn rounded(&self) -> Vec<usize>;
    /// Takes on another memory: that of other equations of the model, or one with other numbers.
    ///
    /// # Panics
    /// If it is none of this model.
    fn remember(&mut self, memory: &Leaves);
    /// What the numbers of the memory are.
    fn told(&self) -> Vec<Leaf>;
    /// Rates of the states.
    fn rates(&self, at: At) -> Vec<f64>;
    /// Jacobian of the rates, column by column.
    fn jacobian(&self, at: At) -> Vec<f64>;
    /// Writes the derivatives of the rates in a direction of states, inputs and the parameters that vary.
    fn rate_slopes(&self, at: At, direction: (&[f64], &[f64]), slopes: &mut [f64]);
    /// Where all directions, one after the other, are behind a piece of a step, with errors up to weights, and in how many parts that is; nothing if no
    /// number of parts is enough.
    fn cross(&self, piece: &Piece, columns: &[f64], weights: &[f64]) -> Option<(Vec<f64>, u32)>;
    /// The states that follow the inputs alone, a time in s later under held inputs, where they have a closed form.
    fn later(&self, at: At, step: f64) -> Option<Vec<f64>>;
    /// The event indicators.
    fn indicators(&self, at: At) -> Vec<f64>;
    /// Does something to the states and the memory.
    fn enact(&mut self, act: Act, time: f64, x: &mut [f64], u: &[f64]);
    /// The derivatives of the numbers of the memory behind a sample, along the second of the inputs, along slopes of the memory and
    /// the parameters that vary: exactly, with the reason if there are none. Nothing if samples are no formulas here; then they are
    /// differenced.
    fn sample_slopes(&self, _u: [&[f64]; 2], _memory: &[f64]) -> Option<Result<Vec<f64>, String>> {
        None
    }
    /// The derivatives of the computed variables along slopes of the memory and the parameters that vary, where they depend on
    /// nothing else; nothing otherwise.
    fn shown_slopes(&self, _memory: &[f64]) -> Option<Vec<f64>> {
        None
    }
    /// The time in s of the next sample.
    fn next_sample(&self) -> f64;
    /// The name of the event in a place of the indicators.
    fn event_name(&self, event: usize) -> &'static str;
    /// The computed variables, but for residuals and counters.
    fn outputs(&self, at: At) -> Vec<f64>;
    /// Their derivatives in a direction of states, inputs and the parameters that vary.
    fn output_slopes(&self, at: At, direction: (&[f64], &[f64])) -> Vec<f64>;
}

/// The equations of a model with `N` states.
pub struct Erased<E: System<U>, const N: usize, const U: usize> {
    /// The equations.
    pub equations: E,
    /// The memory.
    pub memory: E::Memory<Real>,
    /// Number of all computed variables.
    pub computed: usize,
}

impl<E: System<U>, const N: usize, const U: usize> Erased<E, N, U> {
    /// Number of computed variables without residuals and counters.
    fn own(&self) -> usize {
        self.computed - Counters::COUNT - E::RESIDUALS
    }
}

/// Numbers of the equations in an array.
fn numbers<const N: usize>(values: &[f64]) -> [Real; N] {
    Real::all(&array(values))
}

/// Numbers in an array.
fn array<const N: usize>(numbers: &[f64]) -> [f64; N] {
    let mut array = [0.0; N];
    array.copy_from_slice(numbers);
    array
}

impl<E: System<U>, const N: usize, const U: usize> Equations for Erased<E, N, U> {
    fn under(&self, parameters: &[f64], slopes: &[f64]) -> Option<Box<dyn Equations>> {
        let start = Start { time: 0.0, parameters, inputs: &[0.0; U], tolerance: None };
        let (equations, _) = build::<E, U>(&start, slopes).ok()?;
        Some(Box::new(Self { equations, memory: self.memory.clone(), computed: self.computed }))
    }

    fn states(&self) -> usize {
        N
    }

    fn scales(&self) -> Vec<f64> {
        System::scales::<N>(&self.equations).to_vec()
    }

    fn start(&self, u: &[f64]) -> (Vec<f64>, Leaves) {
        let (x, memory) = System::start::<Real, N>(&self.equations, &numbers(u));
        (x.map(Real::value).to_vec(), Leaves::of(&memory))
    }

    fn memory(&self) -> Leaves {
        Leaves::of(&self.memory)
    }

    fn memory_like(&self, other: &Leaves) -> Leaves {
        Leaves::like(&self.memory, other)
    }

    fn numbers(&self, numbers: &mut Vec<f64>) -> u64 {
        super::leaves::read(&self.memory, numbers)
    }

    fn twin(&self) -> Box<dyn Equations> {
        let Self { equations, memory, computed } = self;
        Box::new(Self { equations: equations.clone(), memory: memory.clone(), computed: *computed })
    }

    fn held(&self) -> &dyn Any {
        &self.memory
    }

    fn adopt(&mut self, held: &dyn Any) {
        self.memory.clone_from(held.downcast_ref().expect("a memory of this model"));
    }

    fn holds(&self, held: &dyn Any) -> bool {
        held.downcast_ref::<E::Memory<Real>>() == Some(&self.memory)
    }

    fn rounded(&self) -> Vec<usize> {
        let rounded = System::rounded(&self.equations);
        if rounded.is_empty() {
            return Vec::new();
        }
        let told = self.told();
        (0..told.len()).filter(|place| rounded.contains(&told[*place].name)).collect()
    }

    fn remember(&mut self, memory: &Leaves) {
        self.memory = memory.memory().expect("a memory of this model");
    }

    fn told(&self) -> Vec<Leaf> {
        super::leaves::told(&self.memory)
    }

    fn rates(&self, At { time, x, u }: At) -> Vec<f64> {
        let rates =
            System::derivatives::<Real, N>(&self.equations, Real::of(time), &numbers(x), &numbers(u), &self.memory);
        rates.map(Real::value).to_vec()
    }

    fn jacobian(&self, At { time, x, u }: At) -> Vec<f64> {
        let mut jacobian = SMatrix::<f64, N, N>::zeros();
        System::jacobian::<Real, N>(&self.equations, time, &array(x), &array(u), &self.memory, &mut jacobian.data.0);
        jacobian.as_slice().to_vec()
    }

    fn rate_slopes(&self, At { time, x, u }: At, (dx, du): (&[f64], &[f64]), slopes: &mut [f64]) {
        let tangent = |value: f64, slope: f64| Tangent { value, slope };
        let x: [Tangent; N] = std::array::from_fn(|i| tangent(x[i], dx[i]));
        let u: [Tangent; U] = std::array::from_fn(|i| tangent(u[i], du[i]));
        let rates = System::derivatives(&self.equations, tangent(time, 0.0), &x, &u, &still(&self.memory));
        slopes.iter_mut().zip(rates).for_each(|(slope, rate)| *slope = rate.slope);
    }

    fn cross(&self, piece: &Piece, columns: &[f64], weights: &[f64]) -> Option<(Vec<f64>, u32)> {
        let is_chain = System::hints::<Real, N>(&self.equations, &[Real::of(0.0); N], &self.memory).is_chain;
        piece.cross::<N>((E::GROUPS, is_chain), columns, weights)
    }

    fn later(&self, At { x, u, .. }: At, step: f64) -> Option<Vec<f64>> {
        if E::LED == 0 || System::hints::<Real, N>(&self.equations, &numbers(x), &self.memory).explicit.is_none() {
            return None;
        }
        let stride = System::stride(&self.equations, step);
        let led = System::led::<Real, N>(&self.equations, &numbers(x), &numbers(u), &self.memory, &stride);
        Some(led.end[..E::LED].iter().map(|number| number.value).collect())
    }

    fn indicators(&self, At { time, x, u }: At) -> Vec<f64> {
        let (time, x, u) = (Real::of(time), numbers(x), numbers(u));
        let indicators = System::indicators::<Real, N>(&self.equations, time, &x, &u, &self.memory);
        indicators.as_ref().iter().map(|number| number.value).collect()
    }

    fn enact(&mut self, act: Act, time: f64, states: &mut [f64], u: &[f64]) {
        let (mut x, u) = (numbers::<N>(states), numbers::<U>(u));
        let (equations, memory) = (&self.equations, &mut self.memory);
        match act {
            Act::Begin(duration) => {
                System::begin(equations, duration, &u, memory);
            }
            Act::Follow => {
                System::follow(equations, Real::of(time), &x, &u, memory);
            }
            Act::Switch(event) => System::switch(equations, event, Real::of(time), &mut x, &u, memory),
            Act::Sample { due, now } => {
                // Where the run is a little earlier or later, it is still due, whatever rounding has to say.
                let due = if time == now { due } else { (due + (time - now)).next_up().next_up().next_up() };
                System::sample(equations, Real::of(due), &mut x, &u, memory);
            }
            Act::Arrive => System::arrive(equations, Real::of(time), &x, &u, memory),
        }
        states.copy_from_slice(&x.map(Real::value));
    }

    fn next_sample(&self) -> f64 {
        System::next_sample::<Real>(&self.equations, &self.memory).time.value
    }

    fn event_name(&self, event: usize) -> &'static str {
        System::event_name(&self.equations, event)
    }

    fn outputs(&self, At { time, x, u }: At) -> Vec<f64> {
        let mut values = vec![Real::of(0.0); self.own()];
        let (x, u) = (numbers::<N>(x), numbers::<U>(u));
        System::outputs(&self.equations, Real::of(time), &x, &u, &self.memory, &mut values);
        values.into_iter().map(Real::value).collect()
    }

    fn output_slopes(&self, At { time, x, u }: At, (dx, du): (&[f64], &[f64])) -> Vec<f64> {
        let mut slopes = vec![0.0; self.computed];
        let at = (time, &array::<N>(x), &array::<U>(u), &self.memory);
        differentiate_varied(&self.equations, at, (0.0, &array(dx), &array(du)), &mut slopes);
        slopes.truncate(self.own());
        slopes
    }
}
