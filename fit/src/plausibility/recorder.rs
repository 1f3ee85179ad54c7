//! Faults of converters and recorders: clipped readings, samples that are lost or repeated.

use super::{Facts, Finding, Remedy, Source};
use crate::arrays::{differences, extremes, mean, median};
use crate::numerals::significant;
use crate::smoothing::noise;

/// Readings in a row at the very end of a signal that are no chance where readings differ otherwise.
const LONG: usize = 8;
/// A signal with noise repeats a reading for at most this share of its samples, and turns for at least that one.
const RARELY: f64 = 0.2;
const OFTEN: f64 = 0.1;
/// Samples before and after a leap in which a carriage that moved by itself would have moved, too.
const NEAR: usize = 3;
/// Ratios of a leap to the steps near it and to the noise, and its least share of the way.
const LEAP: f64 = 10.0;
const LOUD: f64 = 20.0;
const SMALL: f64 = 0.01;
/// Least step over the largest near a leap, where steps are alike; a leap by this ratio is then enough: no mass is that fast for one
/// sample.
const STEADY: f64 = 0.5;
const DROPPED: f64 = 2.5;
/// Share of the way, samples, and smallest steps of a position that leaves its end at speed: it was clipped. The share is compared with
/// the way in as many samples after them.
const ABRUPT: f64 = 0.7;
const AHEAD: usize = 5;
const COARSE: f64 = 4.0;
/// Between samples farther apart, in s, a carriage that has rested may well be at speed.
const QUICK: f64 = 5e-3;
/// Ratio of an interval to the usual one that shows lost samples.
const MISSING: f64 = 1.5;
/// Share of irregular intervals from which samples count as uneven.
const FEW: f64 = 0.1;
/// Repeated rows are no chance beyond this multiple of the expected number, and beyond this number.
const CHANCE: f64 = 5.0;
const CERTAIN: f64 = 5.0;
/// Signals of a controller, which may stay at an end, leap, and be repeated.
const ASKED: [&str; 3] = ["time", "valveVoltage", "supplyPressure"];

/// Likely effects of a recorder on a record, and notes on harmless ones.
pub fn recorder(facts: &Facts<'_>, source: &Source<'_>) -> (Vec<Finding>, Vec<String>) {
    let Some(time) = source.signals.get("time") else { return (vec![], vec![]) };
    let mut found = Vec::new();
    let is_quick = time.len() > 1 && median(&differences(time)) <= QUICK;
    for (signal, values) in source.signals.iter().filter(|(signal, _)| !ASKED.contains(&signal.as_str())) {
        let mut ends = clipped(values);
        if signal == "position" && is_quick {
            for end in stopped(values) {
                ends.retain(|other| other.0 != end.0);
                ends.push(end);
            }
        }
        for (end, count) in ends {
            let first = longest(values, end).0;
            let (unit, place) = (facts.si(signal), (source.place)(signal, first));
            let text = format!(
                "{}: {signal} stays at {} {unit}, the end of what it reads, for {count} samples, as from {} s ({place}): \
                 is its range too small, so that it is clipped there?",
                source.name,
                significant(end, 6),
                significant(time[first], 6),
            );
            let rows = (0..values.len()).filter(|row| values[*row] == end).collect();
            found.push(Finding::doubted(signal, text, vec![Remedy::Remove { signal: signal.clone(), rows }]));
        }
    }
    found.extend(leap(facts, source, time));
    found.extend(repeats(source));
    (found, missing(source, time).into_iter().collect())
}

