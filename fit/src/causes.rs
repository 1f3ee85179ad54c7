//! Causes of residuals: fixed settings, choices, clocks and sensors that would explain what a fit leaves.
//!
//! Each candidate is asked by a run how much of the residual would be gone if it were estimated, all parameters moving along
//! (a score test: C. R. Rao, "Large sample tests of statistical hypotheses concerning several parameters", 1948). The most
//! promising are estimated along, since a pressure off by an atmosphere, or a bore by a quarter, is no small change.

use nalgebra::DMatrix;

use crate::intervals::{Ends, certainty};
use crate::jacobian::{scale_rows, sensitivities};
use crate::matrix::orthogonal;
use crate::numerals::significant;
use crate::parameter::Parameter;
use crate::problem::{FAILED, Interrupted, Problem, Simulated, TOLERANCE};
use crate::search::{FINE, Loss, ROUGH, Solution, Unwatched, refine};

/// Share of the squared residual of a signal that a cause has to explain.
const MUCH: f64 = 0.5;
/// Share of the squared residuals from which on a candidate is estimated along.
const PROMISING: f64 = 0.05;
/// Most settings that are estimated along.
const ESTIMATED: usize = 4;
/// A direction of which the estimated parameters leave less than this share is theirs.
const BLIND: f64 = 1e-6;
/// Share of the explanation of the best cause with which another one explains as much.
const SAME: f64 = 0.95;
/// Change of a setting, in logarithms or magnitudes, or of a sensor in magnitudes.
const STEP: f64 = 0.05;
/// Delays and lags in s that are tried: their effect is not in proportion to them.
const TIMES: [f64; 4] = [0.003, 0.01, 0.02, 0.04];
/// Share by which a clock is changed, the most that it is changed at once, and the number of refinements.
const CLOCK: f64 = 0.01;
const MOST_CLOCK: f64 = 0.2;
const ROUNDS: usize = 2;
/// Half intervals, and share, by which a clock is off that is named although little more than noise is left.
const SURE: f64 = 10.0;
const OFF: f64 = 0.005;
/// Half a 95 % interval in standard deviations.
const HALF: f64 = 1.96;
/// Offset of a pressure in Pa, within a share of it, that counts from the atmosphere.
const ATMOSPHERE: f64 = 101_325.0;
const NEAR: f64 = 0.2;
/// Name of the cause that is a clock.
const TIME: &str = "time";
/// Name of the choice of a thermal model.
pub const MODEL: &str = "thermal.model";
/// Name of the choice of what measured pressures count from, and its items: absolute pressures are the model's.
pub const PRESSURES: &str = "the pressures of both chambers";
/// Both chambers count from the atmosphere.
pub const GAUGE: &str = "from the atmosphere";
/// The supply does, too.
pub const ALL_GAUGE: &str = "from the atmosphere, like the supply";
/// Speed in m/s above which the damping of LuGre's bristles decays; with 0 it is constant, as in the first publication.
pub const DAMPING_SPEED: &str = "friction.lugre.vd";

/// Settings of the machine that may be given wrongly, by the name of the experiment; parameters of the law come on top.
pub fn suspected(experiment: &str) -> Vec<&'static str> {
    const GAS: [&str; 9] = [
        "supplyPressure",
        "cylinder.bore",
        "cylinder.rod",
        "chamberA.deadVolume",
        "chamberB.deadVolume",
        "valve.C",
        "valve.b",
        "valve.deadZone",
        "valve.leakage",
    ];
    const MOTION: [&str; 3] = ["mass.moving", "wireForce", "friction.direction.factor"];
    match experiment {
        "rig" => [&GAS[..], &MOTION].concat(),
        "pneumatic" => GAS.to_vec(),
        "mechanical" => [&GAS[1..3], &MOTION].concat(),
        "force" => vec!["mass", "friction.direction.factor"],
        _ => vec!["friction.direction.factor"],
    }
}

/// Whether more than friction depends on time in an experiment, so that it tells a wrong clock.
pub fn is_clocked(experiment: &str) -> bool {
    !["motion", "points"].contains(&experiment)
}

/// Whether RMS residuals of signals beside the noise of their sensors are hardly more than noise: of noise no cause explains much.
pub fn is_quiet(residuals: impl IntoIterator<Item = (f64, f64)>) -> bool {
    !residuals.into_iter().any(|(rms, noise)| rms * rms * (1.0 - MUCH) > noise * noise)
}

