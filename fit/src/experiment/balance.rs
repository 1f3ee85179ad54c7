//! The balance of forces along a measured motion: a start for laws whose friction depends on its history.

use std::sync::Arc;

use super::cylinder::{middle, on_grids};
use super::force::Force;
use super::mechanical::Mechanical;
use super::pushed::{Pushed, direction};
use super::{Begin, Experiment, Forces, Given, MeasuredSegment, Whole};
use crate::arrays::{gradient, interpolate, quantile};
use crate::parameter::Values;
use crate::record::{Record, Signals};
use crate::smoothing::{follow, noise, parabolas};

/// The signal that is compared, whose measured value is 0.
const BALANCE: &str = "balance";
/// Share of the fastest velocity above which the noise of a velocity between two samples is smoothed away.
const LOUD: f64 = 0.01;

/// A mass that goes as its position was measured; the force, its friction and its inertia are in balance.
///
/// ```text
/// 0 = W[applied - friction] - mass*W''[position]
/// ```
///
/// `W` is a weighted mean over four widths, a cubic B-spline, and `W''` the same mean of the acceleration, after two integrations
/// by parts: nothing is differentiated (M. Shinbrot's modulating functions). Friction follows the law along the measured motion,
/// with its history, so that no record is cut, errors of the force do not add up, and the search has few local minima. The noise
/// of the position passes into the friction: what is found is a start.
pub struct Balance {
    given: Given,
    inner: Box<dyn Pushed>,
}

impl Balance {
    /// The balance of an experiment whose mass is moved by measured forces; nothing of another one.
    pub fn of(given: &Given) -> Option<Self> {
        let inner: Box<dyn Pushed> = match given.kind.name {
            "force" => Box::new(Force::new(given.clone()).ok()?),
            "mechanical" => Box::new(Mechanical::new(given.clone())),
            _ => return None,
        };
        Some(Self { given: given.clone(), inner })
    }

    /// A whole record as a segment, with two communication points a step.
    pub fn segment(&self, record: &Record, is_validation: &[bool]) -> MeasuredSegment {
        let points = record.grid.len();
        let time: Vec<f64> = (0..2 * points - 1).map(|point| 0.5 * record.step * point as f64).collect();
        let halved = |signal: &String| {
            (signal.clone(), interpolate(time.iter().copied(), &record.grid, &record.on_grid(signal)))
        };
        let mut signals: Signals = record.signals.keys().map(halved).collect();
        signals.insert(BALANCE.to_owned(), vec![0.0; time.len()]);
        let (driven, inner, _) = self.prepare(record);
        let last = is_validation.len() - 1;
        let used = (0..time.len()).map(|half| half % 2 == 0 && inner[half / 2] && !is_validation[(half / 2).min(last)]);
        let whole = Arc::new(Whole { begin: 0.0, grid: record.grid.clone(), driven: driven.clone() });
        MeasuredSegment {
            used: used.collect(),
            is_validation: vec![false; time.len()],
            record: Record::new(time, record.begin, signals),
            driven,
            begin: Begin::default(),
            number: 0,
            whole,
        }
    }
}

impl Experiment for Balance {
    fn given(&self) -> &Given {
        &self.given
    }

    fn compared(&self) -> &[&'static str] {
        &[BALANCE]
    }

