//! The linear equations that small changes of a run follow along it.
//!
//! ```text
//! dS/dt = J(t)*S + b(t)
//! ```
//!
//! `J` is the Jacobian of the rates along the run and `b` what a direction does to them besides. Over a piece of a step in
//! which both are smooth they are the parabolas through their values at its start, its middle and its end: the error of that
//! is, as that of Simpson's rule, of fifth order in the length of the piece. The method is that of the adaptive solver, Rodas4
//! (Hairer, Wanner (1996), Solving Ordinary Differential Equations II, 2nd edition, section IV.10), of order 4 and L-stable,
//! for an equation that is linear: so it needs no derivative of the Jacobian along `S`.

use crate::solver::RODAS;

/// The largest number of parts.
const MOST_PARTS: u32 = 1 << 14;

/// A square matrix, column by column.
pub type Matrix = Vec<f64>;

/// What the equations are at a point of a run.
#[derive(Clone, Debug)]
pub struct Node {
    /// The Jacobian of the rates.
    pub jacobian: Matrix,
    /// What each direction does to the rates besides.
    pub forcing: Vec<Vec<f64>>,
}

/// A piece of a step.
pub struct Piece<'a> {
    /// The equations at its start, its middle and its end.
    pub nodes: [&'a Node; 3],
    /// Its length in s.
    pub length: f64,
    /// In how many parts it is integrated.
    pub parts: u32,
}

/// Weights of the values at start, middle and end in that of a parabola at a fraction.
fn shares(at: f64) -> [f64; 3] {
    [(1.0 - at) * (1.0 - 2.0 * at), 4.0 * at * (1.0 - at), at * (2.0 * at - 1.0)]
}

/// The same of its slope per fraction.
fn slopes(at: f64) -> [f64; 3] {
    [4.0 * at - 3.0, 4.0 - 8.0 * at, 4.0 * at - 1.0]
}

fn mean([start, middle, end]: [&[f64]; 3], [a, b, c]: [f64; 3]) -> Vec<f64> {
    start.iter().zip(middle).zip(end).map(|((start, middle), end)| a * start + b * middle + c * end).collect()
}

impl Piece<'_> {
    fn jacobian(&self, weights: [f64; 3]) -> Matrix {
        mean(self.nodes.map(|node| &node.jacobian[..]), weights)
    }

    fn forcing(&self, direction: usize, weights: [f64; 3]) -> Vec<f64> {
        mean(self.nodes.map(|node| &node.forcing[direction][..]), weights)
    }

    /// Where all directions are behind it, in so many parts at least as it has; the error of each part, relative to what each
    /// state of each direction weighs, is at most 1. `None` if no number of parts is enough.
    pub fn cross(&self, columns: &[Vec<f64>], weights: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let mut parts = self.parts;
        while parts <= MOST_PARTS {
            let (mut crossed, width) = (columns.to_vec(), 1.0 / f64::from(parts));
            let mut errors =
                (0..parts).map(|part| self.cross_part(f64::from(part) * width, width, &mut crossed, weights));
            if errors.all(|error| error.is_some_and(|error| error <= 1.0)) {
                return Some(crossed);
            }
            parts *= 2;
        }
        None
    }

    /// Takes all directions across a part, and returns the largest error; `None` if the equations of a stage have no solution.
    fn cross_part(&self, from: f64, width: f64, columns: &mut [Vec<f64>], weights: &[Vec<f64>]) -> Option<f64> {
        let h = self.length * width;
        let at = |fraction: f64| shares(from + fraction * width);
        let times = [RODAS.times[0], RODAS.times[1], RODAS.times[2], RODAS.times[3], 1.0, 1.0].map(at);
        let of_stages: [Matrix; 5] = std::array::from_fn(|stage| self.jacobian(times[stage]));
        let slope_weights = slopes(from).map(|weight| weight / self.length);
        let slope = self.jacobian(slope_weights);
        let n = columns.first().map_or(0, Vec::len);
        let factors = Factors::new(&of_stages[0], 1.0 / (RODAS.gamma * h), n)?;
        let mut stages: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; n]);
        let (mut argument, mut largest) = (vec![0.0; n], 0.0f64);
        for (direction, column) in columns.iter_mut().enumerate() {
            let mut drift = self.forcing(direction, slope_weights);
            add_product(&mut drift, &slope, column);
            for stage in 0..6 {
                if stage == 5 {
                    add(&mut argument, &stages[4], 1.0);
                } else {
                    argument.copy_from_slice(column);
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
                factors.solve(&mut right);
                stages[stage] = right;
            }
            // The last stage is the difference between the solutions of order 4 and 3.
            for (error, weight) in stages[5].iter().zip(&weights[direction]) {
                largest = largest.max(error.abs() / weight);
            }
            column.copy_from_slice(&argument);
            add(column, &stages[5], 1.0);
        }
        columns.iter().flatten().all(|value| value.is_finite()).then_some(largest)
    }
}

fn add(sum: &mut [f64], other: &[f64], weight: f64) {
    for (slot, value) in sum.iter_mut().zip(other) {
        *slot += weight * value;
    }
}

fn add_product(sum: &mut [f64], matrix: &[f64], vector: &[f64]) {
    for (column, factor) in matrix.chunks_exact(vector.len()).zip(vector) {
        if *factor != 0.0 {
            add(sum, column, *factor);
        }
    }
}

