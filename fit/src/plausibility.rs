//! Plausibility of a measured record: units, atmospheres, signs and chambers that are mistaken, and their remedies.

use std::collections::BTreeMap;

use crate::arrays::{differences, extremes, median, quantile};
use crate::experiment::{Given, PRESSURES, rod_force};
use crate::numerals::significant;
use crate::parameter::Values;
use crate::record::{Record, Signals, split, unit_of};
use crate::smoothing::{noise, parabolas};
use crate::units;

/// Intervals of samples in s between which a carriage does much that nobody sees, or all of it.
const SLOW: f64 = 0.1;
const TOO_SLOW: f64 = 0.5;
/// An interval in s that no rig has.
const TOO_FAST: f64 = 1e-6;
/// Units of time that are taken for each other.
const TIMES: [&str; 3] = ["s", "ms", "us"];
/// Samples whose median tells what the one in their middle should be.
const NEIGHBOURS: usize = 5;
/// Standard deviations of the noise beyond which a sample is an outlier, and the share of the range of the others.
const FAR: f64 = 20.0;
const HALF: f64 = 0.5;
/// Ratio of a leap to the step before it.
const LEAP: f64 = 3.0;
/// Outliers that are named.
const SHOWN: usize = 5;
/// Range in m that no bench has.
const ENDLESS: f64 = 10.0;
/// Units of positions that are taken for each other, the largest first, and the least share of the stroke that is a motion.
const LENGTHS: [&str; 5] = ["m", "in", "cm", "mm", "um"];
const SHORTEST_MOTION: f64 = 0.02;
/// Pressures in Pa that no chamber is below, or above.
const EMPTY: f64 = 2e4;
const HIGHEST: f64 = 1e8;
/// Values in Pa below which a pressure is likely in bar, or in kPa.
const IN_BAR: f64 = 50.0;
const IN_KPA: f64 = 5e3;
/// Largest ratio of a chamber's pressure to the supply's, even when compressed.
const BEYOND: f64 = 3.0;
/// Highest pressures in Pa of a record between which one is likely: as they are usual, and as shares of a known supply.
const USUAL: [f64; 2] = [1.5e5, 2.5e6];
const SHARES: [f64; 2] = [0.3, 1.5];
/// Units of pressures that are taken for each other; those above the atmosphere follow the absolute ones.
const ABSOLUTE: [&str; 6] = ["bar", "kPa", "MPa", "psi", "mbar", "Pa"];
/// Voltages in V at which the valve is closed, beyond which it saturates, and beyond which a voltage is a percentage or in mV.
const CENTRE: f64 = 5.0;
const RANGE: [f64; 2] = [0.0, 10.0];
const PERCENT: f64 = 20.0;
const MILLIVOLTS: f64 = 1000.0;
/// Share of the work that a force gives back in a cycle, below which its sign is in doubt; or a correlation.
const AGAINST: f64 = -0.2;
/// A cycle ends within this share of its length from its start: a weight gives its work back.
const AWAY: f64 = 0.3;
/// Ratio of a velocity to the slope of its position, or its inverse, that shows another unit; and the least correlation of the two.
const UNLIKE: f64 = 1.5;
const LIKE: f64 = 0.8;
/// Units of velocities that are taken for each other, and the factor within which a ratio is theirs.
const VELOCITIES: [&str; 5] = ["m/s", "mm/s", "rad/s", "deg/s", "rpm"];
const ABOUT: f64 = 2.0;
/// Width in s of the parabolas that give velocities here, and its least number of intervals.
const WIDTH: f64 = 0.04;
const INTERVALS: f64 = 5.0;

/// A change of columns, settings or data that removes the cause of a finding.
#[derive(Clone, Debug, PartialEq)]
pub enum Remedy {
    /// The column of a signal is in another unit.
    Unit {
        /// The signal.
        signal: String,
        /// The unit.
        unit: String,
    },
    /// The sign of the column of a signal is the opposite.
    Turn {
        /// The signal.
        signal: String,
    },
    /// The columns of two signals are each other's.
    Swap {
        /// The signals.
        signals: [String; 2],
    },
    /// Parameters of the machine or of its sensors have other values.
    Set {
        /// Their names and values in SI units.
        values: Vec<(String, f64)>,
    },
    /// Samples are corrected, or removed.
    Remove {
        /// The signal.
        signal: String,
        /// The samples.
        rows: Vec<usize>,
    },
}

/// Something about a signal that cannot be meant, or is unlikely.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The signal.
    pub signal: String,
    /// Where it is, what is found, and what may be meant; the remedy is said by whoever offers it.
    pub text: String,
    /// Remedies, the likeliest first.
    pub remedies: Vec<Remedy>,
    /// Whether no fit makes sense with it.
    pub is_refused: bool,
}

impl Finding {
    fn refused(signal: &str, text: String, remedies: Vec<Remedy>) -> Self {
        Self { signal: signal.to_owned(), text, remedies, is_refused: true }
    }