/// Each end at which a signal with noise stays for many samples in a row, and the number of its samples there.
///
/// A signal at rest repeats its reading, and so does a signal without noise: neither is called clipped.
fn clipped(values: &[f64]) -> Vec<(f64, usize)> {
    if values.len() < 4 * LONG {
        return vec![];
    }
    let (low, high) = extremes(values);
    let is_end = |value: f64| value == low || value == high;
    let inner = values.windows(2).filter(|pair| !(is_end(pair[0]) && is_end(pair[1])));
    if !has_noise(&inner.map(|pair| pair[1] - pair[0]).collect::<Vec<_>>()) {
        return vec![];
    }
    // A signal at rest, or unloaded, is exactly 0.
    let ends = [high, low].into_iter().filter(|end| *end != 0.0 && longest(values, *end).1 >= LONG);
    ends.map(|end| (end, at(values, end))).collect()
}

/// Each end at which a position stops dead and from which it leaves at full speed, and the number of its samples there.
///
/// A carriage leaves an end stop from rest, and goes farther in the next few samples than in the first; one that was
/// behind the end of a sensor's range comes back at speed.
fn stopped(position: &[f64]) -> Vec<(f64, usize)> {
    if position.len() < 4 * LONG {
        return vec![];
    }
    let steps: Vec<f64> = differences(position).into_iter().map(f64::abs).collect();
    let (low, high) = extremes(position);
    // A converter moves by whole steps of its own.
    let smallest = steps.iter().copied().filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let floor = (AHEAD as f64 * extremes(&steps).1 / LEAP).max(COARSE * smallest);
    let way = |from: usize| (position[from + AHEAD] - position[from]).abs();
    let is_abrupt = |leaving: &usize| {
        let (first, second) = (way(*leaving), way(leaving + AHEAD));
        first > ABRUPT * second && first > floor
    };
    let leaves_abruptly = |end: &f64| {
        let long = runs(position.iter().map(|value| value == end)).into_iter().filter(|(_, length)| *length >= LONG);
        let leaving: Vec<usize> = long.map(|(first, length)| first + length).collect();
        let leaving: Vec<usize> = leaving.into_iter().filter(|place| place + 2 * AHEAD < position.len()).collect();
        !leaving.is_empty() && 2 * leaving.iter().filter(|place| is_abrupt(place)).count() >= leaving.len()
    };
    [high, low].into_iter().filter(leaves_abruptly).map(|end| (end, at(position, end))).collect()
}

/// Samples after which a position leaps as nothing with a mass does, at the usual interval.
fn leaps(time: &[f64], position: &[f64]) -> Vec<usize> {
    let (signed, intervals) = (differences(position), differences(time));
    if signed.len() < 4 * NEAR {
        return vec![];
    }
    let (noise, usual) = (noise(position), MISSING * median(&intervals));
    let (low, high) = extremes(position);
    let least = (LOUD * noise).max(SMALL * (high - low));
    let is_leap = |row: &usize| {
        let step = signed[*row];
        let beside = || (row.saturating_sub(NEAR)..=(row + NEAR).min(signed.len() - 1)).filter(|place| place != row);
        let others = beside().map(|place| signed[place].abs()).fold(0.0, f64::max);
        let one_way = beside().map(|place| signed[place] * step.signum()).fold(f64::INFINITY, f64::min);
        let step = step.abs();
        let is_far = step > LEAP * others && step > least;
        let is_dropped = one_way > STEADY * others && step > DROPPED * others && step - others > LOUD * noise;
        (is_far || is_dropped) && intervals[*row] < usual
    };
    (0..signed.len()).filter(is_leap).collect()
}

fn leap(facts: &Facts<'_>, source: &Source<'_>, time: &[f64]) -> Option<Finding> {
    let position = source.signals.get("position")?;
    let found = leaps(time, position);
    let first = *found.first()?;
    let more = if found.len() > 1 { format!(", and at {} more", found.len() - 1) } else { String::new() };
    let text = format!(
        "{}: position leaps by {} {} within one sample, at {} s{more}, as no mass does: were samples dropped, and time \
         counted on? Give the time as it was recorded, or cut the record there",
        (source.place)("position", first + 1),
        significant(position[first + 1] - position[first], 4),
        facts.si("position"),
        significant(time[first + 1], 6),
    );
    Some(Finding::doubted("position", text, vec![]))
}

