//! A least-squares problem: estimated parameters, measured segments, sensors, and the simulation that they are compared with.

use crate::parameter::{Parameter, Values, values};
use crate::sensor::Sensor;

/// Standard deviation, in logarithms, of the weak Gaussian prior of a parameter without bounds: a factor of 4.5.
pub const PRIOR: f64 = 1.5;
/// Residual, in units of the noise, of a simulation that could not go on: worse than any of one that could.
pub const FAILED: f64 = 1e12;
/// Relative tolerance of the solver at which differences of runs are differences of parameters.
pub const TOLERANCE: f64 = 1e-6;
/// Step of the differences that make the Jacobian, in inner values, unless noise is smaller than its effect.
pub const STEP: f64 = 1e-3;

/// Somebody has asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

/// A simulation of measured segments.
pub trait Simulated {
    /// Measured minus simulated values for each vector, at the samples that are fitted: segment by segment, in it signal by
    /// signal. NaN where a run failed.
    ///
    /// # Errors
    /// [`Interrupted`].
    fn differences(&self, vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted>;

    /// The same of vectors near another one, for derivatives there: of a run of each, unless the run at that vector is
    /// differentiated.
    ///
    /// # Errors
    /// [`Interrupted`].
    fn near(&self, _x: &[f64], vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        self.differences(vectors, tolerance)
    }
}

/// A segment of a record, simulated in one go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Samples of each signal that are fitted.
    pub samples: usize,
    /// Start values of the simulation that are estimated along with the parameters.
    pub begins: usize,
    /// Number of the record that the segment belongs to.
    pub record: usize,
}

/// A problem. Its vector holds the inner values of the parameters, then of the start values of all segments,
/// measured in their magnitudes from their measured values: the first samples tell a start no better than all others, and its
/// error would pass into the parameters.
#[derive(Clone)]
pub struct Problem<'a> {
    /// Estimated parameters.
    pub parameters: Vec<Parameter>,
    /// Segments.
    pub segments: Vec<Segment>,
    /// Sensor of each compared signal.
    pub sensors: Vec<Sensor>,
    /// Simulation of the segments.
    pub simulated: &'a dyn Simulated,
    /// Step of the differences that make the Jacobian, in inner values.
    pub step: f64,
}

impl Problem<'_> {
    /// Length of the vector.
    pub fn dimension(&self) -> usize {
        self.parameters.len() + self.segments.iter().map(|segment| segment.begins).sum::<usize>()
    }

    /// Number of the residuals of the data.
    pub fn size(&self) -> usize {
        self.sensors.len() * self.segments.iter().map(|segment| segment.samples).sum::<usize>()
    }

    /// The vector of the start values.
    pub fn start(&self) -> Vec<f64> {
        let mut start: Vec<f64> = self.parameters.iter().map(|one| one.inner(one.start)).collect();
        start.resize(self.dimension(), 0.0);
        start
    }

    /// Values of the parameters by name.
    pub fn values(&self, x: &[f64]) -> Values {
        values(&self.parameters, x)
    }

    /// Lower and upper bounds of the vector.
    pub fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut low, mut high): (Vec<f64>, Vec<f64>) = self
            .parameters
            .iter()
            .map(|one| one.inner_bounds().into())
            .map(|(low, high): (f64, f64)| (low, high))
            .unzip();
        low.resize(self.dimension(), f64::NEG_INFINITY);
        high.resize(self.dimension(), f64::INFINITY);
        (low, high)
    }

    /// A function of sensor and difference at each difference.
    pub fn by_sensor(&self, differences: &[f64], of: impl Fn(&Sensor, f64) -> f64) -> Vec<f64> {
        let mut found = Vec::with_capacity(differences.len());
        for (sensor, range) in self.ranges() {
            found.extend(differences[range].iter().map(|difference| of(sensor, *difference)));
        }
        found
    }

    /// Sensors, and the places of the differences that they have made, in order.
    fn ranges(&self) -> impl Iterator<Item = (&Sensor, std::ops::Range<usize>)> {
        let mut first = 0;
        let pairs =
            self.segments.iter().flat_map(|segment| self.sensors.iter().map(move |sensor| (sensor, segment.samples)));
        pairs.map(move |(sensor, samples)| {
            let range = first..first + samples;
            first = range.end;
            (sensor, range)
        })
    }

    /// Residuals of the data in units of the noise.
    pub fn residuals(&self, differences: &[f64]) -> Vec<f64> {
        self.by_sensor(differences, |sensor, difference| {
            let residual = sensor.residual(difference);
            if residual.is_finite() { residual } else { FAILED }
        })
    }

    /// Derivatives of the residuals of the weak Gaussian priors. Too weak to be felt where the data tell a value, they keep
    /// parameters that are not identifiable from running away.
    pub fn prior_slopes(&self) -> Vec<f64> {
        let slope = |one: &Parameter| if one.is_logarithmic() && !one.is_bounded { 1.0 / PRIOR } else { 0.0 };
        let mut slopes: Vec<f64> = self.parameters.iter().map(slope).collect();
        slopes.resize(self.dimension(), 0.0);
        slopes
    }

    /// Residuals of the priors.
    pub fn prior(&self, x: &[f64]) -> Vec<f64> {
        let start = self.start();
        self.prior_slopes().iter().zip(x).zip(&start).map(|((slope, x), start)| slope * (x - start)).collect()
    }

    /// Sensors with the noise that makes differences most likely; a sensor whose signal cannot be simulated stays.
    pub fn likely_sensors(&self, differences: &[f64]) -> Vec<Sensor> {
        let mut by_signal = vec![Vec::new(); self.sensors.len()];
        for (place, (_, range)) in self.ranges().enumerate() {
            by_signal[place % self.sensors.len()].extend_from_slice(&differences[range]);
        }
        let likely = |(sensor, differences): (&Sensor, Vec<f64>)| {
            if differences.iter().all(|value| value.is_finite()) { sensor.with_noise_of(&differences) } else { *sensor }
        };
        self.sensors.iter().zip(by_signal).map(likely).collect()
    }

    /// Number of the block of each sample: about `number` blocks of time, all signals of a time together. As many segments
    /// as blocks are not cut: what happens in one has no part in the next.
    pub fn blocks(&self, number: usize) -> Vec<usize> {
        let total: usize = self.segments.iter().map(|segment| segment.samples).sum();
        let size = total.div_ceil(number).max(1);
        let is_whole = self.segments.len() >= number;
        let (mut before, mut labels) = (0, Vec::with_capacity(self.size()));
        for segment in &self.segments {
            for _ in &self.sensors {
                labels.extend((0..segment.samples).map(|row| (before + if is_whole { 0 } else { row }) / size));
            }
            before += segment.samples;
        }
        let mut known = labels.clone();
        known.sort_unstable();
        known.dedup();
        labels.iter().map(|label| known.partition_point(|other| other < label)).collect()
    }

    /// Number of the record of each sample.
    pub fn records(&self) -> Vec<usize> {
        let of = |segment: &Segment| std::iter::repeat_n(segment.record, segment.samples * self.sensors.len());
        self.segments.iter().flat_map(of).collect()
    }
}
