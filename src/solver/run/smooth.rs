//! The linear map of a communication step that lies in smooth regions, from its trail: what small changes at its start come to at its
//! end, with the Jacobians of the equations along the path.

use super::Run;
use crate::numbers::{Real, Scalar, Tangent};
use crate::solver::event::Hermite;
use crate::solver::linear_map::{LinearMap, NODES};
use crate::solver::{array, numbers, values};
use crate::system::{System, rates_by_inputs};

/// The largest error over a stretch, relative to the largest numbers that the columns have had: what a map of order 4 lacks, where this
/// one has order 6.
const ACCURACY: f64 = 1e-6;
/// The most stretches that are tried in a step.
const TRIES: u32 = 64;
/// By how much a stretch may be shorter or longer than the one before, and the share that it takes of the length that the estimate
/// allows.
const SHORTEST: f64 = 0.1;
const LONGEST: f64 = 3.0;
const SAFETY: f64 = 0.9;
/// The largest distance of the rates on the path from those of the equations, times the length of the step and relative to the
/// magnitude of the state.
const STRAY: f64 = 1e-3;

/// The points that a run has passed since the start of a communication step, and the memory there.
#[derive(Clone, Debug)]
pub struct Trail<M, const N: usize> {
    /// Times in s and states at the ends of its steps.
    points: Vec<(f64, [f64; N])>,
    /// The memory at the start.
    pub memory: M,
    /// Events before it.
    events: u64,
}

/// What varies beside states and inputs: numbers of the memory, or parameters of the equations.
pub struct Variation<'a, H: System<U>, const U: usize> {
    /// The equations.
    pub system: &'a H,
    /// The memory, once it has followed the inputs.
    pub memory: Box<H::Memory<Tangent>>,
    /// How many of the directions are used.
    pub directions: usize,
}

