//! Causes of residuals: fixed settings, thermal models and sensors that would explain what a fit leaves.
//!
//! Each candidate is asked by a run how much of the residual would be gone if it were estimated, all parameters moving along
//! (a score test: C. R. Rao, "Large sample tests of statistical hypotheses concerning several parameters", 1948). The most
//! promising are estimated along, since a pressure off by an atmosphere, or a bore by a quarter, is no small change.

use nalgebra::DMatrix;
use pneumatic_servo::variables::{Kind, Role};

use crate::experiment::parameter;
use crate::intervals::certainty;
use crate::jacobian::{scale_rows, sensitivities};
use crate::matrix::orthogonal;
use crate::parameter::{Parameter, SPAN, Values};
use crate::problem::{FAILED, Interrupted, Problem, Simulated, TOLERANCE};
use crate::record::unit_of;
use crate::runs::Runs;
use crate::search::{Loss, ROUGH, Solution, Unwatched, refine};

/// Share of the squared residual of a signal that a cause has to explain.
pub const MUCH: f64 = 0.5;
/// Share of the squared residuals from which on a candidate is estimated along.
const PROMISING: f64 = 0.05;
/// Most settings, and most sensors, that are estimated along.
const ESTIMATED: usize = 4;
/// A direction of which the estimated parameters leave less than this share is theirs.
const BLIND: f64 = 1e-6;
/// Share of the explanation of the best sensor with which a setting comes first: both may be the same change of the simulation.
const SAME: f64 = 0.95;
/// Change of a setting, in logarithms or magnitudes, or of a sensor in magnitudes.
const STEP: f64 = 0.05;
/// Delays and lags in s that are tried: their effect is not in proportion to them.
const TIMES: [f64; 4] = [0.003, 0.01, 0.02, 0.04];
/// Offset of a pressure in Pa, within a share of it, that counts from the atmosphere.
const ATMOSPHERE: f64 = 101_325.0;
const NEAR: f64 = 0.2;
/// Settings that a rig may have otherwise than they are given.
const OF_RIG: [&str; 12] = [
    "supplyPressure",
    "cylinder.bore",
    "cylinder.rod",
    "chamberA.deadVolume",
    "chamberB.deadVolume",
    "valve.C",
    "valve.b",
    "valve.deadZone",
    "valve.leakage",
    "mass.moving",
    "wireForce",
    "friction.direction.factor",
];
const OF_BENCH: [&str; 1] = ["friction.direction.factor"];
/// SI units of the parameters of a law that a fit usually estimates.
const OF_LAW: [&str; 6] = ["N", "N/m", "N.s/m", "m/s", "1/m", "m"];
const MODEL: &str = "thermal.model";

/// A setting, a thermal model or a sensor that would explain the residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Name of the parameter, and what it is fixed at: a number with its SI unit, or the name of a model.
    pub name: String,
    /// Explanation in a sentence, without the full stop.
    pub text: String,
    /// Estimated value and the ends of its 95 % interval, in SI units; of a thermal model nothing.
    pub estimate: Option<(f64, [f64; 2])>,
    /// Share of the squared residual of the signal that it explains most of.
    pub share: f64,
    /// Decrease of the sum of squares, in units of the noise.
    gain: f64,
    is_sensor: bool,
}

/// The cause that explains most of the residuals at a solution; nothing if none explains much.
///
/// # Errors
/// [`Interrupted`].
pub fn cause(runs: &Runs<'_>, fitted: &Problem<'_>, x: &[f64]) -> Result<Option<Cause>, Interrupted> {
    let search = match Search::of(runs, fitted, x)? {
        Some(search) => search,
        None => return Ok(None),
    };
    let mut found = search.models()?;
    for is_sensor in [false, true] {
        for candidate in search.promising(is_sensor)? {
            found.extend(search.estimated(candidate, is_sensor)?);
        }
    }
    let best = |is_sensor: bool| {
        let own = found.iter().filter(|one| one.is_sensor == is_sensor && one.share > MUCH);
        own.max_by(|one, other| one.gain.total_cmp(&other.gain)).cloned()
    };
    Ok(match (best(false), best(true)) {
        (Some(setting), Some(sensor)) if setting.gain < SAME * sensor.gain => Some(sensor),
        (setting, sensor) => setting.or(sensor),
    })
}

/// A candidate, and the inner value at which it would explain most in proportion.
struct Candidate {
    parameter: Parameter,
    inner: f64,
    promise: f64,
}

