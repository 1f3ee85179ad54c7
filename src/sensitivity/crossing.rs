//! How slopes go along a step of their run.

use super::NoDerivative;
use super::companion::Companion;
use super::equations::At;
use super::memory::Dependence;
use super::of::Of;
use super::variation::{Node, Piece};

/// Steps are divided at kinks until less than this fraction is left.
const SMALLEST_PIECE: f64 = 1e-9;
/// Slopes that change a state by less than this multiple of its scale, where the parameter changes by its magnitude, do not
/// count.
const NEGLIGIBLE: f64 = 1e-3;
/// Most parts in which a piece is tried first.
const MOST_AT_FIRST: f64 = 8.0;
/// How often the error that is allowed the linear equations may bend between three points before somebody looks in between.
const STRAIGHT: f64 = 10.0;
/// How much the rules of Simpson and Boole may differ, relative to that error: what is integrated is closer to the latter.
const SMOOTH: f64 = 8.0;

/// A step: the cubic through the states and the rates at both ends.
struct Path {
    start: f64,
    h: f64,
    ends: [Vec<f64>; 2],
    rates: [Vec<f64>; 2],
}

impl Path {
    fn at(&self, fraction: f64) -> Vec<f64> {
        let rest = 1.0 - fraction;
        let [value, first, last] = [
            fraction * fraction * (3.0 - 2.0 * fraction),
            fraction * rest * rest * self.h,
            fraction * fraction * rest * self.h,
        ];
        let state = |i: usize| {
            let [start, end] = [self.ends[0][i], self.ends[1][i]];
            start + value * (end - start) + first * self.rates[0][i] - last * self.rates[1][i]
        };
        (0..self.ends[0].len()).map(state).collect()
    }
}

/// A part of a step that is left, with the equations in its middle and at its end.
struct Rest {
    ends: [f64; 2],
    middle: Node,
    end: Node,
}

impl Companion {
    /// Goes along a step.
    pub(super) fn cross(&mut self, time: f64, end: &[f64]) {
        if end.is_empty() {
            // Nothing is integrated.
            self.time = time;
            return;
        }
        let start = self.time;
        let u = [start, time].map(|time| self.inputs.at(time));
        let rates = [
            self.equations.rates(At { time: start, x: &self.x, u: &u[0] }),
            self.equations.rates(At { time, x: end, u: &u[1] }),
        ];
        let path = Path { start, h: time - start, ends: [self.x.clone(), end.to_vec()], rates };
        let mut here = self.here.take().unwrap_or_else(|| self.node(&path, 0.0));
        let n = end.len();
        let mut columns: Vec<f64> = self.slopes.iter().flat_map(|slopes| &slopes.states).copied().collect();
        // Rests, the next one last.
        let mut rests = vec![Rest { ends: [0.0, 1.0], middle: self.node(&path, 0.5), end: self.node(&path, 1.0) }];
        let mut is_solvable = true;
        while let Some(Rest { ends: [from, to], middle, end }) = rests.pop() {
            let weights = self.weights(&columns);
            let is_divisible = to - from > SMALLEST_PIECE;
            let length = (to - from) * path.h;
            let parts = (0.5 * self.pace * length).min(MOST_AT_FIRST) as u32;
            let piece = Piece { nodes: [&here, &middle, &end], quarters: None, length, parts };
            let is_straight = piece.bend(n, &columns, &weights) <= STRAIGHT;
            let quarters = match is_straight || !is_divisible {
                true => None,
                false => Some([0.25, 0.75].map(|share| self.node(&path, from + share * (to - from)))),
            };
            let piece = Piece { quarters: quarters.as_ref(), ..piece };
            let is_smooth = piece.roughness(n, &columns, &weights) <= SMOOTH;
            let crossed = if is_smooth { self.equations.cross(&piece, &columns, &weights) } else { None };
            if let Some((crossed, parts)) = crossed {
                (columns, here) = (crossed, end);
                self.pace = if parts > 1 { f64::from(parts) / length } else { 0.0 };
            } else if is_divisible {
                let nodes = || [0.25, 0.75].map(|share| self.node(&path, from + share * (to - from)));
                let [before, behind] = quarters.unwrap_or_else(nodes);
                let half = 0.5 * (from + to);
                rests.push(Rest { ends: [half, to], middle: behind, end });
                rests.push(Rest { ends: [from, half], middle: before, end: middle });
            } else {
                is_solvable = false;
                break;
            }
        }
        let weights = self.weights(&columns);
        let found = columns.chunks_exact(n).zip(weights.chunks_exact(n));
        for (slopes, (column, weights)) in self.slopes.iter_mut().zip(found) {
            if !is_solvable && slopes.lost.is_none() {
                let reason = "its linear equations have no solution".to_owned();
                slopes.lost = Some(NoDerivative { time, event: "a step".to_owned(), reason });
            }
            slopes.states.copy_from_slice(column);
            slopes.peaks.clear();
            slopes.peaks.extend(weights.iter().map(|weight| weight / self.tolerance));
        }
        (self.time, self.x) = (time, end.to_vec());
        self.here = is_solvable.then_some(here);
    }