/// A fixed setting, a choice, a clock or a sensor that would explain the residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Name of the parameter; `time` of a clock.
    pub name: String,
    /// Explanation in a sentence, without the full stop.
    pub text: String,
    /// Estimated value and the ends of its 95 % interval, in SI units.
    pub estimate: Option<(f64, [f64; 2])>,
    /// Item of a choice that explains the residuals.
    pub item: Option<String>,
    /// Signal of whose squared residual it explains most, and the share of it.
    pub signal: String,
    /// This share.
    pub share: f64,
    /// Decrease of the sum of squares, in units of the noise.
    pub gain: f64,
    /// Other settings that would explain as much: with time the mass that goes with its square, for example.
    pub alike: Vec<String>,
    /// Whether it is a fault of a sensor.
    pub is_sensor: bool,
}

/// A choice among few: its name, the fixed item, and the others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Name of the setting.
    pub name: String,
    /// Its fixed item: a name, or a number in SI units.
    pub fixed: String,
    /// The other items.
    pub others: Vec<String>,
}

/// Fixed values that may be causes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Candidates {
    /// Settings; each starts at its fixed value.
    pub settings: Vec<Parameter>,
    /// Properties of sensors; each starts at its fixed value.
    pub sensors: Vec<Parameter>,
    /// Choices, as of a thermal model.
    pub choices: Vec<Choice>,
    /// Whether the clock may be one.
    pub has_clock: bool,
}

/// A change of something fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change<'a> {
    /// The parameter is estimated: a vector has its inner value behind the other parameters.
    Estimated(&'a Parameter),
    /// Another item of a choice.
    Chosen {
        /// Name of the setting.
        name: &'a str,
        /// The item.
        item: &'a str,
    },
    /// True time is the recorded one times a factor.
    Clock(f64),
}

/// A simulation of which fixed values can be changed.
pub trait Changeable {
    /// Names of the compared signals.
    fn signals(&self) -> Vec<String>;

    /// The simulation with a change.
    ///
    /// # Errors
    /// [`Interrupted`].
    fn changed<'a>(&'a self, change: Change<'a>) -> Result<Box<dyn Simulated + 'a>, Interrupted>;
}

/// Causes that explain much of the residuals at a solution, the best first: at most one setting, choice or clock, and one sensor. Of
/// residuals that are hardly more than noise only a wrong clock is a cause: the conductance of a valve makes up
/// for most of it, and inertia shows the rest.
///
/// # Errors
/// [`Interrupted`].
pub fn causes(
    changeable: &dyn Changeable,
    candidates: &Candidates,
    fitted: &Problem<'_>,
    x: &[f64],
    is_noise: bool,
) -> Result<Vec<Cause>, Interrupted> {
    if is_noise && !candidates.has_clock {
        return Ok(vec![]);
    }
    let Some(at) = Tangent::of(fitted, x)? else { return Ok(vec![]) };
    let before = fitted.residuals(&at.differences);
    let search = Search { changeable, signals: changeable.signals(), fitted, x, at, before };
    if is_noise {
        return Ok(search.clock(OFF)?.filter(is_sure).into_iter().collect());
    }
    let mut found = Vec::new();
    for candidate in search.promising(&candidates.settings)? {
        found.extend(search.setting(&candidate.parameter)?);
    }
    for choice in &candidates.choices {
        for item in &choice.others {
            found.extend(search.chosen(choice, item)?);
        }
    }
    if candidates.has_clock {
        found.extend(search.clock(0.0)?);
    }
    Ok(match (best(found), search.sensor(&candidates.sensors)?) {
        // A setting that explains about as much comes first: both may be the same change of the simulation.
        (Some(setting), Some(sensor)) if setting.gain < SAME * sensor.gain => vec![sensor, setting],
        (setting, sensor) => setting.into_iter().chain(sensor).collect(),
    })
}

/// The cause that explains most, if it is much, and those that explain as much.
fn best(found: Vec<Cause>) -> Option<Cause> {
    let much = found.iter().filter(|one| one.share > MUCH);
    let best = much.max_by(|one, other| one.gain.total_cmp(&other.gain))?;
    // An item of a choice says more than the number that comes close to it.
    let is_item = |one: &&Cause| one.name == best.name && one.item.is_some() && one.gain > SAME * best.gain;
    let mut best = found.iter().find(is_item).unwrap_or(best).clone();
    let is_alike = |one: &&Cause| one.name != best.name && one.gain > SAME * best.gain;
    let alike: Vec<String> = found.iter().filter(is_alike).map(|one| one.name.clone()).collect();
    if !alike.is_empty() {
        best.text = format!("{}; as much would be gone with another {}", best.text, alike.join(", "));
    }
    best.alike = alike;
    Some(best)
}

