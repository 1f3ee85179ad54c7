//! Start values of the parameters of a law, from the data.

use nalgebra::DMatrix;

use crate::arrays::{interpolate, line, median, quantile, span};
use crate::experiment::{Experiment, Forces, MeasuredSegment};
use crate::nonnegative::nonnegative;
use crate::parameter::{Parameter, Values};

/// Share of a fixed static friction with which sliding friction starts at most.
const BELOW: f64 = 0.8;
/// Laws with elements that slip, or that behave like some.
const HAS_ELEMENTS: [&str; 4] = ["MaxwellSlip", "GMS", "Leuven", "DNLRX"];
/// Elements of a law that has no number of them.
const ELEMENTS: usize = 10;
/// Units of viscous friction, of a sliding and of a rotating machine.
const DAMPING: [&str; 2] = ["N.s/m", "N.m.s/rad"];
/// Presliding ends within a fiftieth of the stroke, as far as nothing better is known.
const PRESLIDING: f64 = 50.0;

/// The parameters with starts from the data, where the user gave none.
pub fn started(experiment: &dyn Experiment, segments: &[MeasuredSegment], parameters: &[Parameter]) -> Vec<Parameter> {
    let mut values: Values = parameters.iter().map(|one| (one.name.clone(), one.start)).collect();
    if values.get("area").is_some_and(|area| area.is_nan()) {
        values.insert("area".to_owned(), area(segments));
    }
    values.extend(experiment.guess(segments, &values));
    values.extend(of_map(experiment, segments, parameters, &values));
    values.extend(of_springs(experiment, segments, parameters, &values));
    parameters.iter().map(|one| one.at(values[&one.name])).collect()
}

/// Force over pressure, of all samples: friction has both signs.
fn area(segments: &[MeasuredSegment]) -> f64 {
    let (mut both, mut own) = (0.0, 0.0);
    for segment in segments {
        let (pressure, force) = (segment.record.of("pressure"), segment.record.of("force"));
        for row in (0..segment.used.len()).filter(|row| segment.used[*row]) {
            both += pressure[row] * force[row];
            own += pressure[row] * pressure[row];
        }
    }
    both / own.max(1e-300)
}

/// Friction levels from a map of mean force against speed.
fn of_map(
    experiment: &dyn Experiment,
    segments: &[MeasuredSegment],
    parameters: &[Parameter],
    values: &Values,
) -> Values {
    let given = experiment.given();
    let group = given.law_group();
    let is_own = |one: &&Parameter| !group.is_empty() && one.name.starts_with(&group);
    let own: Vec<(&str, &str)> =
        parameters.iter().filter(is_own).map(|one| (one.name.as_str(), one.unit.as_str())).collect();
    let mut map = Forces::default();
    for part in segments.iter().filter_map(|segment| experiment.forces(segment, values)) {
        map.speed.extend(part.speed);
        map.force.extend(part.force);
        map.level.extend(part.level);
    }
    let fixed = format!("{group}Fs");
    let is_fixed = given.table.table().find(&fixed).is_some() && own.iter().all(|(name, _)| *name != fixed);
    let strokes =
        segments.iter().filter_map(|segment| segment.record.signals.get("position")).map(|course| span(course));
    let law = Law {
        name: given.law_name(),
        group: &group,
        fixed_static: is_fixed.then(|| given.value(&fixed, &Values::new())),
        bristles: given.value(&format!("{group}N"), values),
    };
    levels(law, &own, &map, presliding(strokes.reduce(f64::max)))
}

/// A law whose parameters are to start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law<'a> {
    /// Its name.
    pub name: &'a str,
    /// Prefix of its parameters, with the dot.
    pub group: &'a str,
    /// Static friction that is not estimated.
    pub fixed_static: Option<f64>,
    /// Number of bristles or elements.
    pub bristles: f64,
}