/// The factors of `shift*I - J`, by Gaussian elimination with partial pivoting.
struct Factors {
    n: usize,
    matrix: Matrix,
    /// The row that took the place of each.
    swaps: Vec<usize>,
}

impl Factors {
    fn new(jacobian: &[f64], shift: f64, n: usize) -> Option<Self> {
        let mut matrix: Matrix = jacobian.iter().map(|entry| -entry).collect();
        (0..n).for_each(|k| matrix[k * n + k] += shift);
        let mut swaps = Vec::with_capacity(n);
        for k in 0..n {
            let best = (k..n).max_by(|a, b| matrix[k * n + a].abs().total_cmp(&matrix[k * n + b].abs()))?;
            swaps.push(best);
            for j in 0..n {
                matrix.swap(j * n + k, j * n + best);
            }
            let inverse = 1.0 / matrix[k * n + k];
            if !inverse.is_finite() {
                return None;
            }
            for i in k + 1..n {
                matrix[k * n + i] *= inverse;
            }
            for j in k + 1..n {
                let (before, column) = matrix.split_at_mut(j * n);
                let factor = column[k];
                if factor != 0.0 {
                    add(&mut column[k + 1..n], &before[k * n + k + 1..(k + 1) * n], -factor);
                }
            }
        }
        Some(Self { n, matrix, swaps })
    }

    fn solve(&self, right: &mut [f64]) {
        let n = self.n;
        self.swaps.iter().enumerate().for_each(|(k, best)| right.swap(k, *best));
        for k in 0..n {
            let factor = right[k];
            add(&mut right[k + 1..], &self.matrix[k * n + k + 1..(k + 1) * n], -factor);
        }
        for k in (0..n).rev() {
            right[k] /= self.matrix[k * n + k];
            let factor = right[k];
            add(&mut right[..k], &self.matrix[k * n..k * n + k], -factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(jacobian: f64, forcing: f64) -> Node {
        Node { jacobian: vec![jacobian], forcing: vec![vec![forcing]] }
    }

    /// `dS/dt = -t*S + t`, whose solution from 0 is `1 - exp(-t^2/2)`, over one second in pieces.
    #[test]
    fn error_is_of_fourth_order() {
        let error = |pieces: u32| {
            let (mut columns, h) = (vec![vec![0.0]], 1.0 / f64::from(pieces));
            for piece in 0..pieces {
                let nodes = [0.0, 0.5, 1.0].map(|part| (f64::from(piece) + part) * h).map(|t| node(-t, t));
                let [start, middle, end] = &nodes;
                let piece = Piece { nodes: [start, middle, end], length: h, parts: 1 };
                columns = piece.cross(&columns, &[vec![f64::INFINITY]]).expect("solvable");
            }
            (columns[0][0] - (1.0 - (-0.5f64).exp())).abs()
        };
        let [coarse, fine] = [error(4), error(8)];
        assert!(coarse < 1e-4 && (12.0..24.0).contains(&(coarse / fine)), "{coarse} and {fine}");
    }

    /// A relaxation far faster than the piece ends where it leads, but for a share of the distance, here 2, that falls as the rate
    /// by the length grows: nine parts of 1e6.
    #[test]
    fn stiff_relaxation_ends_where_it_leads() {
        let stiff = node(-1e9, 3e9);
        let piece = Piece { nodes: [&stiff; 3], length: 1e-3, parts: 1 };
        let columns = piece.cross(&[vec![1.0]], &[vec![f64::INFINITY]]).expect("solvable");
        assert!((columns[0][0] - 3.0).abs() < 2e-5, "{}", columns[0][0]);
    }

    /// An oscillation that is far too fast for the piece: in as many parts as it takes.
    #[test]
    fn parts_are_as_many_as_the_error_asks_for() {
        let swing = Node { jacobian: vec![0.0, -1e4, 1.0, 0.0], forcing: vec![vec![0.0; 2]] };
        let piece = Piece { nodes: [&swing; 3], length: 0.1, parts: 1 };
        let columns = piece.cross(&[vec![1.0, 0.0]], &[vec![1e-9, 1e-7]]).expect("parts enough");
        assert!((columns[0][0] - 10.0f64.cos()).abs() < 1e-7, "{columns:?}");
    }

    #[test]
    fn parabola_meets_its_values() {
        for (place, at) in [0.0, 0.5, 1.0].into_iter().enumerate() {
            let expected: [f64; 3] = std::array::from_fn(|i| f64::from(u8::from(i == place)));
            assert_eq!(shares(at), expected);
        }
    }

    /// A matrix whose first pivot is 0 without an exchange of rows.
    #[test]
    fn factors_solve_a_system_that_needs_pivots() {
        // shift*I - J with shift 1 is [[0, 2, 0], [1, 1, 0], [0, 3, 4]].
        let jacobian = [1.0, -1.0, 0.0, -2.0, 0.0, -3.0, 0.0, 0.0, -3.0];
        let mut right = [4.0, 3.0, 14.0];
        Factors::new(&jacobian, 1.0, 3).expect("regular").solve(&mut right);
        for (found, expected) in right.into_iter().zip([1.0, 2.0, 2.0]) {
            assert!((found - expected).abs() < 2e-15, "{found}, not {expected}, by more than some roundings");
        }
    }
}