    fn doubted(signal: &str, text: String, remedies: Vec<Remedy>) -> Self {
        Self { is_refused: false, ..Self::refused(signal, text, remedies) }
    }
}

/// A column as the table has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: String,
}

/// An experiment, and what is known of the units of its signals.
pub struct Facts<'a> {
    /// Kind of the experiment, and its fixed values.
    pub given: &'a Given,
    /// Columns of the signals; a signal without one is in its SI unit.
    pub columns: &'a BTreeMap<String, Written>,
    /// SI units of the signals of a rotating machine, where these differ from the units of a machine that slides.
    pub units: &'a BTreeMap<String, String>,
}

/// Signals of a record, with its name and the place of a sample, for people.
pub struct Source<'a> {
    /// Name of the record.
    pub name: &'a str,
    /// Signals in SI units, with `time`.
    pub signals: &'a Signals,
    /// Place of a sample of a signal.
    pub place: &'a dyn Fn(&str, usize) -> String,
}

/// Findings about a record by itself and about its signals beside one another.
pub fn check(facts: &Facts<'_>, source: &Source<'_>) -> Vec<Finding> {
    let mut found = findings(facts, source);
    found.extend(supply(facts.given));
    if found.iter().any(|finding| finding.is_refused) {
        return found;
    }
    match split(source.name, source.signals.clone()) {
        Ok((records, _)) => found.extend(contradictions(facts, &records)),
        Err(refused) => found.push(Finding::refused("time", refused.0, vec![])),
    }
    found
}

/// Findings about each signal of a record; ranges are those without outliers.
pub fn findings(facts: &Facts<'_>, source: &Source<'_>) -> Vec<Finding> {
    let Source { signals, .. } = source;
    let mut found: Vec<Finding> =
        signals.get("time").and_then(|time| interval(facts, source, time)).into_iter().collect();
    let mut bridged = Signals::new();
    // A voltage may well be a pulse of one sample.
    for (signal, values) in signals.iter().filter(|(signal, _)| !["time", "valveVoltage"].contains(&signal.as_str())) {
        let (rows, usual) = outliers(values);
        if rows.is_empty() {
            continue;
        }
        let mut without = values.clone();
        rows.iter().for_each(|row| without[*row] = usual[*row]);
        found.push(far_off(facts, source, signal, values, rows));
        bridged.insert(signal.clone(), without);
    }
    for (signal, readings) in signals.iter().filter(|(signal, values)| *signal != "time" && !values.is_empty()) {
        let readings = bridged.get(signal).unwrap_or(readings);
        let values = facts.given.truth(signal, readings.clone(), &Values::new());
        found.extend(match signal.as_str() {
            "position" => position(facts, source, extremes(&values)),
            "supplyPressure" => pressure(facts, source, signal, extremes(&values)),
            "chamberA.pressure" | "chamberB.pressure" => pressure(facts, source, signal, extremes(&values))
                .or_else(|| above_supply(facts, source, signal, &values)),
            "valveVoltage" if facts.is_of_cylinder() => voltage(facts, source, extremes(&values)),
            _ => None,
        });
    }
    found
}

/// A supply pressure among the fixed values that nobody has, in Pa.
pub fn supply(given: &Given) -> Option<Finding> {
    let supply = *given.known.get("supplyPressure").filter(|supply| is_of_cylinder(given) && **supply < EMPTY)?;
    let meant = 1e5 * supply;
    let text = format!(
        "supplyPressure = {supply} Pa, but pressures are absolute and in Pa; did you mean {supply} bar, which is {meant} Pa?"
    );
    let is_likely = (EMPTY..=HIGHEST).contains(&meant);
    let remedy = Remedy::Set { values: vec![("supplyPressure".to_owned(), meant)] };
    Some(Finding::refused("supplyPressure", text, if is_likely { vec![remedy] } else { vec![] }))
}

fn is_of_cylinder(given: &Given) -> bool {
    given.table.name == given.cylinder.name
}