/// Rows that all signals together repeat more often than each by itself makes likely.
///
/// A machine at rest repeats all that has no noise, for long; a recorder that has lost samples does so for a few.
fn repeats(source: &Source<'_>) -> Option<Finding> {
    let own = source.signals.iter().filter(|(signal, _)| !ASKED.contains(&signal.as_str()));
    let steps: Vec<Vec<f64>> = own.map(|(_, values)| differences(values)).collect();
    let rows = steps.iter().map(Vec::len).min().filter(|rows| steps.len() > 1 && *rows > 0)?;
    let every: Vec<bool> = (0..rows).map(|row| steps.iter().all(|steps| steps[row] == 0.0)).collect();
    let others = |steps: &Vec<f64>| (0..rows).filter(|row| !every[*row]).map(|row| steps[row]).collect::<Vec<_>>();
    if !steps.iter().any(|steps| has_noise(&others(steps))) {
        return None;
    }
    let chance: f64 = steps.iter().map(|steps| share(&others(steps), |step| step == 0.0)).product();
    let mut short = runs(every.iter().copied());
    short.retain(|(_, length)| *length < LONG);
    let count: usize = short.iter().map(|(_, length)| length).sum();
    (count as f64 > CERTAIN + CHANCE * rows as f64 * chance).then(|| {
        let place = (source.place)("time", short[0].0 + 1);
        let text = format!(
            "{}: {count} rows repeat the one before, the first {place}, though signals have noise: has the recorder lost \
             samples, and held the last ones?",
            source.name
        );
        let rows = short.iter().flat_map(|(first, length)| first + 1..=first + length).collect();
        Finding::doubted("time", text, vec![Remedy::Remove { signal: "time".to_owned(), rows }])
    })
}

fn missing(source: &Source<'_>, time: &[f64]) -> Option<String> {
    let intervals = differences(time);
    if intervals.is_empty() {
        return None;
    }
    let usual = median(&intervals);
    let wide: Vec<usize> = (0..intervals.len()).filter(|row| intervals[*row] > MISSING * usual).collect();
    if wide.is_empty() || wide.len() as f64 > FEW * intervals.len() as f64 {
        return None;
    }
    let count: f64 = wide.iter().map(|row| (intervals[*row] / usual).round_ties_even() - 1.0).sum();
    let place = (source.place)("time", wide[0] + 1);
    Some(format!(
        "{}: {count} samples are missing, the first before {place}; single ones are bridged on straight lines",
        source.name
    ))
}

/// Whether steps from sample to sample show noise that the converter resolves.
fn has_noise(steps: &[f64]) -> bool {
    let turns: Vec<f64> = steps.windows(2).map(|pair| pair[0] * pair[1]).collect();
    share(&turns, |turn| turn < 0.0) > OFTEN && share(steps, |step| step == 0.0) < RARELY
}

/// Share of the values that are something; 0 of none.
fn share(values: &[f64], is: impl Fn(f64) -> bool) -> f64 {
    if values.is_empty() { 0.0 } else { mean(&values.iter().map(|value| f64::from(is(*value))).collect::<Vec<_>>()) }
}

/// Number of samples that are at an end.
fn at(values: &[f64], end: f64) -> usize {
    values.iter().filter(|value| **value == end).count()
}

/// First sample and length of the longest run at an end.
fn longest(values: &[f64], end: f64) -> (usize, usize) {
    let runs = runs(values.iter().map(|value| *value == end));
    runs.into_iter().rev().max_by_key(|(_, length)| *length).unwrap_or_default()
}

/// First sample and length of each run.
fn runs(inside: impl Iterator<Item = bool>) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (row, _) in inside.enumerate().filter(|(_, is_inside)| *is_inside) {
        match found.last_mut() {
            Some((first, length)) if *first + *length == row => *length += 1,
            _ => found.push((row, 1)),
        }
    }
    found
}