/// Friction levels of estimated parameters, names and units, from a map of friction against speed; `length` is the length of
/// presliding in m.
pub fn levels(law: Law<'_>, own: &[(&str, &str)], map: &Forces, length: f64) -> Values {
    if own.is_empty() || map.speed.is_empty() {
        return Values::new();
    }
    let speeds: Vec<f64> = map.speed.iter().map(|speed| speed.abs()).collect();
    let fastest = quantile(&speeds, 0.98);
    let sliding = (0..speeds.len()).filter(|row| speeds[*row] > 0.1 * fastest && map.level[*row] > 1e-3);
    let (pace, dry): (Vec<f64>, Vec<f64>) =
        sliding.map(|row| (speeds[row], map.force[row] * map.speed[row].signum() / map.level[row])).unzip();
    if fastest == 0.0 || pace.len() < 10 {
        return Values::new();
    }
    let (mut coulomb, viscous) = dry_and_viscous(own, &pace, &dry, 0.3 * fastest);
    // Sliding friction beyond a static friction that stays as it is would be refused.
    if let Some(fixed) = law.fixed_static {
        coulomb = coulomb.min(BELOW * fixed);
    }
    let excess: Vec<f64> = dry.iter().zip(&pace).map(|(dry, pace)| dry - coulomb - viscous * pace).collect();
    let statics = coulomb + quantile(&excess, 0.98).max(0.1 * coulomb).min(2.0 * coulomb);
    let stiffness = match law.name {
        "Bristle" => 1.5 * coulomb / (law.bristles * length),
        _ => coulomb / length,
    };
    let start = |name: &str| {
        let kind = name.rsplit('.').next().and_then(|last| last.split('[').next()).unwrap_or_default();
        Some(match kind {
            // Of Armstrong's law it is the excess of static friction over sliding friction.
            "FsInf" if name.ends_with("stribeck.FsInf") => 1.2 * statics,
            "FsInf" if law.name == "Armstrong" => statics - coulomb,
            "Fs" | "FsInf" => statics,
            "Fc" | "Fc1" | "Fc2" => coulomb,
            "f1" if law.name == "BlimanSorine" => 3.0 * coulomb,
            "f2" if law.name == "BlimanSorine" => 2.0 * coulomb,
            "f1" => 0.6 * coulomb,
            "f2" => 3.0 / length,
            "vs" => 0.1 * fastest,
            "vd" => fastest,
            "sigma0" => stiffness,
            "sigma1" => 0.1 * stiffness * length / fastest,
            "sigma2" | "c1" | "c2" => viscous.max(0.05 * coulomb / fastest),
            "k1" => 0.3 * coulomb / length,
            "k" => coulomb / length / 4.0,
            "W" => coulomb / 4.0,
            "deltaS" | "z0" | "Delta" | "xe" => length,
            _ => return None,
        })
    };
    own.iter().filter_map(|(name, _)| Some(((*name).to_owned(), start(name)?))).collect()
}

/// Friction at speed 0 and its growth, from the faster samples; no growth under a law whose viscous friction is fixed.
fn dry_and_viscous(own: &[(&str, &str)], pace: &[f64], dry: &[f64], least: f64) -> (f64, f64) {
    let middle = median(dry).max(1e-9);
    let (fast, force): (Vec<f64>, Vec<f64>) =
        pace.iter().zip(dry).filter(|(pace, _)| **pace > least).map(|(pace, dry)| (*pace, *dry)).unzip();
    if own.iter().all(|(_, unit)| !DAMPING.contains(unit)) || fast.len() < 10 {
        return (middle, 0.0);
    }
    let (slope, coulomb) = line(&fast, &force);
    if slope <= 0.0 || coulomb < 0.1 * middle { (middle, 0.0) } else { (coulomb, slope) }
}

/// Presliding length in m, of the longest stroke that is measured.
pub fn presliding(longest: Option<f64>) -> f64 {
    (longest.unwrap_or(1e-3) / PRESLIDING).max(1e-7)
}

/// Deflections in m at which elements slip, spread over a stroke on a logarithmic scale.
pub fn ends(stroke: f64, number: usize) -> Vec<f64> {
    let share = |index: usize| if number > 1 { index as f64 / (number - 1) as f64 - 1.0 } else { -1.0 };
    (0..number).map(|index| stroke * libm::pow(100.0, share(index))).collect()
}