impl Facts<'_> {
    fn is_of_cylinder(&self) -> bool {
        is_of_cylinder(self.given)
    }

    /// SI unit of a signal.
    fn si(&self, signal: &str) -> &str {
        self.units.get(signal).map_or_else(|| unit_of(signal), String::as_str)
    }

    /// Unit of the numbers of a signal.
    fn unit(&self, signal: &str) -> &str {
        self.columns.get(signal).map_or_else(|| self.si(signal), |column| &column.unit)
    }

    fn is_set(&self, name: &str) -> bool {
        self.given.known.contains_key(name)
    }

    /// The range of a signal, as the begin of a sentence.
    fn told(&self, source: &Source<'_>, signal: &str, (low, high): (f64, f64)) -> String {
        let column = self.columns.get(signal).map(|Written { name, unit }| format!(" (column {name} in {unit})"));
        let [low, high] = [low, high].map(|value| significant(value, 5));
        let (name, column, si) = (source.name, column.unwrap_or_default(), self.si(signal));
        format!("{name}: {signal}{column} is from {low} to {high} {si}")
    }

    /// Numbers of a signal as they are written, in another unit; nothing for one of another quantity.
    fn in_unit(&self, signal: &str, unit: &str, values: [f64; 2]) -> Option<[f64; 2]> {
        let si = self.si(signal);
        let (factor, offset) = units::to_si(self.unit(signal), si, false).ok()?;
        let (times, behind) = units::to_si(unit, si, false).ok()?;
        Some(values.map(|value| (value - offset) / factor * times + behind))
    }

    fn other_unit(&self, signal: &str, unit: &str) -> Option<Remedy> {
        let is_other = units::spelled(self.unit(signal)) != unit;
        is_other.then(|| Remedy::Unit { signal: signal.to_owned(), unit: unit.to_owned() })
    }
}

fn interval(facts: &Facts<'_>, source: &Source<'_>, time: &[f64]) -> Option<Finding> {
    let usual = if time.len() > 1 { median(&differences(time)) } else { return None };
    let column =
        facts.columns.get("time").map_or_else(|| "in s".to_owned(), |own| format!("{} in {}", own.name, own.unit));
    let apart = format!("{}: time ({column}): samples are {} s apart", source.name, significant(usual, 4));
    if usual < TOO_FAST {
        let is_likely = |unit: &&str| {
            facts.in_unit("time", unit, [usual; 2]).is_some_and(|[it, _]| (TOO_FAST..=SLOW).contains(&it))
        };
        let remedies = TIMES.into_iter().filter(is_likely).filter_map(|unit| facts.other_unit("time", unit)).collect();
        return Some(Finding::refused("time", format!("{apart}, which no rig does; is the unit right?"), remedies));
    }
    if usual <= if facts.is_of_cylinder() { SLOW } else { TOO_SLOW } {
        return None;
    }
    let text = format!("{apart}, too far to see the carriage start and stop");
    let (text, remedies) = match facts.other_unit("time", "ms") {
        Some(remedy) => (format!("{text}; is it in ms?"), vec![remedy]),
        None => (text, vec![]),
    };
    // A test bench may creep.
    let is_refused = facts.is_of_cylinder() && usual > TOO_SLOW;
    Some(if is_refused { Finding::refused("time", text, remedies) } else { Finding::doubted("time", text, remedies) })
}

fn far_off(facts: &Facts<'_>, source: &Source<'_>, signal: &str, values: &[f64], rows: Vec<usize>) -> Finding {
    let one = |row: &usize| {
        format!("{} = {} {}", (source.place)(signal, *row), significant(values[*row], 6), facts.si(signal))
    };
    let first: Vec<String> = rows.iter().take(SHOWN).map(one).collect();
    let more = if rows.len() > SHOWN { format!(" and {} more", rows.len() - SHOWN) } else { String::new() };
    let text = format!("{}: {signal} is far off all samples around it at {}{more}", source.name, first.join(", "));
    Finding::refused(signal, text, vec![Remedy::Remove { signal: signal.to_owned(), rows }])
}

/// Samples that are far off those around them, and the medians of these.
///
/// One or two samples that go far beyond what the signal does otherwise: a lost word of a converter, a comma at the wrong place. Steps
/// and peaks that last are none. What is beside the first sample and the last is not known, so that a leap there may be a step.
pub fn outliers(values: &[f64]) -> (Vec<usize>, Vec<f64>) {
    let count = values.len();
    if count < 4 * NEIGHBOURS {
        return (vec![], values.to_vec());
    }
    let reach = NEIGHBOURS / 2;
    let around = |row: usize| {
        let mut own: [f64; NEIGHBOURS] =
            std::array::from_fn(|at| values[(row + at).saturating_sub(reach).min(count - 1)]);
        own.sort_by(f64::total_cmp);
        own[reach]
    };
    let usual: Vec<f64> = (0..count).map(around).collect();
    let limit = (FAR * noise(values)).max(HALF * (quantile(&usual, 0.99) - quantile(&usual, 0.01)));
    if limit <= 0.0 {
        return (vec![], usual);
    }
    let is_far: Vec<bool> = values.iter().zip(&usual).map(|(value, usual)| (value - usual).abs() > limit).collect();
    let mut rows = Vec::new();
    let mut row = 0;
    while row < count {
        let end = row + is_far[row..].iter().take_while(|is_far| **is_far).count();
        // A peak that is climbed to over some samples was measured, however short it is.
        if end > row && leaps(values, row, -1, limit) && leaps(values, end - 1, 1, limit) {
            rows.extend(row..end);
        }
        row = end.max(row + 1);
    }
    (rows, usual)
}