    fn driving(&self) -> Vec<&'static str> {
        vec![]
    }

    fn outputs(&self) -> Vec<&'static str> {
        vec!["frictionForce"]
    }

    /// Smooths a position whose noise would be a motion of its own; leaves out the ends, which have no mean.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>) {
        let (mut driven, width, step) = (on_grids(record), self.given.options.width, record.step);
        driven.insert("direction".to_owned(), direction(&self.given, record));
        let error = noise(record.of("position"));
        let mut position = driven["position"].clone();
        let pace: Vec<f64> = gradient(&position, step).iter().map(|speed| speed.abs()).collect();
        if 2f64.sqrt() * error / step > LOUD * quantile(&pace, 0.98) {
            position = parabolas(&position, step, width).0;
        }
        let from: Vec<f64> = position.iter().map(|place| place - position[0]).collect();
        driven.insert("path".to_owned(), follow(&from, 3.0 * error));
        let (points, edge) = (position.len(), 2 * samples(step, width) + 1);
        let used = (0..points).map(|point| (edge..points.saturating_sub(edge)).contains(&point)).collect();
        driven.insert("position".to_owned(), position);
        (driven, used, vec![])
    }

    fn begin(&self, _: &Record, _: &Signals) -> Begin {
        Begin::default()
    }

    /// The position at the end of each half step, and the load factor.
    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)> {
        let gain = self.given.beside("gain.position", values, 1.0);
        let path: Vec<f64> = segment.driven["path"].iter().map(|place| gain * place).collect();
        let level = self.inner.level(&steps(segment), values);
        let last = path.len() - 1;
        let end = |point: usize| path[(point + 1).min(last)];
        // On straight lines from where the whole steps begin.
        let place = |half: usize| match half % 2 {
            0 => 0.5 * (path[half / 2] + end(half / 2)),
            _ => end(half / 2),
        };
        let halves = 0..2 * path.len() - 1;
        vec![
            ("prescribedPosition", halves.clone().map(place).collect()),
            ("friction.level", halves.map(|half| level[half / 2]).collect()),
        ]
    }

    /// Starts at rest at the first sample.
    fn settings(&self, _: &MeasuredSegment, values: &Values) -> Values {
        let prescribed = self.given.item("bench.drive", "PrescribedPosition");
        self.given.run(values, &[("bench.drive", prescribed), ("driveVelocity", 0.0), ("position0", 0.0)])
    }

    /// Minus the residual of the balance, which takes the place of a simulation.
    ///
    /// Friction is taken in the middle of each step: at its ends the velocity leaps, and damping with it.
    fn predict(&self, segment: &MeasuredSegment, outputs: Vec<Vec<f64>>, values: &Values) -> Vec<Vec<f64>> {
        let applied = self.inner.applied(&steps(segment), values);
        let applied = if self.inner.has_lines() { middle(&applied) } else { applied };
        let step = 2.0 * segment.record.step;
        let position = self.given.truth("position", segment.driven["position"].clone(), values);
        let size = samples(step, self.given.options.width);
        let friction = outputs[0].iter().skip(1).step_by(2);
        let middles: Vec<f64> = applied.iter().zip(friction).map(|(applied, friction)| applied - friction).collect();
        let inner = middles.windows(2).map(|pair| 0.5 * (pair[1] + pair[0]));
        let rest: Vec<f64> = std::iter::once(middles[0]).chain(inner).chain([middles[middles.len() - 1]]).collect();
        let mass = self.inner.inertia(values);
        let means = moving_mean(&moving_mean(&rest, size), size);
        let lacking: Vec<f64> = accelerated(&position, size, step)
            .iter()
            .zip(means)
            .map(|(acceleration, mean)| mass * acceleration - mean)
            .collect();
        vec![(0..2 * lacking.len() - 1).map(|half| lacking[half / 2]).collect()]
    }

    fn forces(&self, _: &MeasuredSegment, _: &Values) -> Option<Forces> {
        None
    }
}

/// A segment with one communication point a step.
fn steps(segment: &MeasuredSegment) -> MeasuredSegment {
    let record = &segment.record;
    let halved = |values: &[f64]| values.iter().step_by(2).copied().collect::<Vec<f64>>();
    let signals = record.signals.iter().map(|(signal, values)| (signal.clone(), halved(values))).collect();
    MeasuredSegment { record: Record::new(halved(&record.time), record.begin, signals), ..segment.clone() }
}

/// Samples of a mean: an odd number, a quarter of a width.
fn samples(step: f64, width: f64) -> usize {
    2 * ((0.125 * width / step).round_ties_even() as usize).max(1) + 1
}

/// A moving mean; beyond its ends a signal is what it is there.
fn moving_mean(values: &[f64], size: usize) -> Vec<f64> {
    let (half, last) = (size / 2, values.len() - 1);
    let at = |place: usize| values[place.saturating_sub(half).min(last)];
    (0..values.len()).map(|point| (point..point + size).map(at).sum::<f64>() / size as f64).collect()
}

/// The mean acceleration: second differences, over the size of a mean, of the mean position.
fn accelerated(position: &[f64], size: usize, step: f64) -> Vec<f64> {
    let mean = moving_mean(&moving_mean(position, size), size);
    let (last, whole) = (mean.len() - 1, size as f64 * step);
    let second = |point: usize| {
        let (after, before) = (mean[(point + size).min(last)], mean[point.saturating_sub(size)]);
        (after - 2.0 * mean[point] + before) / (whole * whole)
    };
    (0..=last).map(second).collect()
}
