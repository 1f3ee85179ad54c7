//! What depends on the numbers of a memory.

use super::equations::Equations;
use super::leaves::Leaves;

/// Share of its magnitude by which what is differenced moves. The error of a central difference is the square of that, and
/// that of rounding 1e-16 over it.
pub(super) const SHARE: f64 = 1e-5;

/// Magnitude of a number of a memory: between a typical deflection and the scale of positions in m.
pub(super) fn magnitude(value: f64) -> f64 {
    value.abs().clamp(1e-6, 1e-3)
}

/// Whether the slope of a number of a memory moves it; one that there is none of does not.
pub(super) fn moves(slope: f64) -> bool {
    slope != 0.0 && !slope.is_nan()
}

/// A memory whose numbers are moved by a share of slopes.
pub(super) fn moved(memory: &Leaves, slopes: &[f64], share: f64) -> Leaves {
    let moved = |leaf: usize| memory.value(leaf) + if moves(slopes[leaf]) { share * slopes[leaf] } else { 0.0 };
    if slopes.iter().any(|slope| moves(*slope)) { memory.with(moved) } else { memory.clone() }
}

/// How large the step of a number is, so that none makes up for another.
fn own_size(leaf: usize) -> f64 {
    1.0 + 0.1 * (leaf % 7) as f64
}

/// A memory of which some numbers are moved by a share of about their magnitude, by steps of their own, so that none makes up
/// for another.
pub(super) fn shifted(memory: &Leaves, share: f64, is_chosen: impl Fn(usize) -> bool) -> Leaves {
    memory.with(|leaf| {
        let here = memory.value(leaf);
        let moves = is_chosen(leaf) && here.is_finite();
        here + if moves { share * magnitude(here) * own_size(leaf) } else { 0.0 }
    })
}

/// The numbers of a memory on which an evaluation depends.
#[derive(Debug, Default)]
pub(super) struct Dependence {
    leaves: Vec<usize>,
    /// Numbers of which the evaluation has nothing but copies, as the last reading of a sensor, and their places in it.
    copies: Vec<(usize, Vec<usize>)>,
}

impl Dependence {
    /// Finds those that are not known yet, where an evaluation gives `present`.
    pub fn renew(
        &mut self,
        spare: &mut dyn Equations,
        memory: &Leaves,
        present: &[f64],
        evaluate: impl Fn(&dyn Equations) -> Vec<f64>,
    ) {
        self.leaves.retain(|leaf| *leaf < memory.count());
        self.copies.retain(|(leaf, _)| *leaf < memory.count());
        let is_other = |leaf: &usize| !self.leaves.contains(leaf) && memory.value(*leaf).is_finite();
        let others: Vec<usize> = (0..memory.count()).filter(is_other).collect();
        // As a rule nothing depends on them, with all moved at once; otherwise halves of them, until they are single numbers.
        let mut halves = vec![&others[..]];
        while let Some(half) = halves.pop() {
            if half.is_empty() {
                continue;
            }
            let other = shifted(memory, SHARE, |leaf| half.contains(&leaf));
            spare.remember(&other);
            let found = evaluate(spare);
            if found == present {
                continue;
            }
            match half {
                [leaf] => {
                    self.leaves.push(*leaf);
                    let places: Vec<usize> = (0..found.len()).filter(|i| found[*i] != present[*i]).collect();
                    let is_copy = |i: &usize| [present[*i], found[*i]] == [memory, &other].map(|it| it.value(*leaf));
                    if places.iter().all(is_copy) {
                        self.copies.push((*leaf, places));
                    }
                }
                _ => halves.extend([half.split_at(half.len() / 2).0, half.split_at(half.len() / 2).1]),
            }
        }
    }

    /// Whether slopes of a memory, or missing ones, are among those on which something depends.
    pub fn matters(&self, slopes: &[f64]) -> bool {
        self.leaves.iter().any(|leaf| slopes[*leaf] != 0.0)
    }

    /// Slopes of a memory without those on which nothing depends or that are [copied](Self::copied), and the places of those that are not known.
    pub fn of(&self, slopes: &[f64]) -> (Vec<f64>, Vec<usize>) {
        let mut own = vec![0.0; slopes.len()];
        let (unknown, known): (Vec<usize>, Vec<usize>) = self.leaves.iter().partition(|leaf| slopes[**leaf].is_nan());
        known.into_iter().for_each(|leaf| own[leaf] = slopes[leaf]);
        self.copies.iter().for_each(|(leaf, _)| own[*leaf] = 0.0);
        (own, unknown)
    }

    /// The slopes of numbers that are copied, with the places to which they are.
    pub fn copied<'a>(&'a self, slopes: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
        let known = self.copies.iter().filter(|(leaf, _)| moves(slopes[*leaf]));
        known.flat_map(|(leaf, places)| places.iter().map(|place| (*place, slopes[*leaf])))
    }
}

#[cfg(test)]
mod tests {
    use super::{moved, moves};
    use crate::sensitivity::leaves::Leaves;

    #[test]
    fn numbers_without_a_slope_stay_where_they_are() {
        let memory = Leaves::of(&[1.0, 2.0, 3.0]);
        assert_eq!(moved(&memory, &[0.5, f64::NAN, 0.0], 0.5).values(), [1.25, 2.0, 3.0]);
        assert_eq!([0.0, f64::NAN, -1e-300].map(moves), [false, false, true]);
    }
}