/// Whether a signal leaps between a sample and the one beside it, by far more than between that and the next one.
fn leaps(values: &[f64], row: usize, side: isize, limit: f64) -> bool {
    let at = |steps: isize| row.checked_add_signed(side * steps).and_then(|place| values.get(place));
    let Some(beside) = at(1) else { return false };
    let before = at(2).map_or(0.0, |next| (beside - next).abs());
    (values[row] - beside).abs() > limit.max(LEAP * before)
}

fn position(facts: &Facts<'_>, source: &Source<'_>, (low, high): (f64, f64)) -> Option<Finding> {
    let told = facts.told(source, "position", (low, high));
    let finding = |text: String, remedies| Some(Finding::refused("position", text, remedies));
    let in_unit = |text: &str, candidates: Vec<(&str, [f64; 2])>| {
        let (unit, ends) = candidates[0];
        let [low, high] = ends.map(|value| significant(value, 5));
        let remedies = candidates.iter().filter_map(|(unit, _)| facts.other_unit("position", unit)).collect();
        finding(format!("{text}; is it in {unit}, {low} to {high} m?"), remedies)
    };
    if !["rig", "pneumatic"].contains(&facts.given.kind.name) {
        if high - low <= ENDLESS || facts.si("position") != "m" {
            return None;
        }
        let mm = facts.in_unit("position", "mm", [low, high]).filter(|_| facts.other_unit("position", "mm").is_some());
        return match mm {
            Some(ends) => in_unit(&told, vec![("mm", ends)]),
            None => finding(format!("{told}, which no bench has; is the unit right?"), vec![]),
        };
    }
    let stroke = facts.given.value("cylinder.stroke", &Values::new());
    let margin = 0.02 * stroke + 1e-3;
    if low >= -margin && high <= stroke + margin {
        return None;
    }
    if high <= margin && -low <= stroke + margin {
        let turn = Remedy::Turn { signal: "position".to_owned() };
        return finding(format!("{told}, below the retracted end; is its sign turned?"), vec![turn]);
    }
    let is_default = if facts.is_set("cylinder.stroke") { "" } else { ", which is its default" };
    let beyond = format!("{told}, but cylinder.stroke = {stroke} m{is_default}");
    let fits = |unit: &'static str| {
        let ends = facts.in_unit("position", unit, [low, high])?;
        facts.other_unit("position", unit)?;
        let is_likely =
            ends[0] >= -margin && ends[1] <= stroke + margin && ends[1] - ends[0] >= SHORTEST_MOTION * stroke;
        is_likely.then_some((unit, ends))
    };
    let candidates: Vec<_> = LENGTHS.into_iter().filter_map(fits).collect();
    if high > 1.0 && !candidates.is_empty() {
        return in_unit(&beyond, candidates);
    }
    let middle = 0.5 * stroke;
    if low >= -middle - margin && high <= middle + margin && !facts.is_set("offset.position") {
        let remedy = Remedy::Set { values: vec![("offset.position".to_owned(), -middle)] };
        let text = format!("{beyond}; does it count from the middle, and not from the retracted end?");
        return finding(text, vec![remedy]);
    }
    finding(format!("{beyond}; give the stroke, and count the position from the retracted end"), vec![])
}

/// The unit of a pressure without the letter that makes it count from the atmosphere.
fn absolute(unit: &str) -> &str {
    ABSOLUTE.into_iter().find(|own| unit.strip_suffix('g') == Some(own)).unwrap_or(unit)
}

/// Units in which the numbers of a pressure would be likely, of their range in Pa as they are read.
fn likely(facts: &Facts<'_>, signals: &Signals, signal: &str, low: f64, high: f64) -> Vec<String> {
    let supply = if signal == "supplyPressure" { None } else { supply_of(facts, signals) };
    let [least, most] = supply.map_or(USUAL, |supply| SHARES.map(|share| share * supply));
    let is_likely = |unit: &String| {
        let ends = facts.in_unit(signal, unit, [low, high]);
        ends.is_some_and(|[low, high]| low >= EMPTY && least <= high && high <= most)
            && facts.other_unit(signal, unit).is_some()
    };
    ABSOLUTE.into_iter().flat_map(|unit| [unit.to_owned(), format!("{unit}g")]).filter(is_likely).collect()
}

/// A unit of a pressure that is not near its supply: by the size of its numbers, absolute if it can be.
fn possible(facts: &Facts<'_>, signal: &str, own: &str, low: f64, high: f64) -> Option<String> {
    let base = match high {
        high if high < IN_BAR => "bar",
        high if high < IN_KPA => "kPa",
        _ => own,
    };
    let is_possible = |unit: &String| {
        let ends = facts.in_unit(signal, unit, [low, high]);
        ends.is_some_and(|[low, high]| low >= EMPTY && high <= HIGHEST) && facts.other_unit(signal, unit).is_some()
    };
    [base.to_owned(), format!("{base}g")].into_iter().find(is_possible)
}

