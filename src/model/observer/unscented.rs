//! The unscented filter: by steps from sigma points around the estimate.
//!
//! S. J. Julier and J. K. Uhlmann, Unscented filtering and nonlinear estimation, Proceedings of the IEEE 92 (2004), 401-422, with the
//! scaling of E. A. Wan and R. van der Merwe, The unscented Kalman filter for nonlinear estimation, AS-SPCC 2000, 153-158. With the
//! columns `l_i` of the Cholesky factor of the covariance `P` of `n` quantities, and a function `f`:
//!
//! ```text
//! d_i = (f(x + c*l_i) - f(x - c*l_i))/(2*c),  e_i = (f(x + c*l_i) + f(x - c*l_i))/2 - f(x)      c^2 = alpha^2*(n + kappa)
//! mean f(x) + m,  covariance sum d_i*d_i' + sum e_i*e_i'/c^2 + (beta - alpha^2)*m*m'             m = sum e_i/c^2
//! ```
//!
//! These are the weighted sums over the points, in a form in which no weight is negative.

use super::{Belief, Outputs, Propagation};
use crate::co_simulation::Simulation;
use crate::model::Setup;
use crate::sensitivity::Along;
use crate::session::{Snapshot, SnapshotError};
use crate::solver::StepError;
use crate::variables::{Kind, ParameterError};

/// Square of the distance `c` of the points: with `n + kappa = 3` the points have the fourth moments of a normal distribution. `alpha` is
/// 1, since the step of a plant with events is no smoother over shorter distances.
const SPREAD_SQUARED: f64 = 3.0;
/// `beta - alpha^2`, with `beta = 2` for normal distributions.
const EXCESS: f64 = 1.0;
/// Share of a variance below which the rest of it, given the quantities before, is one of rounding.
const NEGLIGIBLE: f64 = 1e-12;

/// A run of the plant, which makes all steps.
pub(super) struct Unscented {
    run: Box<dyn Simulation>,
    /// Whether each of the computed variables is a real number.
    is_real: Vec<bool>,
    /// Cholesky factor of the covariance, by its rows.
    factor: Vec<f64>,
    /// States and inputs of a point, and the states at the end of its step.
    states: Vec<f64>,
    inputs: Vec<f64>,
    ended: Vec<f64>,
    /// Computed variables at a point and at the one opposite.
    shown: [Vec<f64>; 2],
    /// The ends of the steps in nominal units: `d_i` and `e_i` by their rows, from the ends of two opposite points.
    odd: Vec<f64>,
    even: Vec<f64>,
    center: Vec<f64>,
    mean: Vec<f64>,
}

impl Unscented {
    /// A run of a plant that estimates a number of quantities.
    pub(super) fn new(setup: &Setup, n: usize) -> Result<Self, ParameterError> {
        let table = setup.table();
        let is_real: Vec<bool> = table.computed().map(|variable| matches!(variable.kind, Kind::Real(_))).collect();
        let (states, computed) = (table.states().count(), is_real.len());
        Ok(Self {
            run: setup.simulation(0.0)?,
            is_real,
            factor: vec![0.0; n * n],
            states: vec![0.0; states],
            inputs: vec![0.0; setup.inputs().len()],
            ended: vec![0.0; states],
            shown: [vec![0.0; computed], vec![0.0; computed]],
            odd: vec![0.0; n * n],
            even: vec![0.0; n * n],
            center: vec![0.0; n],
            mean: vec![0.0; computed.max(n)],
        })
    }

    /// Factors the covariance. A quantity that is known, or follows from others, has a column of zeros.
    fn factorise(&mut self, covariance: &[f64], n: usize) {
        let factor = &mut self.factor;
        factor.fill(0.0);
        for column in 0..n {
            let squares = (0..column).map(|k| factor[column * n + k] * factor[column * n + k]);
            let variance = covariance[column * n + column];
            let rest = variance - squares.sum::<f64>();
            if rest.is_nan() || rest <= NEGLIGIBLE * variance {
                continue;
            }
            let pivot = rest.sqrt();
            factor[column * n + column] = pivot;
            for row in column + 1..n {
                let products = (0..column).map(|k| factor[row * n + k] * factor[column * n + k]);
                factor[row * n + column] = (covariance[row * n + column] - products.sum::<f64>()) / pivot;
            }
        }
    }

    /// Goes from the point that is kept to one beside the estimate, along a column of the factor.
    fn go_beside(&mut self, belief: &Belief, column: usize, distance: f64) {
        let n = belief.estimated.len();
        self.states.copy_from_slice(&belief.states);
        self.inputs.copy_from_slice(&belief.inputs);
        for (row, own) in belief.estimated.iter().enumerate() {
            let change = distance * self.factor[row * n + column] * own.nominal;
            match own.along {
                Along::State(state) => self.states[state] = (self.states[state] + change).max(own.least),
                Along::Input(input) => self.inputs[input] += change,
                _ => {}
            }
        }
        self.run.go_back();
        self.run.move_states(&self.states);
        self.run.set_inputs(&self.inputs, &belief.still);
    }

    /// The end of a step in nominal units, into one of the rooms.
    fn write_end(run: &dyn Simulation, ended: &mut [f64], inputs: &[f64], belief: &Belief, end: &mut [f64]) {
        ended.copy_from_slice(&belief.states);
        run.states(ended);
        for (slot, own) in end.iter_mut().zip(&belief.estimated) {
            *slot = match own.along {
                Along::State(state) => ended[state] / own.nominal,
                Along::Input(input) => inputs[input] / own.nominal,
                _ => 0.0,
            };
        }
    }

