//! Experiments whose mass is moved by measured forces.

use super::{Experiment, Given, MeasuredSegment, measured};
use crate::arrays::interpolate;
use crate::parameter::Values;
use crate::record::Record;
use crate::smoothing::noise;

/// Friction outwards over friction inwards.
pub const FACTOR: &str = "friction.direction.factor";
/// Multiple of the noise of its readings within which a smoothed velocity is at rest.
const RESTING: f64 = 8.0;
/// Length in s of segments, unless another is given.
///
/// The noise of a force adds up in the position; noise of pressures to a tenth of a millimetre in half a second at 0.5 kPa. Each
/// short segment begins anew, and the scatter among the many segments tells how far noise moves the parameters.
pub const LENGTH: f64 = 0.15;

/// An experiment whose mass is moved by forces that are measured.
pub trait Pushed: Experiment {
    /// Force on the mass but for its friction, at the communication points.
    fn applied(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64>;

    /// Load factor at the communication points.
    fn level(&self, segment: &MeasuredSegment, values: &Values) -> Vec<f64>;

    /// The mass.
    fn inertia(&self, values: &Values) -> f64;
}

/// Sign of the measured velocity at the communication points; 0 where the mass rests.
pub fn direction(given: &Given, record: &Record) -> Vec<f64> {
    let width = given.options.width;
    let (speed, resting) = if record.signals.contains_key("position") {
        (measured::velocity(record, width), measured::resting(record, width))
    } else {
        let speed = measured::smoothed(record, "velocity", width);
        let limit = RESTING * noise(record.of("velocity"));
        let seen = interpolate(record.time.iter().copied(), &record.grid, &speed);
        (speed, seen.into_iter().map(|speed| speed.abs() <= limit).collect())
    };
    let (pace, last) = (given.pace(), record.time.len() - 1);
    let sign = |(time, speed): (&f64, &f64)| {
        let at = record.time.partition_point(|sample| *sample < time - 1e-6 * record.step).min(last);
        let speed = pace * speed;
        if resting[at] || speed == 0.0 { 0.0 } else { speed.signum() }
    };
    record.grid.iter().zip(&speed).map(sign).collect()
}

/// A load factor with the factor by direction: of the motion, or at rest of the applied force.
pub fn directed(experiment: &dyn Pushed, mut level: Vec<f64>, segment: &MeasuredSegment, values: &Values) -> Vec<f64> {
    let factor = experiment.given().beside(FACTOR, values, 1.0);
    if factor == 1.0 {
        return level;
    }
    let applied = experiment.applied(segment, values);
    for ((level, moving), applied) in level.iter_mut().zip(&segment.driven["direction"]).zip(applied) {
        if (if *moving == 0.0 { applied } else { *moving }) > 0.0 {
            *level *= factor;
        }
    }
    level
}