/// Parallel elements that slip, by non-negative least squares with fixed deflections at which they do.
fn of_springs(
    experiment: &dyn Experiment,
    segments: &[MeasuredSegment],
    parameters: &[Parameter],
    values: &Values,
) -> Values {
    let given = experiment.given();
    let (group, law) = (given.law_group(), given.law_name());
    if given.kind.name != "motion" || !HAS_ELEMENTS.contains(&law) {
        return Values::new();
    }
    let number = if law == "Leuven" { ELEMENTS } else { given.value(&format!("{group}N"), values) as usize };
    let stroke = segments.iter().map(|segment| span(&segment.driven["position"])).fold(0.0, f64::max);
    let ends = ends(stroke, number);
    let (stiffness, offset) = springs(experiment, segments, &ends, values);
    // The shares of GMS belong to its level, where that is fixed.
    let is_estimated = parameters.iter().any(|one| one.name == format!("{group}Fc"));
    let level = (!is_estimated && law == "GMS").then(|| given.value(&format!("{group}Fc"), &Values::new()));
    let mut found = elements(law, &group, &ends, stiffness, level);
    found.insert(format!("offset.{}", experiment.compared()[0]), offset);
    found
}

/// Parameters of a law with elements that slip at deflections; of GMS, whose shares belong to a level, under a fixed one.
pub fn elements(law: &str, group: &str, ends: &[f64], mut stiff: Vec<f64>, fixed_level: Option<f64>) -> Values {
    // An element that the data do not need keeps a little stiffness, since its logarithm is estimated.
    let least = 1e-4 * stiff.iter().fold(1.0, |most: f64, value| most.max(*value));
    stiff.iter_mut().for_each(|value| *value = value.max(least));
    let limits: Vec<f64> = stiff.iter().zip(ends).map(|(stiffness, end)| stiffness * end).collect();
    let total: f64 = limits.iter().sum();
    let mut found = Values::new();
    let mut set = |name: String, value: f64| found.insert(format!("{group}{name}"), value);
    if law == "Leuven" {
        // Presliding nearly as linear as under Maxwell elements, with an end about as sharp as their slip.
        let starts = [
            ("k1", stiff.iter().sum()),
            ("f1", 0.05 * total),
            ("f2", 1.0 / ends[ends.len() - 1]),
            ("Fs", 1.02 * total),
            ("Fc", total),
            ("n", 5.0),
        ];
        for (name, value) in starts {
            set(name.to_owned(), value);
        }
        return found;
    }
    let level = fixed_level.unwrap_or(total);
    for (index, ((stiffness, limit), end)) in stiff.iter().zip(&limits).zip(ends).enumerate() {
        let place = index + 1;
        for (kind, value) in
            [("k", *stiffness), ("chi0", *stiffness), ("W", *limit), ("limit", *end), ("alpha", limit / level)]
        {
            set(format!("{kind}[{place}]"), value);
        }
    }
    if law == "GMS" {
        set("Fc".to_owned(), level);
        set("Fs".to_owned(), 1.02 * level);
    }
    found
}

/// Stiffnesses in N/m of elements that slip at deflections, and the constant force beside them.
fn springs(
    experiment: &dyn Experiment,
    segments: &[MeasuredSegment],
    ends: &[f64],
    values: &Values,
) -> (Vec<f64>, f64) {
    let mut values = values.clone();
    values.insert(format!("offset.{}", experiment.compared()[0]), 0.0);
    let mut columns = vec![Vec::new(); ends.len() + 2];
    let mut forces = Vec::new();
    for segment in segments {
        let Some(map) = experiment.forces(segment, &values) else { continue };
        for (column, end) in columns.iter_mut().zip(ends) {
            let course = deflection(&segment.driven["position"], *end);
            let at_samples = interpolate(segment.record.time.iter().copied(), &segment.record.grid, &course);
            column.extend(segment.fitted().zip(&map.level).map(|(row, level)| at_samples[row] * level));
        }
        columns[ends.len()].extend(map.level.iter().map(|_| 1.0));
        columns[ends.len() + 1].extend(map.level.iter().map(|_| -1.0));
        forces.extend(map.force);
    }
    let rows = forces.len();
    let matrix = DMatrix::from_iterator(rows, columns.len(), columns.into_iter().flatten());
    let mut found = nonnegative(&matrix, &forces);
    let offset = found[ends.len()] - found[ends.len() + 1];
    found.truncate(ends.len());
    (found, offset)
}

/// Deflection of an element that slips at an end.
pub fn deflection(position: &[f64], end: f64) -> Vec<f64> {
    let mut deflected = 0.0;
    let each = |pair: &[f64]| {
        deflected = (deflected + pair[1] - pair[0]).max(-end).min(end);
        deflected
    };
    std::iter::once(0.0).chain(position.windows(2).map(each)).collect()
}
