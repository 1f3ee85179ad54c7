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
/// Samples of a sliding motion, and points of one, without which a map of friction says nothing.
const FEWEST: usize = 10;
const FEWEST_POINTS: usize = 3;

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
        fewest: if experiment.is_steady() { FEWEST_POINTS } else { FEWEST },
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
    /// Samples of a sliding motion without which nothing is said.
    pub fewest: usize,
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
    if fastest == 0.0 || pace.len() < law.fewest {
        return Values::new();
    }
    let (mut coulomb, viscous) = dry_and_viscous(own, &pace, &dry, 0.3 * fastest, law.fewest);
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
fn dry_and_viscous(own: &[(&str, &str)], pace: &[f64], dry: &[f64], least: f64, fewest: usize) -> (f64, f64) {
    let middle = median(dry).max(1e-9);
    let (fast, force): (Vec<f64>, Vec<f64>) =
        pace.iter().zip(dry).filter(|(pace, _)| **pace > least).map(|(pace, dry)| (*pace, *dry)).unzip();
    if own.iter().all(|(_, unit)| !DAMPING.contains(unit)) || fast.len() < fewest {
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::experiment::{Begin, Whole};
    use crate::record::{Record, Signals};

    const GROUP: &str = "friction.law.";

    /// Friction of a machine that slides at 10 N and `viscous` N.s/m up to 0.1 m/s, and slowly takes `peak` N more.
    fn map(load: f64, peak: f64, viscous: f64) -> Forces {
        let speed: Vec<f64> = (0..2001).map(|k| (-0.11 + 1.1e-4 * f64::from(k)).clamp(-0.1, 0.1)).collect();
        let force = |speed: &f64| {
            let slow = if speed.abs() < 0.03 { peak } else { 0.0 };
            speed.signum() * load * (10.0 + viscous * speed.abs() + slow)
        };
        Forces { force: speed.iter().map(force).collect(), level: vec![load; speed.len()], speed }
    }

    /// Starts of parameters with their units, by the ends of their names, over a stroke of 50 mm.
    fn found(law: Law<'_>, own: &[(&str, &str)], map: &Forces) -> Values {
        let names: Vec<String> = own.iter().map(|(name, _)| format!("{GROUP}{name}")).collect();
        let own: Vec<(&str, &str)> = names.iter().zip(own).map(|(name, (_, unit))| (name.as_str(), *unit)).collect();
        let starts = levels(law, &own, map, presliding(Some(0.05)));
        starts.into_iter().map(|(name, value)| (name.trim_start_matches(GROUP).to_owned(), value)).collect()
    }

    fn of(name: &str) -> Law<'_> {
        Law { name, group: GROUP, fixed_static: None, bristles: 20.0, fewest: FEWEST }
    }

    fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
        assert!((found - expected).abs() <= relative * expected.abs(), "{what}: {found}, not {expected}");
    }

    /// Presliding ends at a fiftieth of the stroke, 1 mm; what is a function of speed has faded at a tenth of the fastest, where
    /// the damping of bristles is a tenth of their force.
    #[test]
    fn levels_of_a_map_are_those_of_its_friction_at_any_load() {
        type Parameters<'a> = &'a [(&'a str, &'a str, f64)];
        let cases: [(&str, Parameters); 9] = [
            ("Stribeck", &[("Fc", "N", 10.0), ("Fs", "N", 14.0), ("vs", "m/s", 0.01), ("sigma2", "N.s/m", 20.0)]),
            ("LuGre", &[("Fs", "N", 14.0), ("sigma0", "N/m", 1e4), ("sigma1", "N.s/m", 10.0), ("vd", "m/s", 0.1)]),
            ("Polito", &[("Fc1", "N", 10.0), ("Fc2", "N", 10.0), ("c1", "N.s/m", 20.0), ("c2", "N.s/m", 20.0)]),
            ("StickSlipCreep", &[("Fs", "N", 14.0), ("Delta", "m", 1e-3), ("sigma2", "N.s/m", 20.0)]),
            // Excess of static over sliding friction.
            ("Armstrong", &[("FsInf", "N", 4.0), ("Fc", "N", 10.0), ("sigma2", "N.s/m", 20.0)]),
            // A fast and a slow part, whose difference slides at 10 N.
            ("BlimanSorine", &[("f1", "N", 30.0), ("f2", "N", 20.0), ("xe", "m", 1e-3), ("sigma2", "N.s/m", 20.0)]),
            // Twenty bristles are bent by two thirds on average.
            ("Bristle", &[("sigma0", "N/m", 750.0), ("deltaS", "m", 1e-3), ("sigma2", "N.s/m", 20.0)]),
            ("Leuven", &[("f1", "N", 6.0), ("f2", "1/m", 3e3), ("k1", "N/m", 3e3), ("sigma2", "N.s/m", 20.0)]),
            // Four elements of a quarter each.
            ("MaxwellSlip", &[("W[1]", "N", 2.5), ("k[4]", "N/m", 2.5e3), ("sigma2", "N.s/m", 20.0)]),
        ];
        for (law, parameters) in cases {
            let own: Vec<(&str, &str)> = parameters.iter().map(|(name, unit, _)| (*name, *unit)).collect();
            for load in [1.0, 0.5] {
                let starts = found(of(law), &own, &map(load, 4.0, 20.0));
                assert_eq!(starts.len(), own.len(), "{law}: {starts:?}");
                for (name, _, expected) in parameters {
                    assert_close(starts[*name], *expected, 1e-12, &format!("{law}, {name}"));
                }
            }
        }
    }

    #[test]
    fn levels_stay_in_proportion() {
        let own = [("Fc", "N"), ("Fs", "N"), ("sigma2", "N.s/m")];
        for (peak, expected) in [(0.5, 11.0), (50.0, 30.0)] {
            assert_close(found(of("Stribeck"), &own, &map(1.0, peak, 20.0))["Fs"], expected, 1e-12, "break-away");
        }
        // Below a break-away that is known.
        let fixed = Law { fixed_static: Some(9.0), ..of("Stribeck") };
        assert_close(found(fixed, &own[..1], &map(1.0, 4.0, 20.0))["Fc"], 7.2, 1e-12, "sliding friction");
        // Without viscous friction that is estimated the middle is what slides, and a line that falls is none of it.
        assert_close(found(of("Stribeck"), &own[..2], &map(1.0, 4.0, 0.0))["Fc"], 10.0, 1e-12, "level");
        let falling = found(of("Stribeck"), &own, &map(1.0, 4.0, -20.0));
        assert_close(falling["Fc"], 10.0 - 20.0 * 0.055, 0.02, "middle of a falling line, at 55 mm/s");
        assert_close(falling["sigma2"], 0.05 * falling["Fc"] / 0.1, 1e-12, "least");
    }

    #[test]
    fn nothing_is_guessed_of_a_map_that_tells_nothing() {
        let (own, whole) = ([("Fc", "N")], map(1.0, 4.0, 20.0));
        let still = Forces { speed: vec![0.0; 2001], ..whole.clone() };
        let mut few = still.clone();
        few.speed[..15].copy_from_slice(&whole.speed[..15]);
        let unloaded = Forces { level: vec![0.0; 2001], ..whole.clone() };
        let cut = |values: &[f64]| values[..9].to_vec();
        let short = Forces { speed: cut(&whole.speed), force: cut(&whole.force), level: cut(&whole.level) };
        for map in [still, few, unloaded, short] {
            assert!(found(of("Stribeck"), &own, &map).is_empty());
        }
        assert!(found(of("Stribeck"), &[], &whole).is_empty());
    }

    /// Up by 80 mm, down, and up again, 1 mm each time.
    #[test]
    fn an_element_follows_until_it_slips() {
        let way: Vec<f64> = (0..=80).chain((0..80).rev()).chain(1..=80).map(|k| 1e-3 * f64::from(k)).collect();
        for end in [5e-4, 0.01, 0.07] {
            let top: f64 = end;
            let bottom = (top - 0.08).max(-end);
            for (row, (place, found)) in way.iter().zip(deflection(&way, end)).enumerate() {
                let expected = match row {
                    0..=80 => place.min(end),
                    81..=160 => (top - 0.08 + place).max(-end),
                    _ => (bottom + place).min(end),
                };
                assert!((found - expected).abs() < 1e-15, "{found} at row {row} of {end}, not {expected}");
            }
        }
    }

    #[test]
    fn elements_of_each_law_make_the_same_force() {
        let ends = ends(0.08, 4);
        let stiff = vec![4e3, 500.0, 0.0, 20.0];
        let limits: Vec<f64> = stiff.iter().zip(&ends).map(|(stiff, end)| stiff * end).collect();
        for (place, ratio) in ends.windows(2).map(|pair| pair[1] / pair[0]).enumerate() {
            assert_close(ratio, libm::pow(100.0, 1.0 / 3.0), 1e-12, &format!("ratio {place}"));
        }
        assert_close(ends[3], 0.08, 1e-15, "the longest");
        let of = |law, level| elements(law, GROUP, &ends, stiff.clone(), level);
        let at = |found: &Values, name: &str| found[&format!("{GROUP}{name}")];
        let maxwell = of("MaxwellSlip", None);
        assert_close(at(&maxwell, "k[2]"), 500.0, 1e-15, "stiffness");
        assert_close(at(&maxwell, "W[1]"), limits[0], 1e-15, "limit");
        assert_close(at(&of("DNLRX", None), "limit[4]"), ends[3], 1e-15, "end");
        // One that the data do not need keeps a little, since its logarithm is estimated.
        assert_close(at(&maxwell, "k[3]"), 4e3 * 1e-4, 1e-12, "least stiffness");
        assert_close(at(&elements("GMS", GROUP, &ends, vec![0.0; 4], None), "k[1]"), 1e-4, 1e-12, "of no force");
        // The shares of GMS are of a level that stays, or they make one.
        let total: f64 = limits.iter().sum::<f64>() + 0.4 * ends[2];
        for (fixed, level) in [(Some(8.3), 8.3), (None, total)] {
            let found = of("GMS", fixed);
            assert_close(at(&found, "Fs"), 1.02 * level, 1e-12, "break-away");
            assert_close(at(&found, "alpha[1]"), limits[0] / level, 1e-12, "share");
        }
        let smooth = of("Leuven", None);
        assert_close(at(&smooth, "k1"), 4520.4, 1e-12, "stiffness of all");
        assert_close(at(&smooth, "Fc"), total, 1e-12, "level");
    }

    #[test]
    fn an_area_is_what_the_force_grows_with_the_pressure() {
        let segment = |pressure: [f64; 4], friction: [f64; 4]| {
            let force = pressure.iter().zip(friction).map(|(pressure, friction)| 2e-4 * pressure + friction).collect();
            let signals: Signals = [("pressure".to_owned(), pressure.to_vec()), ("force".to_owned(), force)].into();
            MeasuredSegment {
                record: Record::new(vec![0.0, 1.0, 2.0, 3.0], 0.0, signals),
                driven: Signals::new(),
                used: vec![true, true, true, false],
                is_validation: vec![false; 4],
                begin: Begin::default(),
                number: 0,
                whole: Arc::new(Whole { begin: 0.0, grid: vec![], driven: Signals::new() }),
            }
        };
        let both = [
            segment([1e5, 2e5, 3e5, 5e5], [3.0, 3.0, -3.0, 700.0]),
            segment([2e5, 4e5, 6e5, 1e5], [-5.0, -5.0, 5.0, 900.0]),
        ];
        assert_close(area(&both), 2e-4, 1e-14, "area");
        assert_eq!(area(&[segment([0.0; 4], [1.0; 4])]), 0.0);
        assert_close(presliding(None), 2e-5, 1e-14, "length of no stroke that is measured");
    }
}
