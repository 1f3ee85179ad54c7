//! Records as segments that are simulated in one go.

use std::sync::Arc;

use super::{Experiment, MeasuredSegment, Whole};
use crate::record::{Record, Signals};

/// Fewest samples of a segment.
const SHORTEST: usize = 10;
/// The same of points, of which each is a motion of its own.
const FEWEST_POINTS: usize = 2;

/// Segments of a record.
pub struct OfRecord {
    /// First sample of each segment in its record, and the segment.
    pub segments: Vec<(usize, MeasuredSegment)>,
    /// Notes on the preparation of its signals.
    pub notes: Vec<String>,
}

/// Cuts a record into segments, whose samples in the last share of the record are validation data; a share of 1 makes all of
/// them validation data. `is_named` tells which start values are fixed or estimated elsewhere. No segment, if none would have
/// enough samples.
pub fn segments(
    experiment: &dyn Experiment,
    record: &Record,
    number: usize,
    validation: f64,
    is_named: &dyn Fn(&str) -> bool,
) -> OfRecord {
    let given = experiment.given();
    let limit = record.time[record.time.len() - 1] * (1.0 - validation);
    let cuts = cuts(experiment, record);
    let is_whole = cuts == [0, record.time.len()];
    let (driven, used, noted) = experiment.prepare(record);
    let mut notes = noted;
    let shortest = if experiment.is_steady() { FEWEST_POINTS } else { SHORTEST };
    let whole =
        |begin: f64, driven: &Signals| Arc::new(Whole { begin, grid: record.grid.clone(), driven: driven.clone() });
    let mut of_part = |ends: &[usize]| {
        let (first, last) = (ends[0], ends[1]);
        let (part, driven, used) = if is_whole {
            (record.clone(), driven.clone(), used.clone())
        } else {
            let part = record.part(first, last);
            let (driven, used, noted) = experiment.prepare(&part);
            notes.extend(noted);
            (part, driven, used)
        };
        let begin = record.time[first];
        let is_late = |time: &f64| validation >= 1.0 || (validation > 0.0 && time + begin > limit);
        let mut is_validation: Vec<bool> = part.time.iter().map(is_late).collect();
        let fitted = (0..used.len()).filter(|row| used[*row] && !is_validation[*row]).max();
        if fitted.is_some_and(|last| last + 1 < shortest) {
            // The rest of a part is too short to be run.
            is_validation.fill(true);
        }
        let mut start = given.corrected(experiment.begin(&part, &driven));
        start.values.retain(|name, _| !is_named(name));
        start.estimated.retain(|name| !is_named(name));
        (first, begin, part, driven, used, is_validation, start)
    };
    let parts: Vec<_> = cuts.windows(2).filter(|ends| ends[1] - ends[0] >= shortest).map(&mut of_part).collect();
    let segment = |(first, begin, record, own, used, is_validation, start)| {
        let whole = whole(begin, &driven);
        (first, MeasuredSegment { record, driven: own, used, is_validation, begin: start, number, whole })
    };
    OfRecord { segments: parts.into_iter().map(segment).collect(), notes }
}

/// First samples of the segments, and the end. A segment begins where the carriage rests, if it does within half a length:
/// there its velocity is known to be 0.
fn cuts(experiment: &dyn Experiment, record: &Record) -> Vec<usize> {
    let samples = record.time.len();
    let Some(length) = experiment.length(record.step) else { return vec![0, samples] };
    let end = record.time[samples - 1];
    let number = ((end / length).round_ties_even()).max(1.0) as usize;
    if number == 1 {
        return vec![0, samples];
    }
    let resting = experiment.resting(record);
    let cut = |part: usize| {
        let time = end * part as f64 / number as f64;
        let distance = |row: &usize| (record.time[*row] - time).abs();
        let near = (0..samples).filter(|row| resting[*row] && distance(row) <= 0.5 * length);
        let nearest = near.min_by(|one, other| distance(one).total_cmp(&distance(other)));
        nearest.unwrap_or_else(|| record.time.partition_point(|sample| *sample < time))
    };
    std::iter::once(0).chain((1..number).map(cut)).chain([samples]).collect()
}