/// The supply pressure, as far as it is measured or fixed.
fn supply_of(facts: &Facts<'_>, signals: &Signals) -> Option<f64> {
    let measured = signals.get("supplyPressure").map(|values| extremes(values).1);
    let fixed = || facts.given.known.get("supplyPressure").copied();
    measured.or_else(fixed).filter(|supply| facts.is_of_cylinder() && *supply > EMPTY)
}

fn units_of(signal: &str, units: Vec<String>) -> Vec<Remedy> {
    units.into_iter().map(|unit| Remedy::Unit { signal: signal.to_owned(), unit }).collect()
}

fn pressure(facts: &Facts<'_>, source: &Source<'_>, signal: &str, (low, high): (f64, f64)) -> Option<Finding> {
    if low >= EMPTY && high <= HIGHEST {
        return None;
    }
    let told = format!("{}, but pressures are absolute", facts.told(source, signal, (low, high)));
    let own = units::spelled(facts.unit(signal));
    let mut meant = likely(facts, source.signals, signal, low, high);
    if meant.is_empty() {
        meant.extend(possible(facts, signal, &own, low, high));
    }
    let text = match meant.first() {
        _ if high > HIGHEST => format!("{told} and below {HIGHEST:e} Pa; is the unit right?"),
        Some(unit) if absolute(unit) == own => format!("{told}; do these count from the atmosphere?"),
        Some(unit) => format!("{told}; are these {}?", absolute(unit)),
        None => format!("{told}; is the unit right?"),
    };
    Some(Finding::refused(signal, text, units_of(signal, meant)))
}

/// A chamber far above its supply.
fn above_supply(facts: &Facts<'_>, source: &Source<'_>, signal: &str, values: &[f64]) -> Option<Finding> {
    let (low, high) = extremes(values);
    let supply = supply_of(facts, source.signals).filter(|supply| high > BEYOND * supply)?;
    let row = values.iter().position(|value| *value == high)?;
    let unit = facts.unit(signal);
    let (factor, offset) = units::to_si(unit, "Pa", false).ok()?;
    let meant = likely(facts, source.signals, signal, low, high);
    let text = format!(
        "{}: {signal} = {} {unit} at {} s, which is {} bar, {} times the supply of {} bar; {}",
        (source.place)(signal, row),
        significant((high - offset) / factor, 5),
        significant(source.signals.get("time").map_or(f64::NAN, |time| time[row]), 6),
        significant(1e-5 * high, 4),
        significant(high / supply, 3),
        significant(1e-5 * supply, 3),
        if meant.is_empty() { "no usual unit brings it below the supply" } else { "is the unit right?" }
    );
    Some(Finding::refused(signal, text, units_of(signal, meant)))
}

/// Voltages beyond the range of the valve, and what they look like.
fn voltage(facts: &Facts<'_>, source: &Source<'_>, (low, high): (f64, f64)) -> Option<Finding> {
    let [least, most] = RANGE;
    if low >= least && high <= most {
        return None;
    }
    let told = facts.told(source, "valveVoltage", (low, high));
    let told = format!("{told}, but the valve takes {least} to {most} V and saturates beyond");
    let is_corrected = ["gain.valveVoltage", "offset.valveVoltage"].into_iter().any(|name| facts.is_set(name));
    let set = |name: &str, value| Remedy::Set { values: vec![(format!("{name}.valveVoltage"), value)] };
    let (question, remedy) = if is_corrected {
        return Some(Finding::doubted("valveVoltage", told, vec![]));
    } else if high > MILLIVOLTS
        && let Some(remedy) = facts.other_unit("valveVoltage", "mV")
    {
        ("are these mV?", remedy)
    } else if high > PERCENT {
        ("is it in percent?", set("gain", 0.1))
    } else if low < -0.5 && high < CENTRE + 0.5 {
        ("does it count from the middle?", set("offset", -CENTRE))
    } else {
        return Some(Finding::doubted("valveVoltage", told, vec![]));
    };
    Some(Finding::doubted("valveVoltage", format!("{told}; {question}"), vec![remedy]))
}

/// Findings about the signals of records beside one another: velocities, chambers and signs.
pub fn contradictions(facts: &Facts<'_>, records: &[Record]) -> Vec<Finding> {
    if let Some(finding) = velocity(facts, records) {
        return vec![finding];
    }
    let speeds: Option<Vec<Vec<f64>>> = records.iter().map(|record| speed(facts, record)).collect();
    let Some(speeds) = speeds.filter(|speeds| !speeds.is_empty()) else { return vec![] };
    let courses = Courses { facts, records, speed: speeds.concat() };
    if facts.is_of_cylinder() { courses.of_cylinder() } else { courses.of_bench().into_iter().collect() }
}

fn truth(facts: &Facts<'_>, record: &Record, signal: &str) -> Vec<f64> {
    facts.given.truth(signal, record.on_grid(signal), &Values::new())
}

