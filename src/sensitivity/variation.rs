//! The linear equations that small changes of a run follow along it.
//!
//! ```text
//! dS/dt = J(t)*S + b(t)
//! ```
//!
//! `J` is the Jacobian of the rates along the run and `b` what a direction does to them besides. Over a piece of a step in
//! which both are smooth they are the parabolas through their values at its start, its middle and its end, or the quartics through
//! these and the quarters: the error of that is, as that of the rules of Simpson and Boole, of fifth or seventh order in the
//! length of the piece. The method is that of the adaptive solver, Rodas4
//! (Hairer, Wanner (1996), Solving Ordinary Differential Equations II, 2nd edition, section IV.10), of order 4 and L-stable,
//! for an equation that is linear: so it needs no derivative of the Jacobian along `S`.

use nalgebra::SMatrix;

use crate::solver::{RODAS, Solver};
use crate::system::Groups;

/// The largest number of parts.
const MOST_PARTS: u32 = 1 << 14;

/// What the equations are at a point of a run.
#[derive(Clone, Debug)]
pub struct Node {
    /// The Jacobian of the rates, column by column.
    pub jacobian: Vec<f64>,
    /// What each direction does to the rates besides, one direction after the other.
    pub forcing: Vec<f64>,
}

/// A piece of a step.
pub struct Piece<'a> {
    /// The equations at its start, its middle and its end.
    pub nodes: [&'a Node; 3],
    /// The same a quarter and three quarters of the way, if they are known.
    pub quarters: Option<&'a [Node; 2]>,
    /// Its length in s.
    pub length: f64,
    /// In how many parts it is tried first.
    pub parts: u32,
}

/// Which couplings between states a Jacobian has: groups, and whether they are those of a chain.
pub type Structure = (Groups, bool);

/// Weights of the values at start, middle and end, and at the quarters if they are known, in that of the polynomial through them at a
/// fraction.
fn shares(has_quarters: bool, at: f64) -> [f64; 5] {
    if !has_quarters {
        return [(1.0 - at) * (1.0 - 2.0 * at), 4.0 * at * (1.0 - at), at * (2.0 * at - 1.0), 0.0, 0.0];
    }
    // By Lagrange, in quarters.
    let [a, b, c, d, e] = [4.0 * at, 4.0 * at - 1.0, 4.0 * at - 2.0, 4.0 * at - 3.0, 4.0 * at - 4.0];
    [b * c * d * e / 24.0, a * b * d * e / 4.0, a * b * c * d / 24.0, -a * c * d * e / 6.0, -a * b * c * e / 6.0]
}

/// The same of its slope per fraction.
fn slopes(has_quarters: bool, at: f64) -> [f64; 5] {
    if !has_quarters {
        return [4.0 * at - 3.0, 4.0 - 8.0 * at, 4.0 * at - 1.0, 0.0, 0.0];
    }
    let u = 4.0 * at;
    let cubic = |[c3, c2, c1, c0]: [f64; 4]| ((c3 * u + c2) * u + c1) * u + c0;
    let rows = [
        [4.0 / 24.0, -30.0 / 24.0, 70.0 / 24.0, -50.0 / 24.0],
        [1.0, -6.0, 9.5, -3.0],
        [4.0 / 24.0, -18.0 / 24.0, 22.0 / 24.0, -6.0 / 24.0],
        [-4.0 / 6.0, 27.0 / 6.0, -52.0 / 6.0, 24.0 / 6.0],
        [-4.0 / 6.0, 21.0 / 6.0, -28.0 / 6.0, 8.0 / 6.0],
    ];
    rows.map(|row| 4.0 * cubic(row))
}