    /// Errors that states of slopes may have in a part of a step.
    fn weights(&self, columns: &[f64]) -> Vec<f64> {
        let n = self.scales.len();
        let mut weights = Vec::with_capacity(columns.len());
        for ((way, slopes), column) in self.ways.iter().zip(&self.slopes).zip(columns.chunks_exact(n)) {
            let share = NEGLIGIBLE / way.magnitude;
            let weight = |(peak, (slope, scale)): (&f64, (&f64, &f64))| {
                self.tolerance * peak.max(slope.abs()).max(share * scale)
            };
            weights.extend(slopes.peaks.iter().zip(column.iter().zip(&self.scales)).map(weight));
        }
        weights
    }

    /// The states at a fraction of a step.
    fn between(&self, path: &Path, fraction: f64) -> Vec<f64> {
        if fraction == 0.0 || fraction == 1.0 {
            return path.ends[usize::from(fraction == 1.0)].clone();
        }
        let mut x = path.at(fraction);
        if !self.inputs.vary() {
            // States that follow the inputs alone change faster within a step than a cubic can tell.
            let at = At { time: path.start, x: &path.ends[0], u: &self.inputs.values };
            let led = self.equations.later(at, fraction * path.h).unwrap_or_default();
            x[..led.len()].copy_from_slice(&led);
        }
        x
    }

    /// The linear equations at a fraction of a step, with the present memory.
    fn node(&mut self, path: &Path, fraction: f64) -> Node {
        let time = if fraction == 0.0 { path.start } else { path.start + fraction * path.h };
        let (x, u) = (self.between(path, fraction), self.inputs.at(time));
        let at = At { time, x: &x, u: &u };
        let mut of_rates = std::mem::take(&mut self.of_rates);
        if self.moves_memory() {
            let end = [0.0, 1.0].iter().position(|end| *end == fraction);
            let present = end.map_or_else(|| self.equations.rates(at), |end| path.rates[end].clone());
            if !self.neighbour_agrees(&present, |equations| equations.rates(at)) {
                of_rates.renew(self.spare.as_mut(), &self.memory, &present, |equations| equations.rates(at));
            }
        }
        let n = x.len();
        let mut forcing = vec![0.0; n * self.ways.len()];
        for (direction, forcing) in forcing.chunks_exact_mut(n).enumerate() {
            self.force(direction, at, &of_rates, forcing);
        }
        self.of_rates = of_rates;
        Node { jacobian: self.equations.jacobian(at), forcing }
    }

    /// What a direction does to the rates besides changing the states; nothing if that is not known.
    fn force(&mut self, direction: usize, at: At, of_rates: &Dependence, forcing: &mut [f64]) {
        let slopes = &self.slopes[direction];
        if slopes.lost.is_some() || self.ways[direction].is_still() && !of_rates.matters(&slopes.memory) {
            return;
        }
        if let Err(reason) = self.besides(direction, at, Of::Rates, of_rates, forcing) {
            forcing.fill(0.0);
            let lost = NoDerivative { time: at.time, event: "the equations".to_owned(), reason };
            self.slopes[direction].lost = Some(lost);
        }
    }
}
