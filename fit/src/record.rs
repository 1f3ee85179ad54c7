//! Records: measured signals over time without gaps, ready to be compared.

use std::collections::BTreeMap;

use crate::arrays::{differences, interpolate, median, span};
use crate::refused::Refused;

/// Intervals longer than a multiple of the usual one, and than a time in s, split a record: a few lost samples cost less than a new
/// beginning costs.
const GAP: f64 = 5.0;
const LOST: f64 = 0.02;
/// Samples without which a record tells too little.
const SHORTEST: usize = 50;
/// Points without which a table tells too little.
const FEWEST_POINTS: usize = 5;

/// SI units of signals.
pub const UNITS: [(&str, &str); 12] = [
    ("time", "s"),
    ("position", "m"),
    ("velocity", "m/s"),
    ("frictionForce", "N"),
    ("force", "N"),
    ("normalForce", "N"),
    ("pressure", "Pa"),
    ("valveVoltage", "V"),
    ("supplyPressure", "Pa"),
    ("externalForce", "N"),
    ("chamberA.pressure", "Pa"),
    ("chamberB.pressure", "Pa"),
];

/// SI unit of a signal.
pub fn unit_of(signal: &str) -> &'static str {
    UNITS.iter().find(|(name, _)| *name == signal).map_or("1", |(_, unit)| *unit)
}

/// Signals by name, in SI units.
pub type Signals = BTreeMap<String, Vec<f64>>;

/// Measured signals, sampled without gaps.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Times in s, from 0.
    pub time: Vec<f64>,
    /// Time in s of the table that is 0 here.
    pub begin: f64,
    /// The usual interval between samples in s.
    pub step: f64,
    /// Communication points of a simulation in s: the usual interval, up to the end.
    pub grid: Vec<f64>,
    /// Signals without time.
    pub signals: Signals,
}

impl Record {
    /// A record from times that begin with 0.
    pub fn new(time: Vec<f64>, begin: f64, signals: Signals) -> Self {
        let step = median(&differences(&time));
        let last = (time[time.len() - 1] / step + 1e-6).floor() as usize;
        let grid = (0..=last).map(|point| point as f64 * step).collect();
        Self { time, begin, step, grid, signals }
    }

    /// Samples of a signal.
    ///
    /// # Panics
    /// If it is not measured.
    pub fn of(&self, signal: &str) -> &[f64] {
        self.signals.get(signal).unwrap_or_else(|| panic!("the record has no {signal}"))
    }

    /// A signal at the communication points, on straight lines between its samples.
    pub fn on_grid(&self, signal: &str) -> Vec<f64> {
        interpolate(self.grid.iter().copied(), &self.time, self.of(signal))
    }

    /// Samples from one index up to another.
    pub fn part(&self, first: usize, last: usize) -> Self {
        let start = self.time[first];
        let signals = self.signals.iter().map(|(name, values)| (name.clone(), values[first..last].to_vec())).collect();
        Self::new(self.time[first..last].iter().map(|time| time - start).collect(), self.begin + start, signals)
    }
}

/// Splits signals at gaps: the records, and notes on the parts that are too short.
///
/// # Errors
/// [`Refused`] for data that are no signals over time, or of which nothing can be learned.
pub fn split(name: &str, mut signals: Signals) -> Result<(Vec<Record>, Vec<String>), Refused> {
    let time = signals.remove("time").ok_or_else(|| Refused(format!("{name}: there is no time")))?;
    for (signal, values) in &signals {
        if values.len() != time.len() {
            return Err(Refused(format!("{name}: {signal} has {} samples, time {}", values.len(), time.len())));
        }
        check_finite(name, signal, values, "sample")?;
    }
    check_finite(name, "time", &time, "sample")?;
    if time.len() < 2 {
        return Err(Refused(format!("{name}: too short, a single sample; at least {SHORTEST} are needed")));
    }
    let intervals = differences(&time);
    if let Some(row) = intervals.iter().position(|interval| *interval <= 0.0) {
        let (here, before) = (time[row + 1], time[row]);
        return Err(Refused(format!("{name}, sample {}: time must rise, but {here} s follows {before} s", row + 1)));
    }
    let long = (GAP * median(&intervals)).max(LOST);
    let gaps = intervals.iter().enumerate().filter(|(_, interval)| **interval > long).map(|(row, _)| row + 1);
    let ends: Vec<usize> = std::iter::once(0).chain(gaps).chain([time.len()]).collect();
    let begin = time[0];
    let whole = Record::new(time.iter().map(|time| time - begin).collect(), begin, signals);
    let pieces = ends.windows(2).map(|ends| (ends[0], ends[1]));
    let used: Vec<(usize, usize)> = pieces.clone().filter(|(first, last)| last - first >= SHORTEST).collect();
    if used.is_empty() {
        let most = pieces.map(|(first, last)| last - first).max().unwrap_or(0);
        return Err(Refused(format!(
            "{name}: too short, {most} samples without a gap; at least {SHORTEST} are needed"
        )));
    }
    let number = ends.len() - 1;
    let notes = match number {
        1 => vec![],
        _ => vec![format!("split at {} gaps, {} pieces too short to use", number - 1, number - used.len())],
    };
    Ok((used.into_iter().map(|(first, last)| whole.part(first, last)).collect(), notes))
}