/// Whether an interval excludes the fixed value; one that does not tells nothing of it.
fn is_apart(parameter: &Parameter, [low, high]: [f64; 2]) -> bool {
    !(low..=high).contains(&parameter.start)
}

/// Whether a clock is off by much more than its interval.
fn is_sure(clock: &Cause) -> bool {
    clock.estimate.is_some_and(|(value, [_, high])| (value - 1.0).abs() > (SURE * (high - value)).max(OFF))
}

/// A candidate, and the inner value at which it would explain most in proportion.
struct Candidate {
    parameter: Parameter,
    inner: f64,
    /// Decrease of the sum of squares in units of the noise, if its effect is in proportion.
    promise: f64,
    /// Largest share of the squares of a signal that is gone then.
    share: f64,
}

/// A problem about a vector.
struct Tangent {
    differences: Vec<f64>,
    weights: Vec<f64>,
    columns: DMatrix<f64>,
    /// Weighted differences that no estimated parameter can lessen.
    left: DMatrix<f64>,
}

impl Tangent {
    /// Nothing where a run has failed, or where nothing is left.
    fn of(problem: &Problem<'_>, x: &[f64]) -> Result<Option<Self>, Interrupted> {
        let differences = problem.simulated.differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0);
        if differences.iter().any(|difference| !difference.is_finite()) {
            return Ok(None);
        }
        let weights = problem.by_sensor(&differences, |sensor, difference| sensor.weight(difference));
        let mut columns = sensitivities(problem, x, &differences, TOLERANCE, true)?;
        scale_rows(&mut columns, &weights);
        let weighted = differences.iter().zip(&weights).map(|(difference, weight)| difference * weight);
        let left = orthogonal(DMatrix::from_iterator(differences.len(), 1, weighted), &columns);
        Ok((left.norm_squared() > 0.0).then_some(Self { differences, weights, columns, left }))
    }

    /// Weighted change of a run that no estimated parameter can make; nothing if it has none of its own.
    fn own(&self, run: &[f64]) -> Option<DMatrix<f64>> {
        let moved =
            run.iter().zip(&self.differences).zip(&self.weights).map(|((run, own), weight)| (run - own) * weight);
        let column = DMatrix::from_iterator(run.len(), 1, moved);
        let whole = column.norm_squared();
        let own = orthogonal(column, &self.columns);
        let size = own.norm_squared();
        (size.is_finite() && size > BLIND * whole).then_some(own)
    }
}

/// The search for causes at a solution.
struct Search<'a> {
    changeable: &'a dyn Changeable,
    /// Names of the compared signals.
    signals: Vec<String>,
    fitted: &'a Problem<'a>,
    x: &'a [f64],
    at: Tangent,
    before: Vec<f64>,
}

