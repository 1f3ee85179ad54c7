//! The extended filter: along the derivative of a step.

use super::{Belief, Outputs, Propagation};
use crate::model::Setup;
use crate::numbers::{DIRECTIONS, Tangent};
use crate::sensitivity::{Along, Varied};
use crate::session::{Snapshot, SnapshotError};
use crate::solver::StepError;
use crate::variables::ParameterError;

/// Runs of the plant beside each other, each with slopes in a few directions.
pub(super) struct Extended {
    runs: Vec<Box<dyn Varied>>,
    /// Derivative of the last step in nominal units, by its rows.
    transition: Vec<f64>,
    room: Vec<f64>,
    /// Continuous states and computed variables with slopes, of one run.
    moved: Vec<Tangent>,
    shown: Vec<Tangent>,
}

impl Extended {
    /// Runs of a plant that estimate a number of quantities.
    pub(super) fn new(setup: &Setup, n: usize) -> Result<Self, ParameterError> {
        let mut runs = (0..n.div_ceil(DIRECTIONS)).map(|_| setup.varied(0.0, &[])).collect::<Result<Vec<_>, _>>()?;
        runs.iter_mut().for_each(|run| run.be_silent());
        let table = setup.table();
        Ok(Self {
            runs,
            transition: (0..n * n).map(|place| f64::from(u8::from(place / n == place % n))).collect(),
            room: vec![0.0; n * n],
            moved: vec![Tangent::still(0.0); table.states().count()],
            shown: vec![Tangent::still(0.0); table.computed().count()],
        })
    }

    /// Names of the computed variables that are numbers of the memory, which an estimate does not move: readings between samples.
    pub(super) fn held(&self) -> Vec<String> {
        let memory = self.runs.first().map(|run| run.memory()).unwrap_or_default();
        memory.into_iter().filter(|number| number.is_variable).map(|number| number.name).collect()
    }

    /// Reads the derivative of the step that a run has made.
    fn read(&mut self, number: usize, belief: &Belief) {
        let (run, n) = (&self.runs[number], belief.estimated.len());
        run.states(&mut self.moved);
        for direction in 0..DIRECTIONS {
            let column = number * DIRECTIONS + direction;
            if column >= n || run.lost(direction).is_some() {
                // The derivative of the step before serves.
                continue;
            }
            for (row, own) in belief.estimated.iter().enumerate() {
                self.transition[row * n + column] = match own.along {
                    Along::State(state) => {
                        self.moved[state].slopes[direction] * belief.estimated[column].nominal / own.nominal
                    }
                    _ => f64::from(u8::from(row == column)),
                };
            }
        }
    }
}

impl Propagation for Extended {
    fn step(&mut self, belief: &mut Belief, size: f64) -> Result<(), StepError> {
        for number in 0..self.runs.len() {
            let run = &mut self.runs[number];
            run.set_inputs(&belief.inputs, &belief.still);
            run.step(size)?;
            self.read(number, belief);
        }
        belief.states.iter_mut().zip(&self.moved).for_each(|(slot, moved)| *slot = moved.value);
        // A*P*A'.
        let n = belief.estimated.len();
        for row in 0..n {
            for column in 0..n {
                let terms = (0..n).map(|k| self.transition[row * n + k] * belief.covariance[k * n + column]);
                self.room[row * n + column] = terms.sum();
            }
        }
        for row in 0..n {
            for column in 0..=row {
                let terms = (0..n).map(|k| self.room[row * n + k] * self.transition[column * n + k]);
                let sum: f64 = terms.sum();
                belief.covariance[row * n + column] = sum;
                belief.covariance[column * n + row] = sum;
            }
        }
        Ok(())
    }

    /// Each run varies in its directions from here on.
    fn move_to(&mut self, belief: &Belief) {
        let mut along = [Along::Input(0); DIRECTIONS];
        for (number, own) in belief.estimated.chunks(DIRECTIONS).enumerate() {
            along.iter_mut().zip(own).for_each(|(slot, it)| *slot = it.along);
            let (moved, rest) = self.runs.split_at_mut(number);
            let run = &mut rest[0];
            run.reseed(&belief.states, &along[..own.len()], moved.first().map(|run| &**run));
            run.set_inputs(&belief.inputs, &belief.still);
        }
    }

    fn outputs(&mut self, belief: &Belief, outputs: &mut Outputs) {
        let n = belief.estimated.len();
        for (number, run) in self.runs.iter_mut().enumerate() {
            run.outputs(&mut self.shown);
            for (place, shown) in self.shown.iter().enumerate() {
                outputs.values[place] = shown.value;
                for (direction, slope) in shown.slopes.iter().enumerate() {
                    let column = number * DIRECTIONS + direction;
                    if column < n {
                        outputs.slopes[place * n + column] = slope * belief.estimated[column].nominal;
                    }
                }
            }
        }
        outputs.residuals.fill(0.0);
    }

    fn save(&self) -> (Snapshot, &[f64]) {
        (self.runs[0].save(), &self.transition)
    }

    fn restore(&mut self, plant: &Snapshot, carried: &[f64]) -> Result<(), SnapshotError> {
        if carried.len() != self.transition.len() {
            return Err(SnapshotError::Lengths);
        }
        self.runs.iter_mut().try_for_each(|run| run.place(plant, &[]))?;
        self.transition.copy_from_slice(carried);
        Ok(())
    }
}
