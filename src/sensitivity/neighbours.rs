//! What hands numbers on as they are, or sets them, seen without differences.
//!
//! As a rule a step changes little in the memory: a play follows its input, a reading is taken. What that does to slopes is
//! known without any difference where all states and all numbers that have slopes are moved, to both sides, and what comes
//! out is the same, or moved as before. The moved memories are kept from one time to the next.

use super::companion::Companion;
use super::equations::{Act, Equations};
use super::memory::{SHARE, shifted};
use super::sides::{Neighbours, Side};
use super::slopes::along;

impl Companion {
    /// Whether an evaluation gives what it does at present whatever those numbers of the memory are that have slopes. `false` may
    /// be wrong.
    pub(super) fn neighbour_agrees(&mut self, present: &[f64], evaluate: impl Fn(&dyn Equations) -> Vec<f64>) -> bool {
        self.meet_neighbours();
        self.neighbours.as_ref().is_some_and(|it| evaluate(it.sides[0].equations.as_ref()) == present)
    }

    /// Lets neighbours differ in all numbers that have slopes, or have lost them.
    fn meet_neighbours(&mut self) {
        let has_slope = |leaf: usize| self.slopes.iter().any(|slopes| slopes.memory[leaf] != 0.0);
        let is_moved = |neighbours: &Neighbours| {
            let mut moved = neighbours.moved.iter().enumerate();
            moved.all(|(leaf, moved)| *moved || !has_slope(leaf) || !self.memory.value(leaf).is_finite())
        };
        if self.neighbours.as_ref().is_some_and(is_moved) {
            return;
        }
        let moved: Vec<bool> = (0..self.memory.count()).map(has_slope).collect();
        let side = |share: f64| {
            let memory = shifted(&self.memory, share, |leaf| moved[leaf]);
            let mut equations = self.equations.twin();
            equations.remember(&memory);
            Side { equations, numbers: memory.values(), share }
        };
        let sides = [SHARE, -SHARE].map(side);
        self.neighbours = Some(Neighbours { moved, sides });
    }

    /// Which numbers of the memory acts hand on as they are, where they set all others and leave the states alone; `None` if they
    /// do more. The memory keeps its form, and has other numbers behind them.
    pub(super) fn handed_on(&mut self, acts: &[Act], after: &[f64]) -> Option<Vec<bool>> {
        self.meet_neighbours();
        let (time, u) = (self.time, self.inputs.at(self.time));
        let Neighbours { mut sides, mut moved } = self.neighbours.take()?;
        let shifts: Vec<f64> =
            self.scales.iter().enumerate().map(|(i, scale)| scale * (1.0 + 0.1 * i as f64)).collect();
        let mut kept: Option<Vec<bool>> = None;
        for side in &mut sides {
            let x = along(&self.x, &shifts, side.share);
            let mut states = x.clone();
            acts.iter().for_each(|act| side.equations.enact(*act, time, &mut states, &u));
            let mut numbers = Vec::with_capacity(after.len());
            if side.equations.numbers(&mut numbers) != self.form || states != x {
                return None;
            }
            let is_kept = |leaf: usize| {
                let [before, behind] = [side.numbers[leaf], numbers[leaf]].map(f64::to_bits);
                let [own_before, own_behind] = [self.memory.value(leaf), after[leaf]].map(f64::to_bits);
                if before == behind && own_before == own_behind {
                    return Some(true);
                }
                (behind == own_behind).then_some(false)
            };
            let found: Vec<bool> = (0..after.len()).map(is_kept).collect::<Option<_>>()?;
            if kept.as_ref().is_some_and(|kept| *kept != found) {
                return None;
            }
            (side.numbers, kept) = (numbers, Some(found));
        }
        let kept = kept?;
        moved.iter_mut().zip(&kept).for_each(|(moved, kept)| *moved &= kept);
        self.neighbours = Some(Neighbours { sides, moved });
        Some(kept)
    }

    /// Whether acts, which the present equations have come through, leave the states alone and lead to the same memory whatever
    /// the parameter and the inputs of a direction are; `false` if that cannot be told.
    pub(super) fn heeds_neither(&mut self, direction: usize, acts: &[Act]) -> bool {
        let (x, u) = (&self.x, self.inputs.at(self.time));
        let way = &mut self.ways[direction];
        let (mut is_same, added) = (true, way.inputs.clone());
        for (equations, share) in way.alike() {
            let magnitude = |input: &f64| input.abs().max(1.0);
            let moved: Vec<f64> = u.iter().zip(&added).map(|(u, added)| u + share * added * magnitude(u)).collect();
            let mut states = x.clone();
            acts.iter().for_each(|act| equations.enact(*act, self.time, &mut states, &moved));
            if states != *x || !equations.holds(self.equations.held()) {
                equations.adopt(self.equations.held());
                is_same = false;
            }
        }
        is_same
    }
}