fn width(record: &Record) -> f64 {
    WIDTH.max(INTERVALS * record.step)
}

fn slope(facts: &Facts<'_>, record: &Record) -> Vec<f64> {
    parabolas(&truth(facts, record, "position"), record.step, width(record)).1
}

/// Velocity at the communication points; nothing where no motion is measured.
fn speed(facts: &Facts<'_>, record: &Record) -> Option<Vec<f64>> {
    if record.signals.contains_key("position") {
        return Some(slope(facts, record));
    }
    let is_measured = record.signals.contains_key("velocity");
    is_measured.then(|| parabolas(&truth(facts, record, "velocity"), record.step, width(record)).0)
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

/// A velocity that is not the slope of its position.
fn velocity(facts: &Facts<'_>, records: &[Record]) -> Option<Finding> {
    let has_both =
        |record: &&Record| ["position", "velocity"].iter().all(|signal| record.signals.contains_key(*signal));
    let both = || records.iter().filter(has_both);
    let seen: Vec<f64> = both().flat_map(|record| truth(facts, record, "velocity")).collect();
    let slope: Vec<f64> = both().flat_map(|record| slope(facts, record)).collect();
    let (common, seen, own) = (dot(&seen, &slope), dot(&seen, &seen), dot(&slope, &slope));
    if seen <= 0.0 || own <= 0.0 || common.abs() <= LIKE * (seen * own).sqrt() {
        return None;
    }
    let ratio = common / own;
    if ratio > 1.0 / UNLIKE && ratio < UNLIKE {
        return None;
    }
    let [si, position] = ["velocity", "position"].map(|signal| facts.si(signal));
    let told = format!("velocity is {} times the slope of position, in {si} and {position}", significant(ratio, 4));
    let is_meant = |unit: &&str| {
        let right = facts.in_unit("velocity", unit, [ratio, 0.0]).map(|[right, _]| right);
        right.is_some_and(|right| right > 1.0 / ABOUT && right < ABOUT)
    };
    let remedy = VELOCITIES.into_iter().find(is_meant).and_then(|unit| facts.other_unit("velocity", unit));
    let (text, remedies) = match remedy {
        Some(Remedy::Unit { unit, signal }) => {
            (format!("{told}; is it in {unit}?"), vec![Remedy::Unit { unit, signal }])
        }
        _ if ratio < 0.0 => {
            (format!("{told}; is its sign turned?"), vec![Remedy::Turn { signal: "velocity".to_owned() }])
        }
        _ => (told, vec![]),
    };
    Some(Finding::refused("velocity", text, remedies))
}

/// Records with the velocity at their communication points, one after the other.
struct Courses<'a> {
    facts: &'a Facts<'a>,
    records: &'a [Record],
    speed: Vec<f64>,
}

impl Courses<'_> {
    fn has(&self, signal: &str) -> bool {
        self.records.iter().all(|record| record.signals.contains_key(signal))
    }

    fn is_against(&self, force: &[f64]) -> bool {
        share_of_work(force, &self.speed, self.records[0].step) < AGAINST
    }

    fn of_cylinder(&self) -> Vec<Finding> {
        let [is_voltage_against, are_pressures_against] = [self.is_voltage_against(), self.are_pressures_against()];
        let mut found = Vec::new();
        if are_pressures_against {
            let stroke = self.facts.given.value("cylinder.stroke", &Values::new());
            let values = vec![("gain.position".to_owned(), -1.0), ("offset.position".to_owned(), stroke)];
            let mut remedies = vec![Remedy::Swap { signals: PRESSURES.map(str::to_owned) }, Remedy::Set { values }];
            // Where the voltage says the same, one mistake explains both.
            if is_voltage_against {
                remedies.reverse();
            }
            let text = "the pressures work against the motion: the position falls when chamberA.pressure is the higher one; are the \
                        chambers swapped, or does the position count from the other end?";
            found.push(Finding::doubted(PRESSURES[0], text.to_owned(), remedies));
        }
        if is_voltage_against {
            let values = vec![("gain.valveVoltage".to_owned(), -1.0), ("offset.valveVoltage".to_owned(), 2.0 * CENTRE)];
            let text = "the position falls when valveVoltage is above 5 V: is the sign of one of them turned, or are the hoses crossed?";
            found.push(Finding::doubted("valveVoltage", text.to_owned(), vec![Remedy::Set { values }]));
        }
        found
    }

    fn are_pressures_against(&self) -> bool {
        if !self.has("position") || !PRESSURES.iter().all(|signal| self.has(signal)) {
            return false;
        }
        let force = |record: &Record| {
            let pressures = PRESSURES.map(|signal| truth(self.facts, record, signal));
            rod_force(self.facts.given, &pressures, &Values::new())
        };
        self.is_against(&self.records.iter().flat_map(force).collect::<Vec<f64>>())
    }

    fn is_voltage_against(&self) -> bool {
        if !self.has("valveVoltage") {
            return false;
        }
        let voltages = self.records.iter().flat_map(|record| truth(self.facts, record, "valveVoltage"));
        let opening: Vec<f64> = voltages.map(|voltage| voltage - CENTRE).collect();
        let size = (dot(&opening, &opening) * dot(&self.speed, &self.speed)).sqrt();
        size > 0.0 && dot(&opening, &self.speed) < AGAINST * size
    }

    fn of_bench(&self) -> Option<Finding> {
        let kind = self.facts.given.kind.name;
        let signal = if kind == "motion" && self.has("frictionForce") { "frictionForce" } else { "force" };
        // The force on a seal under pressure has a part that is no friction.
        if !self.has(signal) || (signal == "force" && self.has("pressure")) {
            return None;
        }
        let force: Vec<f64> = self.records.iter().flat_map(|record| truth(self.facts, record, signal)).collect();
        self.is_against(&force).then(|| {
            let text = format!(
                "{signal} works against friction: it gives back more energy than it takes over a cycle; is its sign or the sign of \
                 the motion turned?"
            );
            Finding::doubted(signal, text, vec![Remedy::Turn { signal: signal.to_owned() }])
        })
    }
}