/// A solution, and what it leaves.
struct Search<'a> {
    runs: &'a Runs<'a>,
    fitted: &'a Problem<'a>,
    x: &'a [f64],
    differences: Vec<f64>,
    weights: Vec<f64>,
    columns: DMatrix<f64>,
    /// Weighted differences that no estimated parameter can lessen.
    left: DMatrix<f64>,
    before: Vec<f64>,
}

impl<'a> Search<'a> {
    /// Nothing where a run has failed, or where noise is most of the residual of each signal.
    fn of(runs: &'a Runs<'a>, fitted: &'a Problem<'a>, x: &'a [f64]) -> Result<Option<Self>, Interrupted> {
        let differences = fitted.simulated.differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0);
        let before = fitted.residuals(&differences);
        if before.iter().any(|residual| residual.abs() == FAILED) {
            return Ok(None);
        }
        let weights = fitted.by_sensor(&differences, |sensor, difference| sensor.weight(difference));
        let mut columns = sensitivities(fitted, x, &differences, TOLERANCE, true)?;
        scale_rows(&mut columns, &weights);
        let weighted = differences.iter().zip(&weights).map(|(difference, weight)| difference * weight);
        let left = orthogonal(DMatrix::from_iterator(differences.len(), 1, weighted), &columns);
        Ok(Some(Self { runs, fitted, x, differences, weights, columns, left, before }))
    }

    /// Names of settings or of properties of sensors that are not estimated.
    fn names(&self, is_sensor: bool) -> Vec<String> {
        let experiment = self.runs.experiment;
        let given = experiment.given();
        let names: Vec<String> = if is_sensor {
            let of = |kinds: &'static [&'static str], signals: Vec<&'static str>| {
                let names = signals
                    .into_iter()
                    .flat_map(move |signal| kinds.iter().map(move |kind| format!("{kind}.{signal}")));
                names.collect::<Vec<_>>()
            };
            let both = [experiment.compared().to_vec(), experiment.driving()].concat();
            [of(&["gain", "offset", "delay"], both), of(&["lag"], experiment.compared().to_vec())].concat()
        } else {
            let group = given.law_group();
            let is_usual = |name: &str, unit: &str, start: Option<f64>| {
                name.starts_with(&group) && !name.contains('[') && OF_LAW.contains(&unit) && start != Some(0.0)
            };
            let of_law = given.model.table().parameters().filter_map(|variable| match variable.kind {
                Kind::Real(unit) if is_usual(&variable.name, unit.name, variable.start) => {
                    Some(variable.name.to_string())
                }
                _ => None,
            });
            let own: &[&str] = if given.model.name == "FrictionBench" { &OF_BENCH } else { &OF_RIG };
            let of_machine = own.iter().map(|name| (*name).to_owned());
            of_machine.chain(of_law.filter(|_| !group.is_empty())).collect()
        };
        let is_fixed = |name: &String| {
            let is_known_sensor = is_sensor && given.known.contains_key(name);
            !is_known_sensor
                && !given.signals.contains(name)
                && self.runs.parameters.iter().all(|one| one.name != *name)
        };
        names.into_iter().filter(is_fixed).collect()
    }

    /// A fixed property as an estimated one; nothing for one that is off, as a volume of 0.
    fn freed(&self, name: &str) -> Option<Parameter> {
        let given = self.runs.experiment.given();
        if let Some(entry) = given.model.table().find(name)
            && entry.variable.role == Role::Input
        {
            let start = given.value(name, &Values::new());
            let bounds = [start / SPAN, start * SPAN];
            return (start > 0.0).then(|| Parameter::of_input(name, unit_of(name), start, bounds));
        }
        let free = parameter(self.runs.experiment, name).ok()?;
        let start = given.beside(name, &Values::new(), free.start);
        if free.is_logarithmic() && start <= 0.0 { None } else { Some(free.at(start)) }
    }

    /// The runs with another estimated parameter, or with another fixed value.
    fn with(&self, parameter: Option<Parameter>, fixed: Values) -> Runs<'a> {
        let parameters = self.runs.parameters.iter().cloned().chain(parameter).collect();
        Runs { parameters, segments: self.runs.segments.clone(), fixed, ..*self.runs }
    }

    /// The problem of such runs, with the sensors of the fit.
    fn problem<'b>(&self, runs: &'b Runs<'_>) -> Problem<'b> {
        Problem {
            parameters: runs.parameters.clone(),
            segments: runs.layout(),
            sensors: self.fitted.sensors.clone(),
            simulated: runs,
            step: self.fitted.step,
        }
    }

    /// A vector with the inner value of one more parameter.
    fn inserted(&self, x: &[f64], inner: f64) -> Vec<f64> {
        let own = self.runs.parameters.len();
        [&x[..own], &[inner], &x[own..]].concat()
    }

    /// The candidates whose small changes explain most, the best first.
    fn promising(&self, is_sensor: bool) -> Result<Vec<Candidate>, Interrupted> {
        let mut found = Vec::new();
        for parameter in self.names(is_sensor).iter().filter_map(|name| self.freed(name)) {
            let first = parameter.inner(parameter.start);
            let inner = |time: &f64| time / parameter.scale;
            let steps: Vec<f64> = match parameter.name.split_once('.') {
                Some(("delay", _)) if is_sensor => TIMES.iter().flat_map(|time| [inner(time), -inner(time)]).collect(),
                Some(("lag", _)) if is_sensor => TIMES.iter().map(inner).collect(),
                _ => vec![STEP],
            };
            let runs = self.with(Some(parameter.clone()), self.runs.fixed.clone());
            let vectors: Vec<_> = steps.iter().map(|step| self.inserted(self.x, first + step)).collect();
            let tried = runs.differences(&vectors, TOLERANCE)?;
            let of_step = |(step, run): (&f64, &Vec<f64>)| self.explained(&parameter, first, *step, run);
            let best =
                steps.iter().zip(&tried).filter_map(of_step).max_by(|one, other| one.promise.total_cmp(&other.promise));
            found.extend(best);
        }
        let all = self.left.norm_squared();
        found.retain(|one| one.promise > PROMISING * all);
        found.sort_by(|one, other| other.promise.total_cmp(&one.promise));
        found.truncate(ESTIMATED);
        Ok(found)
    }

    /// The share that a candidate explains, if its effect is in proportion to a step; nothing without an effect of its own.
    fn explained(&self, parameter: &Parameter, first: f64, step: f64, run: &[f64]) -> Option<Candidate> {
        let moved =
            run.iter().zip(&self.differences).zip(&self.weights).map(|((run, own), weight)| (run - own) * weight);
        let column = DMatrix::from_iterator(run.len(), 1, moved);
        let whole = column.norm_squared();
        let own = orthogonal(column, &self.columns);
        let (size, product) = (own.norm_squared(), own.dot(&self.left));
        if !(size.is_finite() && size > BLIND * whole) {
            return None;
        }
        let inner = first - step * product / size;
        let [low, high] = parameter.inner_bounds();
        (low..=high).contains(&inner).then(|| Candidate {
            parameter: parameter.clone(),
            inner,
            promise: product * product / size,
        })
    }

    /// A candidate that is estimated along with all that is.
    fn estimated(&self, candidate: Candidate, is_sensor: bool) -> Result<Option<Cause>, Interrupted> {
        let Candidate { parameter, inner, .. } = candidate;
        let runs = self.with(Some(parameter.clone()), self.runs.fixed.clone());
        let problem = self.problem(&runs);
        // A setting far off is no small change, so that its search begins at what is given.
        let first = if is_sensor { inner } else { parameter.inner(parameter.start) };
        let end = self.refined(&problem, &self.inserted(self.x, first))?;
        let place = self.runs.parameters.len();
        let value = parameter.outer(end.x[place]);
        let interval = certainty(&problem, &end.x)?.intervals[place];
        let text =
            if is_sensor { of_sensor(&parameter, value, interval) } else { of_setting(&parameter, value, interval) };
        self.judged(&problem, &end, parameter.name, text, Some((value, interval)), is_sensor)
    }

    /// The other thermal models of a rig.
    fn models(&self) -> Result<Vec<Cause>, Interrupted> {
        let given = self.runs.experiment.given();
        let mut found = Vec::new();
        let Some(Kind::Enumeration(models)) = given.model.table().find(MODEL).map(|entry| entry.variable.kind) else {
            return Ok(found);
        };
        let own = given.value(MODEL, &Values::new());
        if self.runs.parameters.iter().any(|one| one.name.starts_with("thermal.")) {
            return Ok(found);
        }
        let name =
            |id: f64| models.items.iter().find(|(item, ..)| f64::from(*item) == id).map_or("", |(_, name, _)| *name);
        for (id, other, _) in models.items.iter().filter(|(id, ..)| f64::from(*id) != own) {
            let runs = self.with(None, [(MODEL.to_owned(), f64::from(*id))].into());
            let problem = self.problem(&runs);
            let end = self.refined(&problem, self.x)?;
            let text = format!("{MODEL} were {other} in place of {}: is the setting right?", name(own));
            found.extend(self.judged(&problem, &end, MODEL.to_owned(), text, None, false)?);
        }
        Ok(found)
    }

    /// The better end of two searches: from where the wrong setting has led, and from the first start.
    fn refined(&self, problem: &Problem<'_>, x: &[f64]) -> Result<Solution, Interrupted> {
        let one = refine(problem, x, Loss::Linear, ROUGH, &Unwatched)?;
        let other = refine(problem, &problem.start(), Loss::Linear, ROUGH, &Unwatched)?;
        Ok(if other.cost < one.cost { other } else { one })
    }

    fn judged(
        &self,
        problem: &Problem<'_>,
        end: &Solution,
        name: String,
        text: String,
        estimate: Option<(f64, [f64; 2])>,
        is_sensor: bool,
    ) -> Result<Option<Cause>, Interrupted> {
        let differences = problem.simulated.differences(std::slice::from_ref(&end.x), TOLERANCE)?.swap_remove(0);
        let after = problem.residuals(&differences);
        if after.iter().any(|residual| residual.abs() == FAILED) {
            return Ok(None);
        }
        let squares = |residuals: &[f64]| residuals.iter().map(|residual| residual * residual).sum::<f64>();
        let (signal, share) = self.most_explained(&after);
        let text = format!("{:.0} % of the squared residual of {signal} would be gone if {text}", 100.0 * share);
        Ok(Some(Cause { name, text, estimate, share, gain: squares(&self.before) - squares(&after), is_sensor }))
    }

    /// The signal of whose squares the largest share is gone, and this share.
    fn most_explained(&self, after: &[f64]) -> (&'static str, f64) {
        let signals = self.runs.experiment.compared();
        let mut squares = vec![[0.0; 2]; signals.len()];
        let mut row = 0;
        for segment in &self.fitted.segments {
            for own in &mut squares {
                let rows = row..row + segment.samples;
                for (before, after) in self.before[rows.clone()].iter().zip(&after[rows]) {
                    own[0] += before * before;
                    own[1] += after * after;
                }
                row += segment.samples;
            }
        }
        let shares = squares.iter().map(|[before, after]| 1.0 - after / before.max(1e-300));
        let pairs = signals.iter().copied().zip(shares);
        pairs.max_by(|(_, one), (_, other)| one.total_cmp(other)).expect("a signal is compared")
    }
}