impl Piece<'_> {
    fn jacobian<const N: usize>(&self, weights: [f64; 5]) -> SMatrix<f64, N, N> {
        let mut sum = SMatrix::<f64, N, N>::zeros();
        let [start, middle, end] = self.nodes.map(|node| node.jacobian.as_chunks::<N>().0);
        for (column, ((start, middle), end)) in sum.data.0.iter_mut().zip(start.iter().zip(middle).zip(end)) {
            *column = mix([start, middle, end], weights);
        }
        for (node, weight) in self.quarters.into_iter().flatten().zip(&weights[3..]) {
            for (sum, column) in sum.data.0.iter_mut().zip(node.jacobian.as_chunks::<N>().0) {
                add(sum, column, *weight);
            }
        }
        sum
    }

    fn forcing<const N: usize>(&self, direction: usize, weights: [f64; 5]) -> [f64; N] {
        let of = |node: &'_ Node| node.forcing.as_chunks::<N>().0[direction];
        let [start, middle, end] = self.nodes.map(of);
        let mut sum = mix([&start, &middle, &end], weights);
        for (node, weight) in self.quarters.into_iter().flatten().zip(&weights[3..]) {
            add(&mut sum, &of(node), *weight);
        }
        sum
    }

    /// How much the linear equations bend between its three nodes, relative to weights: the rule of Simpson less that of the
    /// trapezoids.
    pub fn bend(&self, states: usize, columns: &[f64], weights: &[f64]) -> f64 {
        let off = |[start, middle, end]: [f64; 3]| (2.0 * middle - start - end) / 12.0;
        let jacobian = self.of_nodes(|node| &node.jacobian, off);
        let forcing = self.of_nodes(|node| &node.forcing, off);
        self.length * largest(&jacobian, forcing, (states, columns), weights)
    }

    /// How much faster slopes change than parabolas through the linear equations tell, relative to weights: the rule of Boole,
    /// which looks at quarters, less that of Simpson.
    pub fn roughness(&self, states: usize, columns: &[f64], weights: &[f64]) -> f64 {
        let Some(quarters) = self.quarters else { return 0.0 };
        let off = |[start, middle, end]: [f64; 3]| -(0.25 * (start + end) + 1.5 * middle) * (32.0 / 90.0);
        let with = |mut sum: Vec<f64>, of: &dyn Fn(&Node) -> &Vec<f64>| {
            for (slot, (before, behind)) in sum.iter_mut().zip(of(&quarters[0]).iter().zip(of(&quarters[1]))) {
                *slot += (before + behind) * (32.0 / 90.0);
            }
            sum
        };
        let jacobian = with(self.of_nodes(|node| &node.jacobian, off), &|node| &node.jacobian);
        let forcing = with(self.of_nodes(|node| &node.forcing, off), &|node| &node.forcing);
        self.length * largest(&jacobian, forcing, (states, columns), weights)
    }

    /// Numbers made of those of its nodes.
    fn of_nodes<'a>(&'a self, of: impl Fn(&'a Node) -> &'a Vec<f64>, combine: impl Fn([f64; 3]) -> f64) -> Vec<f64> {
        let [start, middle, end] = self.nodes.map(of);
        start.iter().zip(middle).zip(end).map(|((start, middle), end)| combine([*start, *middle, *end])).collect()
    }

    /// Where all directions are behind it, one after the other, and in how many parts that is: the error of each part, relative to
    /// what each state of each direction weighs, is at most 1. `None` if no number of parts is enough.
    pub fn cross<const N: usize>(
        &self,
        structure: Structure,
        columns: &[f64],
        weights: &[f64],
    ) -> Option<(Vec<f64>, u32)> {
        let mut parts = self.parts.clamp(1, MOST_PARTS);
        while parts <= MOST_PARTS {
            let (mut crossed, width) = (columns.to_vec(), 1.0 / f64::from(parts));
            let mut errors = (0..parts)
                .map(|part| self.cross_part::<N>(structure, [f64::from(part) * width, width], &mut crossed, weights));
            if errors.all(|error| error.is_some_and(|error| error <= 1.0)) {
                return Some((crossed, parts));
            }
            parts *= 2;
        }
        None
    }

    /// Takes all directions across a part from a fraction on, and returns the largest error; `None` if the equations of a stage
    /// have no solution.
    fn cross_part<const N: usize>(
        &self,
        (groups, is_chain): Structure,
        [from, width]: [f64; 2],
        columns: &mut [f64],
        weights: &[f64],
    ) -> Option<f64> {
        let h = self.length * width;
        let has_quarters = self.quarters.is_some();
        let at = |fraction: f64| shares(has_quarters, from + fraction * width);
        let times = [RODAS.times[0], RODAS.times[1], RODAS.times[2], RODAS.times[3], 1.0, 1.0].map(at);
        let of_stages: [SMatrix<f64, N, N>; 5] = std::array::from_fn(|stage| self.jacobian(times[stage]));
        let slope_weights = slopes(has_quarters, from).map(|weight| weight / self.length);
        let slope = self.jacobian(slope_weights);
        let solver = Solver::new(&of_stages[0], 1.0 / (RODAS.gamma * h), groups, is_chain)?;
        let mut largest = 0.0f64;
        let weights = weights.as_chunks::<N>().0;
        for (direction, (column, weights)) in columns.as_chunks_mut::<N>().0.iter_mut().zip(weights).enumerate() {
            let mut stages = [[0.0; N]; 6];
            let mut drift = self.forcing(direction, slope_weights);
            add_product(&mut drift, &slope, column);
            let mut argument = *column;
            for stage in 0..6 {
                if stage == 5 {
                    add(&mut argument, &stages[4], 1.0);
                } else {
                    argument = *column;
                    for (weight, other) in RODAS.arguments[stage].iter().zip(&stages) {
                        add(&mut argument, other, *weight);
                    }
                }
                let mut right = self.forcing(direction, times[stage]);
                add_product(&mut right, &of_stages[stage.min(4)], &argument);
                for (weight, other) in RODAS.rights[stage].iter().zip(&stages) {
                    add(&mut right, other, *weight / h);
                }
                if let Some(weight) = RODAS.drifts.get(stage) {
                    add(&mut right, &drift, *weight * h);
                }
                stages[stage] = solver.solve(&right, groups);
            }
            // The last stage is the difference between the solutions of order 4 and 3.
            for (error, weight) in stages[5].iter().zip(weights) {
                largest = largest.max(error.abs() / weight);
            }
            *column = argument;
            add(column, &stages[5], 1.0);
        }
        columns.iter().all(|value| value.is_finite()).then_some(largest)
    }
}

