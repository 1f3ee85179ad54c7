//! The columns of a transition from the trail of a plain run, where a communication step lies in smooth regions: by one pass over
//! it, however many columns there are.

use super::{Simulation, Simulator};
use crate::numbers::{DIRECTIONS, Real, STILL, Scalar, Slopes, Tangent};
use crate::sensitivity::{Along, Column, own_slope};
use crate::solver::Trail;
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
    /// The columns by states, inputs and numbers of the memory at the start of the step that ends here: of the states and numbers
    /// themselves and of outputs, given by their places. Nothing where a mode, a kink, a sample or a limit is on the way, or where the
    /// equations have no derivative.
    pub(super) fn columns_of_trail(&mut self, along: &[Along], outputs: &[usize]) -> Option<Vec<Column>> {
        let trail = self.run.end_trail()?;
        let of_memory = |it: &Along| if let Along::Memory(place) = it { Some(*place) } else { None };
        let numbers: Vec<usize> = along.iter().filter_map(of_memory).collect();
        let sources = self.sources(&trail, along, &numbers)?;
        let pairs = |pair: &[usize]| {
            let slopes = |place| std::array::from_fn(|it| f64::from(pair.get(it) == Some(&place)));
            Box::new(varied(self.run.state().1, slopes))
        };
        let varied: Vec<Box<E::Memory<Tangent>>> = numbers.chunks(DIRECTIONS).map(pairs).collect();
        let map = self.run.map_along(&trail, &varied, numbers.len())?;
        let rows = self.rows(&varied, numbers.len(), outputs)?;
        let mut places = Vec::with_capacity(N);
        for it in along {
            if let Along::State(number) = it {
                places.push(self.state_index(*number)?);
            }
        }
        let column = |(index, it): (usize, &Along)| {
            let mut weights = vec![0.0; U + numbers.len()];
            let mut z = [0.0; N];
            match it {
                Along::State(number) => z[self.state_index(*number)?] = 1.0,
                Along::Input(input) if *input < U => weights[*input] = 1.0,
                _ => (),
            }
            let moved = |source: &Option<Source>| source.filter(|it| it.index == index).map_or(0.0, |it| it.factor);
            let handed_on = sources.iter().map(moved);
            weights[U..].iter_mut().zip(handed_on).for_each(|(slot, weight)| *slot = weight);
            let mut end = map.times(&z);
            for (column, weight) in map.others.iter().zip(&weights).filter(|(_, weight)| **weight != 0.0) {
                end.iter_mut().zip(column).for_each(|(slot, entry)| *slot += entry * weight);
            }
            let product = |row: &Vec<f64>| row.iter().zip(end.iter().chain(&weights)).map(|(a, b)| a * b).sum();
            Some(Column {
                states: places.iter().map(|place| end[*place]).collect(),
                memory: weights[U..].to_vec(),
                outputs: Ok(rows.iter().map(product).collect()),
            })
        };
        along.iter().enumerate().map(column).collect()
    }

    /// By which one of the things that vary each number of the memory moves, once the memory has followed the inputs at the start of a
    /// trail. Nothing where several move it, where the memory has changed later on, or where the run is at a limit.
    fn sources(
        &self,
        trail: &Trail<E::Memory<Real>, N>,
        along: &[Along],
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
        for it in along {
            if let Along::State(number) = it {
                states[self.state_index(*number)?].slopes = seed(*it);
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

    /// The derivatives of outputs, given by their places, here by states, inputs and numbers of the memory.
    fn rows(&self, varied: &[Box<E::Memory<Tangent>>], count: usize, outputs: &[usize]) -> Option<Vec<Vec<f64>>> {
        if outputs.is_empty() {
            return Some(Vec::new());
        }
        let (system, time, (x, memory)) = (self.run.system(), self.run.time(), self.run.state());
        let (x, u) = (x.map(Real::value), self.inputs());
        let computed = self.session.table.computed().count();
        let mut rows = vec![Vec::with_capacity(N + U + count); outputs.len()];
        let mut slopes = vec![0.0; computed];
        for direction in 0..N + U {
            let seed = |place: usize| f64::from(place == direction);
            let seeds = (0.0, &std::array::from_fn(seed), &std::array::from_fn(|input| seed(N + input)));
            self.session.differentiate(system, (time, &x, &u, memory), seeds, &[], &mut slopes);
            rows.iter_mut().zip(outputs).for_each(|(row, place)| row.push(slopes[*place]));
        }
        let mut values = vec![Tangent::still(0.0); computed];
        for memory in varied {
            system.outputs(Tangent::still(time), &x.map(Tangent::still), &u.map(Tangent::still), memory, &mut values);
            for (row, place) in rows.iter_mut().zip(outputs) {
                row.extend(values[*place].slopes);
            }
        }
        rows.iter_mut().for_each(|row| row.truncate(N + U + count));
        rows.iter().flatten().all(|slope| slope.is_finite()).then_some(rows)
    }
}
