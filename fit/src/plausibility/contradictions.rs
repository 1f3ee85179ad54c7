//! Signals that contradict one another: signs, chambers and units that are mistaken.
use super::ranges::CENTRE;
use super::{Facts, Finding, Remedy};
use crate::experiment::{PRESSURES, rod_force};
use crate::numerals::significant;
use crate::parameter::Values;
use crate::record::Record;
use crate::smoothing::parabolas;

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

/// Findings about the signals of records beside one another: velocities, chambers and signs.
pub fn contradictions(facts: &Facts<'_>, records: &[Record]) -> Vec<Finding> {
    if facts.given.kind.has_time()
        && let Some(finding) = velocity(facts, records)
    {
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
    if !facts.given.kind.has_time() {
        return Some(truth(facts, record, "velocity"));
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
        if !self.facts.given.kind.has_time() {
            // Friction opposes the motion at each point.
            let all: f64 = force.iter().zip(&self.speed).map(|(force, speed)| (force * speed).abs()).sum();
            return dot(force, &self.speed) < AGAINST * all;
        }
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
        let signal =
            if ["motion", "points"].contains(&kind) && self.has("frictionForce") { "frictionForce" } else { "force" };
        // The force on a seal under pressure has a part that is no friction.
        if !self.has(signal) || (signal == "force" && self.has("pressure")) {
            return None;
        }
        let force: Vec<f64> = self.records.iter().flat_map(|record| truth(self.facts, record, signal)).collect();
        self.is_against(&force).then(|| {
            let gives = match self.facts.given.kind.has_time() {
                true => "it gives back more energy than it takes over a cycle; is its sign or the sign of the motion turned?",
                false => "at most points it has not the sign of the velocity; is one of both signs turned?",
            };
            let text = format!("{signal} works against friction: {gives}");
            Finding::doubted(signal, text, vec![Remedy::Turn { signal: signal.to_owned() }])
        })
    }
}

/// The work of a force as a share of all that it gives and takes; 1 where it says nothing of signs.
pub(super) fn share_of_work(force: &[f64], speed: &[f64], step: f64) -> f64 {
    let path = speed.iter().map(|speed| speed.abs()).sum::<f64>() * step;
    if path <= 0.0 || (speed.iter().sum::<f64>() * step).abs() > AWAY * path {
        return 1.0;
    }
    let all: f64 = force.iter().zip(speed).map(|(force, speed)| (force * speed).abs()).sum();
    dot(force, speed) / all.max(1e-300)
}