/// The work of a force as a share of all that it gives and takes; 1 where it says nothing of signs.
fn share_of_work(force: &[f64], speed: &[f64], step: f64) -> f64 {
    let path = speed.iter().map(|speed| speed.abs()).sum::<f64>() * step;
    if path <= 0.0 || (speed.iter().sum::<f64>() * step).abs() > AWAY * path {
        return 1.0;
    }
    let all: f64 = force.iter().zip(speed).map(|(force, speed)| (force * speed).abs()).sum();
    dot(force, speed) / all.max(1e-300)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Kind, Options};

    const SECOND: usize = 1000;

    /// A second of a rig whose carriage swings, with pressures that drive it and a voltage that leads it.
    fn rig() -> Signals {
        let course = |of: fn(f64) -> f64| (0..SECOND).map(|row| of(1e-3 * row as f64)).collect::<Vec<f64>>();
        let signals = [
            ("time", course(|t| t)),
            ("position", course(|t| 0.25 - 0.1 * libm::cos(6.0 * t))),
            ("valveVoltage", course(|t| 5.0 + 2.0 * libm::sin(6.0 * t))),
            ("chamberA.pressure", course(|t| 3.2e5 + 1e5 * libm::sin(6.0 * t))),
            ("chamberB.pressure", course(|t| 3.2e5 - 1e5 * libm::sin(6.0 * t))),
        ];
        signals.map(|(name, values)| (name.to_owned(), values)).into()
    }

    fn scaled(signal: &str, factor: f64, offset: f64) -> Signals {
        let mut signals = rig();
        signals.get_mut(signal).expect("a signal").iter_mut().for_each(|value| *value = factor * *value + offset);
        signals
    }

    fn found(signals: &Signals, columns: &[(&str, &str)], known: &[(&str, f64)]) -> Vec<Finding> {
        let kind = Kind::of_name("rig").expect("an experiment");
        let known = known.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let given = Given::new(kind, 7, known, signals.keys().cloned(), Options::default());
        let written = |(signal, unit): &(&str, &str)| {
            ((*signal).to_owned(), Written { name: "p".to_owned(), unit: (*unit).to_owned() })
        };
        let columns = columns.iter().map(written).collect();
        let facts = Facts { given: &given, columns: &columns, units: &BTreeMap::new() };
        check(&facts, &Source { name: "rig.csv", signals, place: &|signal, row| format!("rig.csv, {signal} {row}") })
    }

    fn only(mut found: Vec<Finding>) -> Finding {
        assert_eq!(found.len(), 1, "{found:?}");
        found.remove(0)
    }

    fn units_of(finding: &Finding) -> Vec<&str> {
        let mut units = Vec::new();
        for remedy in &finding.remedies {
            let Remedy::Unit { unit, .. } = remedy else { panic!("{remedy:?}") };
            units.push(unit.as_str());
        }
        units
    }

    fn set(values: &[(&str, f64)]) -> Remedy {
        Remedy::Set { values: values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect() }
    }

    const SUPPLY: (&str, f64) = ("supplyPressure", 6e5);

    #[test]
    fn a_rig_as_it_should_be_has_no_findings() {
        assert_eq!(found(&rig(), &[], &[SUPPLY]), []);
    }

    /// Pressures are written in one unit, and their column states another: the remedy is the unit of the numbers.
    #[test]
    fn a_pressure_is_in_the_unit_that_brings_it_near_its_supply() {
        let pressure = "chamberA.pressure";
        for (numbers, written, expected) in [
            (scaled(pressure, 1.0, -2.2e5), "bar", vec!["barg"]),
            (scaled(pressure, 1.0, -2.2e5), "Pa", vec!["Pag"]),
            (scaled(pressure, 1.0, -2.2e5), "psi", vec!["psig"]),
            (scaled(pressure, 1e-5, 0.0), "Pa", vec!["bar", "barg"]),
            (scaled(pressure, 1e-3, 0.0), "Pa", vec!["kPa", "kPag"]),
            (scaled(pressure, 14.503_77, 0.0), "bar", vec!["psi", "psig"]),
            (scaled(pressure, 1e2, 0.0), "bar", vec!["kPa", "kPag"]),
        ] {
            let finding = only(found(&numbers, &[(pressure, written)], &[SUPPLY]));
            assert_eq!((units_of(&finding), finding.is_refused), (expected, true), "{written}: {}", finding.text);
        }
        let none = only(found(&scaled(pressure, -1.0, 0.0), &[], &[]));
        assert!(none.remedies.is_empty() && none.text.ends_with("is the unit right?"), "{}", none.text);
    }

    #[test]
    fn a_position_is_in_the_unit_in_which_it_moves_along_the_stroke() {
        for (factor, written, expected) in
            [(1e3, "m", vec!["mm"]), (1e2, "m", vec!["cm", "mm"]), (1e6, "m", vec!["um"]), (1e4, "cm", vec!["um"])]
        {
            let finding = only(found(&scaled("position", factor, 0.0), &[("position", written)], &[]));
            assert_eq!(units_of(&finding), expected, "{written}: {}", finding.text);
        }
        let middle = only(found(&scaled("position", 1.0, -0.25), &[], &[]));
        assert_eq!((middle.remedies, middle.is_refused), (vec![set(&[("offset.position", -0.25)])], true));
        let turned = only(found(&scaled("position", -1.0, 0.0), &[], &[]));
        assert_eq!(turned.remedies, [Remedy::Turn { signal: "position".to_owned() }]);
        let beyond = only(found(&scaled("position", 1.0, 0.4), &[], &[]));
        assert!(beyond.remedies.is_empty() && beyond.text.contains("give the stroke"), "{}", beyond.text);
    }

    #[test]
    fn a_remedy_removes_its_finding() {
        assert_eq!(found(&scaled("position", 1.0, -0.25), &[], &[("offset.position", -0.25)]), []);
        assert_eq!(
            found(&scaled("position", -1.0, 0.5), &[], &[("gain.position", -1.0), ("offset.position", 0.5)]),
            []
        );
        let turned = [("gain.valveVoltage", -1.0), ("offset.valveVoltage", 10.0)];
        assert_eq!(found(&scaled("valveVoltage", -1.0, 10.0), &[], &turned), []);
    }

    #[test]
    fn one_mistake_that_explains_two_contradictions_comes_first() {
        let swap = Remedy::Swap { signals: PRESSURES.map(str::to_owned) };
        let other_end = set(&[("gain.position", -1.0), ("offset.position", 0.5)]);
        let mut swapped = rig();
        let [a, b] = PRESSURES.map(|signal| swapped[signal].clone());
        swapped.extend([(PRESSURES[0].to_owned(), b), (PRESSURES[1].to_owned(), a)]);
        let finding = only(found(&swapped, &[], &[]));
        assert_eq!((&finding.remedies, finding.is_refused), (&vec![swap.clone(), other_end.clone()], false));
        let both = found(&scaled("position", -1.0, 0.5), &[], &[]);
        assert_eq!(both.len(), 2, "{both:?}");
        assert_eq!(both[0].remedies, [other_end, swap]);
    }

    #[test]
    fn a_record_that_cannot_be_split_and_a_supply_in_bar_are_refused() {
        let short = rig().into_iter().map(|(name, values)| (name, values[..20].to_vec())).collect();
        let finding = only(found(&short, &[], &[]));
        assert!(finding.is_refused && finding.text.contains("too short, 20 samples"), "{}", finding.text);
        let finding = only(found(&rig(), &[], &[("supplyPressure", 6.0)]));
        assert_eq!((finding.remedies, finding.is_refused), (vec![set(&[("supplyPressure", 6e5)])], true));
    }

    /// 100 m one way and 60 m back end 40 of 160 m from the start: 0.3 of the path may be missing, 80 of 120 m not.
    #[test]
    fn work_says_something_of_signs_on_a_path_forth_and_back() {
        assert_eq!(share_of_work(&[1.0, 1.0], &[100.0, -60.0], 1.0), 40.0 / 160.0);
        assert_eq!(share_of_work(&[-1.0, -1.0], &[100.0, -60.0], 0.5), -40.0 / 160.0);
        assert_eq!(share_of_work(&[-1.0, -1.0], &[100.0, -20.0], 1.0), 1.0);
        assert_eq!(share_of_work(&[-1.0, -1.0], &[0.0, 0.0], 1.0), 1.0);
    }
}
