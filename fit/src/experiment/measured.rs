//! Velocity and rest of a measured motion.

use super::Begin;
use crate::arrays::span;
use crate::parameter::Values;
use crate::record::Record;
use crate::smoothing::{noise, parabolas};

/// Multiple of its noise within which the position of a resting carriage stays.
const RESTING: f64 = 8.0;

/// Velocity at the communication points: measured, or the slope of the position over a width in s.
pub fn velocity(record: &Record, width: f64) -> Vec<f64> {
    if record.signals.contains_key("velocity") {
        return record.on_grid("velocity");
    }
    parabolas(&record.on_grid("position"), record.step, width).1
}

/// A signal at the communication points without its noise.
pub fn smoothed(record: &Record, signal: &str, width: f64) -> Vec<f64> {
    parabolas(&record.on_grid(signal), record.step, width).0
}

/// Samples at which the position stays within its noise over a width in s about them.
pub fn resting(record: &Record, width: f64) -> Vec<bool> {
    let position = record.of("position");
    let (half, limit) = (half(record, width), RESTING * noise(position));
    let about = |row: usize| &position[row.saturating_sub(half)..(row + half + 1).min(position.len())];
    (0..position.len()).map(|row| span(about(row)) <= limit).collect()
}

/// Start with the smoothed position and its slope; the velocity of a carriage at rest is exactly 0, and known.
pub fn begin(record: &Record, width: f64) -> Begin {
    let position = record.of("position");
    let first = &position[..(half(record, width) + 1).min(position.len())];
    let rests = span(first) <= RESTING * noise(position);
    let speed = if rests { 0.0 } else { velocity(record, width)[0] };
    let place = smoothed(record, "position", width)[0];
    let estimated = if rests || speed == 0.0 { &["position0"][..] } else { &["position0", "velocity0"] };
    Begin {
        values: Values::from([("position0".to_owned(), place), ("velocity0".to_owned(), speed)]),
        estimated: estimated.iter().map(|name| (*name).to_owned()).collect(),
    }
}

/// Samples to either side that a width in s spans.
fn half(record: &Record, width: f64) -> usize {
    ((0.5 * width / record.step).round_ties_even() as usize).max(1)
}
