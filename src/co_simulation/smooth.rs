//! The columns of a transition from the trail of a plain run, where a communication step lies in smooth regions: by one pass over
//! it, however many columns there are.

use std::any::Any;

use super::Simulator;
use super::varied::VariedRun;
use crate::numbers::{DIRECTIONS, Real, STILL, Scalar, Slopes, Tangent};
use crate::sensitivity::{Along, Column, Varied, own_slope};
use crate::solver::{Trail, Variation};
use crate::system::{System, are_alike, slopes_of, varied};

/// What moves a number of the memory, by its place among what varies, and by how much.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    index: usize,
    factor: f64,
}

/// Slopes in two directions whose ratio nothing else has.
fn own_slopes(place: usize) -> Slopes {
    std::array::from_fn(|direction| own_slope(DIRECTIONS * place + direction))
}

impl<E: System<U>, const N: usize, const U: usize> Simulator<E, N, U> {
    /// The columns by states, inputs and numbers of the memory at the start of the step that ends here, and, behind them, by parameters
    /// of runs beside it in as many directions each: of the states and numbers themselves and of outputs, given by their places. Nothing
    /// where a mode, a kink, a sample or a limit is on the way, or where the equations have no derivative, and no columns by parameters
    /// whose run has other states.
    pub(super) fn columns_of_trail(
        &mut self,
        along: &[Along],
        beside: &[(&dyn Varied, usize)],
        outputs: &[usize],
    ) -> Option<Vec<Option<Column>>> {
        let trail = self.run.end_trail()?;
        let of_memory = |it: &Along| if let Along::Memory(place) = it { Some(*place) } else { None };
        let numbers: Vec<usize> = along.iter().filter_map(of_memory).collect();
        let of_input = |it: &Along| if let Along::Input(place) = it { Some(*place).filter(|it| *it < U) } else { None };
        let inputs: Vec<usize> = along.iter().filter_map(of_input).collect();
        let places = self.places_of(along)?;
        let sources = self.sources(&trail, along, &places, &numbers)?;
        let mut variations = self.by_numbers(&numbers);
        let of_numbers = variations.len();
        let by_parameters = self.by_parameters(&trail, beside);
        let is_there: Vec<bool> = by_parameters.iter().map(Option::is_some).collect();
        variations.extend(by_parameters.into_iter().flatten());
        let map = self.run.map_along(&trail, &inputs, &variations)?;
        let rows = self.rows(&inputs, &variations, outputs)?;
        let column = |z: &[f64; N], weights: &[f64], memory: Vec<f64>| {
            let mut end = map.times(z);
            for (column, weight) in map.others.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                end.iter_mut().zip(column).for_each(|(slot, entry)| *slot += entry * weight);
            }
            let product = |row: &Vec<f64>| row.iter().zip(end.iter().chain(weights)).map(|(a, b)| a * b).sum();
            let states = places.iter().flatten().map(|place| end[*place]).collect();
            Column { states, memory, outputs: Ok(rows.iter().map(product).collect()) }
        };
        let still = [0.0; N];
        let mut weights = vec![0.0; map.others.len()];
        let mut columns = Vec::with_capacity(along.len() + map.others.len());
        for (index, it) in along.iter().enumerate() {
            weights.fill(0.0);
            let mut z = still;
            match (it, places[index]) {
                (_, Some(place)) => z[place] = 1.0,
                (Along::Input(input), _) => {
                    if let Some(place) = inputs.iter().position(|other| other == input) {
                        weights[place] = 1.0;
                    }
                }
                _ => (),
            }
            let moved = |source: &Option<Source>| source.filter(|it| it.index == index).map_or(0.0, |it| it.factor);
            let memory: Vec<f64> = sources.iter().map(moved).collect();
            weights[inputs.len()..].iter_mut().zip(&memory).for_each(|(slot, weight)| *slot = *weight);
            columns.push(Some(column(&z, &weights, memory)));
        }
        let (mut place, mut by_parameters) = (inputs.len() + numbers.len(), variations[of_numbers..].iter());
        for ((_, directions), is_there) in beside.iter().zip(is_there) {
            let Some(variation) = is_there.then(|| by_parameters.next()).flatten() else {
                columns.extend(std::iter::repeat_n(None, *directions));
                continue;
            };
            let slopes = slopes_of(&*variation.memory);
            let memory = |direction: usize| numbers.iter().map(|number| slopes[*number][direction]).collect();
            for memory in (0..*directions).map(memory) {
                weights.fill(0.0);
                weights[place] = 1.0;
                columns.push(Some(column(&still, &weights, memory)));
                place += 1;
            }
        }
        Some(columns)
    }

    /// Of each thing that varies, if it is a state, its place among those that are integrated.
    fn places_of(&self, along: &[Along]) -> Option<Vec<Option<usize>>> {
        let references: Vec<_> = self.session.table.states().collect();
        let place = |it: &Along| match it {
            Along::State(number) => self.run.system().state_at(*references.get(*number)?, N).map(Some),
            _ => Some(None),
        };
        along.iter().map(place).collect()
    }

    /// The numbers of the memory, as they vary.
    fn by_numbers(&self, numbers: &[usize]) -> Vec<Variation<'_, E, U>> {
        let (system, memory) = (self.run.system(), self.run.state().1);
        let some = |some: &[usize]| {
            let slopes = |place| std::array::from_fn(|it| f64::from(some.get(it) == Some(&place)));
            Variation { system, memory: Box::new(varied(memory, slopes)), directions: some.len() }
        };
        numbers.chunks(DIRECTIONS).map(some).collect()
    }

    /// The parameters of runs beside this one, as they vary; nothing of a run that has other states, or where the memory has no
    /// derivative.
    fn by_parameters<'a>(
        &self,
        trail: &Trail<E::Memory<Real>, N>,
        beside: &[(&'a dyn Varied, usize)],
    ) -> Vec<Option<Variation<'a, E, U>>> {
        if beside.is_empty() {
            return Vec::new();
        }
        let (time, x) = *trail.start();
        let (x, u) = (x.map(Tangent::still), self.run.inputs_at(time).map(Tangent::still));
        let still: Box<E::Memory<Tangent>> = Box::new(varied(&trail.memory, |_| STILL));
        let vary = |(beside, directions): &(&'a dyn Varied, usize)| {
            let beside: &dyn Any = *beside;
            let system = beside.downcast_ref::<VariedRun<E, N, U>>()?.system();
            let mut memory = still.clone();
            system.follow(Tangent::still(time), &x, &u, &mut memory);
            let is_smooth = slopes_of(&*memory).iter().flatten().all(|slope| slope.is_finite());
            is_smooth.then_some(Variation { system, memory, directions: *directions })
        };
        beside.iter().map(vary).collect()
    }

    /// By which one of the things that vary each number of the memory moves, once the memory has followed the inputs at the start of a
    /// trail. Nothing where several move it, where the memory has changed later on, or where the run is at a limit.
    fn sources(
        &self,
        trail: &Trail<E::Memory<Real>, N>,
        along: &[Along],
        places: &[Option<usize>],
        numbers: &[usize],
    ) -> Option<Vec<Option<Source>>> {
        let (system, (time, x)) = (self.run.system(), *trail.start());
        let (u, mut followed) = (self.run.inputs_at(time), trail.memory.clone());
        system.follow(Real::of(time), &Real::all(&x), &Real::all(&u), &mut followed);
        let is_alike = || followed == trail.memory || are_alike(&trail.memory, &followed);
        if followed != *self.run.state().1 || !is_alike() || self.run.is_at_a_limit(time, &x, &u) {
            return None;
        }
        if numbers.is_empty() {
            return Some(Vec::new());
        }
        let seed = |it: Along| along.iter().position(|other| *other == it).map_or(STILL, own_slopes);
        let mut states = x.map(Tangent::still);
        for (index, place) in places.iter().enumerate() {
            if let Some(place) = place {
                states[*place].slopes = own_slopes(index);
            }
        }
        let inputs = std::array::from_fn(|i| Tangent { value: u[i], slopes: seed(Along::Input(i)) });
        let mut memory: Box<E::Memory<Tangent>> = Box::new(varied(&trail.memory, |place| seed(Along::Memory(place))));
        system.follow(Tangent::still(time), &states, &inputs, &mut memory);
        let slopes = slopes_of(&*memory);
        let source = |place: &usize| {
            let slopes = *slopes.get(*place)?;
            if slopes == STILL {
                return Some(None);
            }
            // The ratio of the two slopes is that of one thing alone.
            let is_it = |index: &usize| {
                let [one, other] = own_slopes(*index);
                (slopes[0] * other - slopes[1] * one).abs() <= 1e-12 * (slopes[0] * other).abs()
            };
            let index = (0..along.len()).find(is_it)?;
            Some(Some(Source { index, factor: slopes[0] / own_slopes(index)[0] }))
        };
        numbers.iter().map(source).collect()
    }

    /// The derivatives of outputs, given by their places, here by states, some inputs and what else varies.
    fn rows(&self, inputs: &[usize], variations: &[Variation<E, U>], outputs: &[usize]) -> Option<Vec<Vec<f64>>> {
        if outputs.is_empty() {
            return Some(Vec::new());
        }
        let (system, time, (x, memory)) = (self.run.system(), self.run.time(), self.run.state());
        let (x, u) = (x.map(Real::value), self.inputs());
        let computed = self.session.table.computed().count();
        let mut rows = vec![Vec::with_capacity(N + inputs.len() + DIRECTIONS * variations.len()); outputs.len()];
        let mut slopes = vec![0.0; computed];
        for direction in (0..N).chain(inputs.iter().map(|input| N + input)) {
            let seed = |place: usize| f64::from(place == direction);
            let seeds = (0.0, &std::array::from_fn(seed), &std::array::from_fn(|input| seed(N + input)));
            self.session.differentiate(system, (time, &x, &u, memory), seeds, &[], &mut slopes);
            rows.iter_mut().zip(outputs).for_each(|(row, place)| row.push(slopes[*place]));
        }
        let mut values = vec![Tangent::still(0.0); computed];
        for Variation { system, memory, directions } in variations {
            system.outputs(Tangent::still(time), &x.map(Tangent::still), &u.map(Tangent::still), memory, &mut values);
            for (row, place) in rows.iter_mut().zip(outputs) {
                row.extend(&values[*place].slopes[..*directions]);
            }
        }
        rows.iter().flatten().all(|slope| slope.is_finite()).then_some(rows)
    }
}