fn of_setting(parameter: &Parameter, value: f64, [low, high]: [f64; 2]) -> String {
    let Parameter { name, unit, start, .. } = parameter;
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let is_gauge = unit == " Pa" && (value - start - ATMOSPHERE).abs() < NEAR * ATMOSPHERE;
    let hint = if is_gauge {
        "was it given above ambient pressure? Pressures are absolute"
    } else {
        "check it, or estimate it"
    };
    let [start, value, low, high] = [*start, value, low, high].map(short);
    format!("{name}, fixed at {start}{unit}, were {value} [{low}, {high}]{unit}: {hint}")
}

fn of_sensor(parameter: &Parameter, value: f64, [low, high]: [f64; 2]) -> String {
    let Parameter { name, unit, .. } = parameter;
    let (kind, signal) = name.split_once('.').unwrap_or(("", name));
    let times = if unit == "s" { 1e3 } else { 1.0 };
    let [value, low, high] = [value, low, high].map(|number| short(times * number));
    let size = format!("{value} [{low}, {high}]");
    let fault = match kind {
        "gain" => format!("{signal} were {size} times its readings"),
        "offset" => format!("{size} {unit} of {signal} were an offset of its sensor"),
        "lag" => format!("{signal} went through a filter of {size} ms"),
        _ => format!("{signal} were read {size} ms late"),
    };
    format!("{fault}: estimate {name}")
}

/// A number of five digits.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let exponent = libm::floor(libm::log10(value.abs())) as i32;
    if !(-4..7).contains(&exponent) {
        return format!("{value:.4e}");
    }
    let text = format!("{value:.*}", (4 - exponent).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
