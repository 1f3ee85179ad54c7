//! Values that no rig has: another unit, another zero, samples far off the others.
use super::{Facts, Finding, Remedy, Source, is_of_cylinder};
use crate::arrays::{differences, extremes, median, quantile};
use crate::experiment::Given;
use crate::numerals::significant;
use crate::parameter::Values;
use crate::record::Signals;
use crate::smoothing::noise;
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
pub(super) const CENTRE: f64 = 5.0;
const RANGE: [f64; 2] = [0.0, 10.0];
const PERCENT: f64 = 20.0;
const MILLIVOLTS: f64 = 1000.0;

/// Findings about each signal of a record; ranges are those without outliers.
pub fn findings(facts: &Facts<'_>, source: &Source<'_>) -> Vec<Finding> {
    let Source { signals, .. } = source;
    let mut found: Vec<Finding> =
        signals.get("time").and_then(|time| interval(facts, source, time)).into_iter().collect();
    let mut bridged = Signals::new();
    // A voltage may well be a pulse of one sample.
    // Points have no samples around them.
    let courses = signals.iter().filter(|_| facts.given.kind.has_time());
    for (signal, values) in courses.filter(|(signal, _)| !["time", "valveVoltage"].contains(&signal.as_str())) {
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