/// Places of the inputs that act on something, and what else varies.
type Others<'a, 'v, H, const U: usize> = (&'a [usize], &'a [Variation<'v, H, U>]);

/// A map as far as it has come along a trail.
struct Way<const N: usize> {
    map: LinearMap<N>,
    /// The largest numbers that its columns have had.
    sizes: Vec<f64>,
    /// Length in s of the stretches that have been accurate.
    stretch: f64,
}

impl<M, const N: usize> Trail<M, N> {
    pub(super) fn pass(&mut self, time: f64, x: [f64; N]) {
        self.points.push((time, x));
    }

    /// Time in s and states at the start.
    pub fn start(&self) -> &(f64, [f64; N]) {
        &self.points[0]
    }
}

impl<H: System<U>, const N: usize, const U: usize> Run<H, N, U> {
    /// Leaves a trail from here on.
    pub fn begin_trail(&mut self) {
        let points = vec![(self.time, values(&self.x))];
        self.trail = Some(Box::new(Trail { points, memory: self.memory.clone(), events: self.counters.events }));
    }

    /// Ends the trail, and gives it if there has been no event.
    pub fn end_trail(&mut self) -> Option<Box<Trail<H::Memory<Real>, N>>> {
        self.trail.take().filter(|trail| trail.events == self.counters.events && self.pending.is_none())
    }

    /// The inputs at a time in s of the present communication step.
    pub fn inputs_at(&self, time: f64) -> [f64; U] {
        values(&self.inputs.at(time))
    }

    /// Whether the run is exactly at the limit of a mode, at the point where the communication step has started or here, or a sample is
    /// due or rounded.
    pub fn is_at_a_limit(&self, time: f64, x: &[f64; N], u: &[f64; U]) -> bool {
        let is_there = |time: f64, x: &[f64; N], u: &[f64; U]| {
            let indicators = self.system.indicators(Real::of(time), &numbers(x), &numbers(u), &self.memory);
            !indicators.as_ref().iter().all(|it| it.value > 0.0)
        };
        let sample = self.system.next_sample::<Real>(&self.memory).rounded(self.time, self.start);
        sample.is_due_at(self.time)
            || is_there(time, x, u)
            || is_there(self.time, &values(&self.x), &self.inputs_at(self.time))
            || !self.system.rounded().is_empty()
    }

    /// The map along a trail over which the memory has been the present one: of the states, and of inhomogeneities, which are some inputs
    /// and, behind them, what else varies; in SI units. Nothing where the path has a kink or is too rough.
    pub fn map_along(
        &self,
        trail: &Trail<H::Memory<Real>, N>,
        inputs: &[usize],
        others: &[Variation<H, U>],
    ) -> Option<LinearMap<N>> {
        if !self.settings.is_adaptive() {
            return None;
        }
        let directions = inputs.len() + others.iter().map(|it| it.directions).sum::<usize>();
        let map = LinearMap::identity(directions);
        let mut way = Way { sizes: map.sizes().collect(), map, stretch: f64::INFINITY };
        for pair in trail.points.windows(2) {
            let [(time, start), (end_time, end)] = [&pair[0], &pair[1]];
            let u = [*time, *end_time].map(|time| values(&self.inputs.at(time)));
            if !self.system.is_smooth([start, end], [&u[0], &u[1]], &self.memory, end_time - time) {
                return None;
            }
            let slope = |time: f64, x: &[f64; N]| {
                let x = numbers(x);
                values(&self.system.derivatives(Real::of(time), &x, &self.inputs.at(time), &self.memory))
            };
            let [start_slope, end_slope] = [slope(*time, start), slope(*end_time, end)];
            let path = Hermite { start, start_slope: &start_slope, end, end_slope: &end_slope, h: end_time - time };
            self.go_along(&path, *time, (inputs, others), &mut way)?;
        }
        let (mut map, scales) = (way.map, &self.scales);
        for (column, scale) in map.states.iter_mut().zip(scales) {
            column.iter_mut().zip(scales).for_each(|(entry, row)| *entry *= row / scale);
        }
        for column in &mut map.others {
            column.iter_mut().zip(scales).for_each(|(entry, row)| *entry *= row);
        }
        Some(map)
    }

    /// Goes on over a step, in stretches of about the length that has been accurate before. States and inhomogeneities
    /// are relative to the magnitudes of the states.
    fn go_along(&self, path: &Hermite<N>, time: f64, others: Others<H, U>, way: &mut Way<N>) -> Option<()> {
        let mut from = 0.0;
        for _ in 0..TRIES {
            // In stretches of one length, the last of which ends with the step.
            let parts = ((1.0 - from) * path.h / way.stretch).ceil().max(1.0);
            let length = (1.0 - from) / parts;
            let at = |node: f64| self.coefficients(path, time, from + node * length, others);
            let [first, middle, last] = NODES.map(at);
            let maps = LinearMap::of_stretch(&[first?, middle?, last?], length * path.h);
            let [map, lacking] = maps.map(|part| part.after(&way.map));
            let sizes: Vec<f64> = way.sizes.iter().zip(map.sizes()).map(|(before, here)| before.max(here)).collect();
            let relative = |(lacking, size): (f64, &f64)| if lacking > 0.0 { lacking / size } else { 0.0 };
            let error = lacking.sizes().zip(&sizes).map(relative).fold(0.0, f64::max);
            if !error.is_finite() || sizes.iter().any(|size| size.is_infinite()) {
                return None;
            }
            // The error is of order 5 in the length.
            let change = (SAFETY * libm::pow(ACCURACY / error, 0.2)).clamp(SHORTEST, LONGEST);
            way.stretch = length * path.h * change;
            if error <= ACCURACY {
                (way.map, way.sizes) = (map, sizes);
                if parts == 1.0 {
                    return Some(());
                }
                from += length;
            }
        }
        None
    }

    /// The coefficients at a fraction of a step; nothing where the path strays from the equations.
    fn coefficients(
        &self,
        path: &Hermite<N>,
        time: f64,
        at: f64,
        (inputs, others): Others<H, U>,
    ) -> Option<LinearMap<N>> {
        let (x, time) = (self.between(path, at), time + at * path.h);
        let u = values(&self.inputs.at(time));
        let mut states = [[0.0; N]; N];
        let rates = self.system.jacobian(time, &x, &u, &self.memory, &mut states);
        let (on_path, scales) = (path.rates(at), &self.scales);
        let strays = |i: usize| (rates[i] - on_path[i]).abs() * path.h > STRAY * scales[i];
        if (H::CLOSED_FORM..N).any(strays) {
            return None;
        }
        let mut columns = rates_by_inputs(&self.system, time, &x, &u, &self.memory, inputs);
        for Variation { system, memory, directions } in others {
            let rates = system.derivatives(Tangent::still(time), &numbers(&x), &numbers(&u), memory);
            columns.extend((0..*directions).map(|direction| array::<f64, N>(|i| rates[i].slopes[direction])));
        }
        for (column, scale) in states.iter_mut().zip(scales) {
            column.iter_mut().zip(scales).for_each(|(entry, row)| *entry *= scale / row);
        }
        for column in &mut columns {
            column.iter_mut().zip(scales).for_each(|(entry, row)| *entry /= row);
        }
        Some(LinearMap { states, others: columns })
    }
}