impl Search<'_> {
    /// The fitted problem with another simulation and one more parameter.
    fn problem<'b>(&self, simulated: &'b dyn Simulated, more: Option<&Parameter>) -> Problem<'b> {
        Problem {
            parameters: self.fitted.parameters.iter().chain(more).cloned().collect(),
            segments: self.fitted.segments.clone(),
            sensors: self.fitted.sensors.clone(),
            simulated,
            step: self.fitted.step,
        }
    }

    /// The solution with the inner value of one more parameter.
    fn inserted(&self, inner: f64) -> Vec<f64> {
        let own = self.fitted.parameters.len();
        [&self.x[..own], &[inner], &self.x[own..]].concat()
    }

    /// The candidates whose small changes explain most, the best first.
    fn promising(&self, candidates: &[Parameter]) -> Result<Vec<Candidate>, Interrupted> {
        let mut found = Vec::new();
        for parameter in candidates {
            let first = parameter.inner(parameter.start);
            let inner = |time: &f64| time / parameter.scale;
            let steps: Vec<f64> = match parameter.name.split_once('.') {
                Some(("delay", _)) => TIMES.iter().flat_map(|time| [inner(time), -inner(time)]).collect(),
                Some(("lag", _)) => TIMES.iter().map(inner).collect(),
                _ => vec![STEP],
            };
            let simulated = self.changeable.changed(Change::Estimated(parameter))?;
            let vectors: Vec<_> = steps.iter().map(|step| self.inserted(first + step)).collect();
            let tried = simulated.differences(&vectors, TOLERANCE)?;
            let of_step = |(step, run): (&f64, &Vec<f64>)| self.explained(parameter, first, *step, run);
            let tried = steps.iter().zip(&tried).filter_map(of_step);
            found.extend(tried.max_by(|one, other| one.promise.total_cmp(&other.promise)));
        }
        let all = self.at.left.norm_squared();
        found.retain(|one| one.promise > PROMISING * all);
        found.sort_by(|one, other| other.promise.total_cmp(&one.promise));
        found.truncate(ESTIMATED);
        Ok(found)
    }

    /// The share that a candidate explains, if its effect is in proportion to a step; nothing without an effect of its own, or for
    /// a time that no sensor is late by.
    fn explained(&self, parameter: &Parameter, first: f64, step: f64, run: &[f64]) -> Option<Candidate> {
        let own = self.at.own(run)?;
        let (size, product) = (own.norm_squared(), own.dot(&self.at.left));
        let inner = first - step * product / size;
        let [low, high] = parameter.inner_bounds();
        if parameter.unit == "s" && !(low..=high).contains(&inner) {
            return None;
        }
        let after = &self.at.left - own * (product / size);
        let (_, share) = self.most_explained(self.at.left.as_slice(), after.as_slice());
        Some(Candidate { parameter: parameter.clone(), inner, promise: product * product / size, share })
    }

    /// A setting that is estimated along with all that is.
    fn setting(&self, parameter: &Parameter) -> Result<Option<Cause>, Interrupted> {
        let simulated = self.changeable.changed(Change::Estimated(parameter))?;
        let problem = self.problem(&*simulated, Some(parameter));
        let end = self.refined(&problem, &self.inserted(parameter.inner(parameter.start)))?;
        let (value, interval) = self.estimate(&problem, &end.x)?;
        let text = of_setting(parameter, value, interval);
        let cause = self.judged(&problem, &end.x, &parameter.name, text, Some((value, interval)))?;
        Ok(cause.filter(|_| is_apart(parameter, interval)))
    }

    /// Another item of a choice.
    fn chosen(&self, Choice { name, fixed, .. }: &Choice, item: &str) -> Result<Option<Cause>, Interrupted> {
        let simulated = self.changeable.changed(Change::Chosen { name, item })?;
        let problem = self.problem(&*simulated, None);
        let end = self.refined(&problem, self.x)?;
        let text = match name.as_str() {
            PRESSURES => format!("{PRESSURES} counted {item}: give them in barg, kPag or psig"),
            _ => format!("{name} were {item} in place of {fixed}: is the setting right?"),
        };
        let cause = self.judged(&problem, &end.x, name, text, None)?;
        Ok(cause.map(|cause| Cause { item: Some(item.to_owned()), ..cause }))
    }

    /// The sensor that would explain most, if that is much. It is estimated along with all that is, weighed by the noise that is
    /// left then: a step in proportion tells which sensor it is, and not how large its fault.
    fn sensor(&self, candidates: &[Parameter]) -> Result<Option<Cause>, Interrupted> {
        let Some(candidate) = self.promising(candidates)?.into_iter().next().filter(|one| one.share > MUCH) else {
            return Ok(None);
        };
        let parameter = &candidate.parameter;
        let simulated = self.changeable.changed(Change::Estimated(parameter))?;
        let problem = self.problem(&*simulated, Some(parameter));
        let near = refine(&problem, &self.inserted(candidate.inner), Loss::Linear, ROUGH, &Unwatched)?.x;
        let differences = problem.simulated.differences(std::slice::from_ref(&near), TOLERANCE)?.swap_remove(0);
        let weighed = Problem { sensors: problem.likely_sensors(&differences), ..problem.clone() };
        let end = refine(&weighed, &near, Loss::Linear, FINE, &Unwatched)?.x;
        let (value, interval) = self.estimate(&weighed, &end)?;
        let text = of_sensor(parameter, value, interval);
        let cause = self.judged(&problem, &end, &parameter.name, text, Some((value, interval)))?;
        // What a fit in proportion promises, the fit itself has to keep.
        Ok(cause
            .filter(|cause| cause.share > MUCH && is_apart(parameter, interval))
            .map(|cause| Cause { is_sensor: true, ..cause }))
    }

    /// The clock that fits best, if another one promises much and is off by at least a share.
    fn clock(&self, least: f64) -> Result<Option<Cause>, Interrupted> {
        let (mut clock, mut half, mut x) = (1.0, f64::INFINITY, self.x.to_vec());
        let mut nearer = None;
        for round in 0..ROUNDS {
            if round > 0 {
                let simulated = self.changeable.changed(Change::Clock(clock))?;
                let problem = self.problem(&*simulated, None);
                x = refine(&problem, &x, Loss::Linear, ROUGH, &Unwatched)?.x;
                nearer = Tangent::of(&problem, &x)?;
                if nearer.is_none() {
                    return Ok(None);
                }
            }
            let at = nearer.as_ref().unwrap_or(&self.at);
            let ahead = self.changeable.changed(Change::Clock(clock * (1.0 + CLOCK)))?;
            let run = ahead.differences(std::slice::from_ref(&x), TOLERANCE)?.swap_remove(0);
            let Some(own) = at.own(&run) else { return Ok(None) };
            let (size, product, left) = (own.norm_squared(), own.dot(&at.left), at.left.norm_squared());
            let step = (-CLOCK * product / size).clamp(-MOST_CLOCK, MOST_CLOCK);
            if round == 0 && (product * product < PROMISING * size * left || step.abs() < least) {
                return Ok(None);
            }
            clock *= 1.0 + step;
            half = HALF * clock * CLOCK * (left / run.len() as f64 / size).sqrt();
        }
        let simulated = self.changeable.changed(Change::Clock(clock))?;
        let problem = self.problem(&*simulated, None);
        let x = refine(&problem, &x, Loss::Linear, ROUGH, &Unwatched)?.x;
        let interval = [clock - half, clock + half];
        let [value, low, high] = [clock, interval[0], interval[1]].map(short);
        let text =
            format!("{TIME} were {value} [{low}, {high}] times what was recorded: check the clock and the sample rate");
        self.judged(&problem, &x, TIME, text, Some((clock, interval)))
    }

    /// The better end of two searches: from where the wrong setting has led, and from the first start.
    fn refined(&self, problem: &Problem<'_>, x: &[f64]) -> Result<Solution, Interrupted> {
        let one = refine(problem, x, Loss::Linear, ROUGH, &Unwatched)?;
        let other = refine(problem, &problem.start(), Loss::Linear, ROUGH, &Unwatched)?;
        Ok(if other.cost < one.cost { other } else { one })
    }

    /// Value and interval of the parameter that a problem has more than the fitted one.
    fn estimate(&self, problem: &Problem<'_>, x: &[f64]) -> Result<(f64, [f64; 2]), Interrupted> {
        let place = self.fitted.parameters.len();
        Ok((problem.parameters[place].outer(x[place]), certainty(problem, x, Ends::Jacobian)?.intervals[place]))
    }

    /// A cause by what it leaves; nothing where a run fails.
    fn judged(
        &self,
        problem: &Problem<'_>,
        x: &[f64],
        name: &str,
        text: String,
        estimate: Option<(f64, [f64; 2])>,
    ) -> Result<Option<Cause>, Interrupted> {
        let differences = problem.simulated.differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0);
        let after = problem.residuals(&differences);
        if after.iter().any(|residual| residual.abs() == FAILED) {
            return Ok(None);
        }
        let squares = |residuals: &[f64]| residuals.iter().map(|residual| residual * residual).sum::<f64>();
        let (signal, share) = self.most_explained(&self.before, &after);
        let text = format!("{:.0} % of the squared residual of {signal} would be gone if {text}", 100.0 * share);
        let gain = squares(&self.before) - squares(&after);
        let (name, signal, alike) = (name.to_owned(), signal.to_owned(), vec![]);
        Ok(Some(Cause { name, text, estimate, item: None, signal, share, gain, alike, is_sensor: false }))
    }

    /// The signal of whose squares the largest share is gone, and this share.
    fn most_explained(&self, before: &[f64], after: &[f64]) -> (&str, f64) {
        let mut squares = vec![[0.0; 2]; self.signals.len()];
        let mut row = 0;
        for segment in &self.fitted.segments {
            for own in &mut squares {
                let rows = row..row + segment.samples;
                for (before, after) in before[rows.clone()].iter().zip(&after[rows]) {
                    own[0] += before * before;
                    own[1] += after * after;
                }
                row += segment.samples;
            }
        }
        let shares = squares.iter().map(|[before, after]| 1.0 - after / before.max(1e-300));
        let pairs = self.signals.iter().map(String::as_str).zip(shares);
        pairs.max_by(|(_, one), (_, other)| one.total_cmp(other)).expect("a signal is compared")
    }
}

fn of_setting(parameter: &Parameter, value: f64, [low, high]: [f64; 2]) -> String {
    let Parameter { name, unit, start, .. } = parameter;
    let is_gauge = unit == "Pa" && (value - start - ATMOSPHERE).abs() < NEAR * ATMOSPHERE;
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
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
    match kind {
        "gain" => format!("{signal} were {size} times its readings: estimate {name}"),
        "offset" => format!("{size} {unit} of {signal} were an offset of its sensor: estimate {name}"),
        "lag" => format!("{signal} were read {size} ms late, or through a filter: estimate {name} or delay.{signal}"),
        _ => format!("{signal} were read {size} ms late: estimate {name}"),
    }
}

fn short(value: f64) -> String {
    significant(value, 5)
}