/// The largest rate at which a part of the linear equations, of so many states, changes states, relative to weights.
fn largest(jacobian: &[f64], mut forcing: Vec<f64>, (states, columns): (usize, &[f64]), weights: &[f64]) -> f64 {
    for (rates, column) in forcing.chunks_exact_mut(states).zip(columns.chunks_exact(states)) {
        for (entries, state) in jacobian.chunks_exact(states).zip(column).filter(|(_, state)| **state != 0.0) {
            rates.iter_mut().zip(entries).for_each(|(rate, entry)| *rate += entry * state);
        }
    }
    forcing.iter().zip(weights).fold(0.0f64, |largest, (rate, weight)| largest.max(rate.abs() / weight))
}

#[inline(always)]
fn add<const N: usize>(sum: &mut [f64; N], other: &[f64; N], weight: f64) {
    for (slot, value) in sum.iter_mut().zip(other) {
        *slot += weight * value;
    }
}

/// The sum of three vectors with the first weights.
#[inline(always)]
fn mix<const N: usize>([start, middle, end]: [&[f64; N]; 3], [of_start, of_middle, of_end, ..]: [f64; 5]) -> [f64; N] {
    std::array::from_fn(|i| of_start * start[i] + of_middle * middle[i] + of_end * end[i])
}

fn add_product<const N: usize>(sum: &mut [f64; N], matrix: &SMatrix<f64, N, N>, vector: &[f64; N]) {
    for (column, factor) in matrix.data.0.iter().zip(vector) {
        if *factor != 0.0 {
            add(sum, column, *factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every state may change every other.
    const DENSE: Structure = ([0, 0], false);

    fn node(jacobian: f64, forcing: f64) -> Node {
        Node { jacobian: vec![jacobian], forcing: vec![forcing] }
    }

    /// `dS/dt = -t*S + t`, whose solution from 0 is `1 - exp(-t^2/2)`, over one second in pieces.
    #[test]
    fn error_is_of_fourth_order() {
        let error = |pieces: u32| {
            let (mut columns, h) = (vec![0.0], 1.0 / f64::from(pieces));
            for piece in 0..pieces {
                let nodes = [0.0, 0.5, 1.0].map(|part| (f64::from(piece) + part) * h).map(|t| node(-t, t));
                let [start, middle, end] = &nodes;
                let piece = Piece { nodes: [start, middle, end], quarters: None, length: h, parts: 1 };
                columns = piece.cross::<1>(DENSE, &columns, &[f64::INFINITY]).expect("solvable").0;
            }
            (columns[0] - (1.0 - (-0.5f64).exp())).abs()
        };
        let [coarse, fine] = [error(4), error(8)];
        assert!(coarse < 1e-4 && (12.0..24.0).contains(&(coarse / fine)), "{coarse} and {fine}");
    }

    /// A relaxation far faster than the piece ends where it leads, but for a share of the distance, here 2, that falls as the rate
    /// by the length grows: nine parts of 1e6.
    #[test]
    fn stiff_relaxation_ends_where_it_leads() {
        let stiff = node(-1e9, 3e9);
        let piece = Piece { nodes: [&stiff; 3], quarters: None, length: 1e-3, parts: 1 };
        let (columns, _) = piece.cross::<1>(DENSE, &[1.0], &[f64::INFINITY]).expect("solvable");
        assert!((columns[0] - 3.0).abs() < 2e-5, "{}", columns[0]);
    }

    /// An oscillation that is far too fast for the piece: in as many parts as it takes.
    #[test]
    fn parts_are_as_many_as_the_error_asks_for() {
        let swing = Node { jacobian: vec![0.0, -1e4, 1.0, 0.0], forcing: vec![0.0; 2] };
        let piece = Piece { nodes: [&swing; 3], quarters: None, length: 0.1, parts: 1 };
        let (columns, _) = piece.cross::<2>(DENSE, &[1.0, 0.0], &[1e-9, 1e-7]).expect("parts enough");
        assert!((columns[0] - 10.0f64.cos()).abs() < 1e-7, "{columns:?}");
    }

    /// A polynomial through all nodes meets a power that it can, and its slope.
    #[test]
    fn polynomial_meets_powers_and_their_slopes() {
        for (has_quarters, power) in [(false, 2), (true, 4)] {
            let places: &[f64] = if has_quarters { &[0.0, 0.5, 1.0, 0.25, 0.75] } else { &[0.0, 0.5, 1.0] };
            let sum =
                |weights: [f64; 5]| places.iter().zip(weights).map(|(it, weight)| weight * it.powi(power)).sum::<f64>();
            for at in [0.0f64, 0.3, 0.5, 0.9, 1.0] {
                // Some roundings of weights up to 16.
                assert!((sum(shares(has_quarters, at)) - at.powi(power)).abs() < 1e-14);
                assert!((sum(slopes(has_quarters, at)) - f64::from(power) * at.powi(power - 1)).abs() < 1e-13);
            }
        }
    }
}