    /// Goes back to the estimate.
    fn return_to(&mut self, belief: &Belief) {
        self.run.go_back();
        self.run.set_inputs(&belief.inputs, &belief.still);
    }

    /// Makes a step from each point. The ends of the steps from the two opposite points of a column are left in that row of `odd` and
    /// of `even`.
    fn step_from_points(&mut self, belief: &Belief, size: f64) -> Result<(), StepError> {
        let n = belief.estimated.len();
        let distance = SPREAD_SQUARED.sqrt();
        for column in 0..n {
            if self.factor[column * n + column] == 0.0 {
                continue;
            }
            for is_odd in [true, false] {
                self.go_beside(belief, column, if is_odd { distance } else { -distance });
                self.run.step(size)?;
                let room = if is_odd { &mut self.odd } else { &mut self.even };
                let end = &mut room[column * n..(column + 1) * n];
                Self::write_end(&*self.run, &mut self.ended, &self.inputs, belief, end);
            }
        }
        Ok(())
    }
}

impl Propagation for Unscented {
    fn step(&mut self, belief: &mut Belief, size: f64) -> Result<(), StepError> {
        let n = belief.estimated.len();
        self.factorise(&belief.covariance, n);
        self.run.keep();
        let outcome = self.step_from_points(belief, size);
        self.return_to(belief);
        outcome?;
        self.run.step(size)?;
        Self::write_end(&*self.run, &mut self.ended, &belief.inputs, belief, &mut self.center);
        let mean = &mut self.mean[..n];
        mean.fill(0.0);
        for column in 0..n {
            let rows = column * n..(column + 1) * n;
            let (odd, even) = (&mut self.odd[rows.clone()], &mut self.even[rows]);
            if self.factor[column * n + column] == 0.0 {
                odd.fill(0.0);
                even.fill(0.0);
                continue;
            }
            for (((odd, even), center), mean) in odd.iter_mut().zip(even).zip(&self.center).zip(&mut *mean) {
                let (ahead, behind) = (*odd - center, *even - center);
                *odd = (ahead - behind) / (2.0 * SPREAD_SQUARED.sqrt());
                *even = 0.5 * (ahead + behind);
                *mean += *even / SPREAD_SQUARED;
            }
        }
        for row in 0..n {
            for column in 0..=row {
                let products = (0..n).map(|k| {
                    let (odd, even) = (&self.odd[k * n..(k + 1) * n], &self.even[k * n..(k + 1) * n]);
                    odd[row] * odd[column] + even[row] * even[column] / SPREAD_SQUARED
                });
                let sum = products.sum::<f64>() + EXCESS * mean[row] * mean[column];
                belief.covariance[row * n + column] = sum;
                belief.covariance[column * n + row] = sum;
            }
        }
        belief.states.copy_from_slice(&self.ended);
        for (own, mean) in belief.estimated.iter().zip(mean) {
            if let Along::State(state) = own.along {
                belief.states[state] += *mean * own.nominal;
            }
        }
        Ok(())
    }

    fn move_to(&mut self, belief: &Belief) {
        self.run.move_states(&belief.states);
        self.run.set_inputs(&belief.inputs, &belief.still);
    }

    /// The slopes `h` follow from a regression over the points: `h*l_i = d_i`.
    fn outputs(&mut self, belief: &Belief, outputs: &mut Outputs) {
        let n = belief.estimated.len();
        self.factorise(&belief.covariance, n);
        self.run.values(&mut outputs.values);
        let Outputs { values, slopes, residuals } = outputs;
        residuals.fill(0.0);
        slopes.fill(0.0);
        self.mean.fill(0.0);
        self.run.keep();
        for column in 0..n {
            if self.factor[column * n + column] == 0.0 {
                continue;
            }
            for (side, distance) in [SPREAD_SQUARED.sqrt(), -SPREAD_SQUARED.sqrt()].into_iter().enumerate() {
                self.go_beside(belief, column, distance);
                self.run.values(&mut self.shown[side]);
            }
            let [ahead, behind] = &self.shown;
            for place in (0..values.len()).filter(|place| self.is_real[*place]) {
                let even = 0.5 * (ahead[place] + behind[place]) - values[place];
                slopes[place * n + column] = (ahead[place] - behind[place]) / (2.0 * SPREAD_SQUARED.sqrt());
                residuals[place] += even * even / SPREAD_SQUARED;
                self.mean[place] += even / SPREAD_SQUARED;
            }
        }
        self.return_to(belief);
        for place in (0..values.len()).filter(|place| self.is_real[*place]) {
            values[place] += self.mean[place];
            residuals[place] += EXCESS * self.mean[place] * self.mean[place];
            let row = &mut slopes[place * n..(place + 1) * n];
            for column in (0..n).rev() {
                let pivot = self.factor[column * n + column];
                let later = (column + 1..n).map(|k| row[k] * self.factor[k * n + column]);
                row[column] = if pivot == 0.0 { 0.0 } else { (row[column] - later.sum::<f64>()) / pivot };
            }
        }
    }

    fn save(&self) -> (Snapshot, &[f64]) {
        (self.run.save(), &[])
    }

    fn restore(&mut self, plant: &Snapshot, carried: &[f64]) -> Result<(), SnapshotError> {
        if !carried.is_empty() {
            return Err(SnapshotError::Lengths);
        }
        self.run.restore(plant)
    }
}