/// Points without a time as a record, whose times number them.
///
/// # Errors
/// [`Refused`] for points of which nothing can be learned, and for values that are no numbers.
pub fn points(name: &str, signals: Signals) -> Result<Record, Refused> {
    let velocity = signals.get("velocity").ok_or_else(|| Refused(format!("{name}: there is no velocity")))?;
    let number = velocity.len();
    for (signal, values) in &signals {
        if values.len() != number {
            return Err(Refused(format!("{name}: {signal} has {} points, velocity {number}", values.len())));
        }
        check_finite(name, signal, values, "point")?;
    }
    if number < FEWEST_POINTS {
        return Err(Refused(format!("{name}: too few points, {number}; at least {FEWEST_POINTS} are needed")));
    }
    if velocity.iter().all(|velocity| *velocity == 0.0) {
        return Err(Refused(format!(
            "{name}: velocity = 0 m/s at all points: friction at rest answers the drive; measure while it slides"
        )));
    }
    Ok(Record::new((0..number).map(|place| place as f64).collect(), 0.0, signals))
}

/// Refuses values that are no numbers.
fn check_finite(name: &str, signal: &str, values: &[f64], row: &str) -> Result<(), Refused> {
    let Some(place) = values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    Err(Refused(format!("{name}: {signal} is {} at {row} {place}; correct or remove the row", values[place])))
}

/// Refuses a motion that never changes in any of the records.
///
/// # Errors
/// [`Refused`].
pub fn check_motion(records: &[Record]) -> Result<(), Refused> {
    for signal in ["position", "velocity"] {
        let mut courses = records.iter().filter_map(|record| record.signals.get(signal)).peekable();
        if courses.peek().is_some() && courses.all(|course| span(course) == 0.0) {
            return Err(Refused(format!(
                "{signal} never changes: all at rest, so that nothing can be learned of friction"
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals(time: Vec<f64>) -> Signals {
        let position = time.iter().map(|time| libm::sin(*time)).collect();
        [("time".to_owned(), time), ("position".to_owned(), position)].into()
    }

    #[test]
    fn a_table_is_split_at_gaps_and_short_pieces_are_told() {
        let piece = |begin: f64, count: u32| (0..count).map(move |k| begin + 0.01 * f64::from(k));
        let time: Vec<f64> = piece(1.0, 60).chain(piece(3.0, 20)).chain(piece(5.0, 80)).collect();
        let (records, notes) = split("rig.csv", signals(time)).expect("two records");
        assert_eq!(
            records.iter().map(|record| (record.begin, record.time.len())).collect::<Vec<_>>(),
            [(1.0, 60), (5.0, 80)]
        );
        assert_eq!(notes, ["split at 2 gaps, 1 pieces too short to use"]);
        assert!((records[1].step - 0.01).abs() < 1e-12 && records[1].grid.len() == 80);
    }

    #[test]
    fn samples_that_were_lost_do_not_split_a_record() {
        let time: Vec<f64> = (0..1000).filter(|k| !(400..403).contains(k)).map(|k| 1e-3 * f64::from(k)).collect();
        let (records, notes) = split("rig.csv", signals(time)).expect("a record");
        assert_eq!((records.len(), records[0].time.len(), notes.len()), (1, 997, 0));
    }

    #[test]
    fn data_of_which_nothing_can_be_learned_are_refused() {
        let refused = |time: Vec<f64>, of: fn(f64) -> f64| {
            let mut data = signals(time);
            data.get_mut("position").expect("a position").iter_mut().for_each(|value| *value = of(*value));
            let records = split("rig.csv", data).and_then(|(records, _)| check_motion(&records));
            records.expect_err("a refusal").0
        };
        let rise: Vec<f64> = (0..100).map(|k| 0.01 * f64::from(k)).collect();
        assert!(refused(rise[..20].to_vec(), |x| x).contains("too short, 20 samples"));
        assert!(refused(rise.clone(), |x| if x > 0.5 { f64::NAN } else { x }).contains("position is NaN at sample 53"));
        assert!(refused(rise.clone(), |_| 1.0).contains("position never changes"));
        assert!(refused(rise.iter().rev().copied().collect(), |x| x).contains("sample 1: time must rise"));
    }
}
