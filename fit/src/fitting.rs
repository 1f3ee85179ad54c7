//! A fit of an experiment: question and answer.

use std::collections::BTreeMap;
use std::sync::Arc;

use pneumatic_servo::variables;

use crate::arrays::{rms, span};
use crate::candidates::candidates;
use crate::causes::{Cause, DAMPING_SPEED, causes, is_quiet};
use crate::driver::{Reached, Search};
use crate::experiment::{Experiment, Given, Kind, MeasuredSegment, Options, of_kind, parameter};
use crate::intervals::{Ends, certainty};
use crate::machine_units::MachineUnits;
use crate::parameter::{Parameter, Values};
use crate::plausibility::{self, Facts, Source as Table};
use crate::problem::{Interrupted, TOLERANCE};
use crate::record::Signals;
use crate::refused::{NoAnswer, Refused};
use crate::runs::Runs;
use crate::search::{Loss, Watch};
use crate::sensor::Sensor;
use crate::simulation::{Task, Workers};
use crate::study::{Source, Study};

/// Samples for each parameter, at least.
const SAMPLES: usize = 5;
/// Points for each parameter, at least: each is a motion of its own.
const POINTS: usize = 2;

/// Data, experiment, and estimated parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Name of the data.
    pub file: String,
    /// Kind of the experiment.
    pub experiment: String,
    /// Number of the friction law.
    pub law: i32,
    /// Signals in SI units, with `time`.
    pub signals: Signals,
    /// Fixed parameters; of those that are estimated the starts.
    pub known: Values,
    /// Names of the estimated parameters.
    pub estimated: Vec<String>,
    /// Share of the record at its end that is validation data.
    pub validation: f64,
    /// Random starts beside that from the data.
    pub starts: usize,
    /// Options of the use of the data.
    pub options: Options,
    /// Units of the machine and of the readings.
    pub units: MachineUnits,
}

/// An estimated parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name and SI unit.
    pub parameter: (String, String),
    /// Its value.
    pub value: f64,
    /// Ends of its 95 % interval.
    pub interval: [f64; 2],
    /// Why the data do not determine it.
    pub undetermined: Option<&'static str>,
}

/// A segment with measured and simulated readings at its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Times in s of the table.
    pub time: Vec<f64>,
    /// Measured and simulated readings of the compared signals.
    pub readings: Vec<(&'static str, Vec<f64>, Vec<f64>)>,
}

/// The outcome of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Whether the search has come to its end.
    pub converged: bool,
    /// Why it has ended.
    pub message: String,
    /// Estimated parameters.
    pub estimates: Vec<Estimate>,
    /// RMS residual of each compared signal, in SI units.
    pub rms: BTreeMap<&'static str, f64>,
    /// RMS residual of its validation data.
    pub validation_rms: BTreeMap<&'static str, f64>,
    /// Noise of each compared signal, estimated from its data, with the quantisation noise of its converter.
    pub noise: BTreeMap<&'static str, f64>,
    /// The fixed setting, the clock or the sensor that would explain most of the residual, if it explains much.
    pub cause: Option<Cause>,
    /// Notes on the data.
    pub notes: Vec<String>,
    /// Time in s at which the validation data begin.
    pub validation_from: Option<f64>,
    /// Fitted start values of the first segment.
    pub start: Values,
    /// Measured and simulated curves.
    pub courses: Vec<Course>,
    /// Units of the machine and of the readings.
    pub units: MachineUnits,
}

/// Runs one after the other; `told` hears the share of each that is done.
struct Alone<'a> {
    told: &'a dyn Fn(f64),
}

impl Alone<'_> {
    fn goes_on(&self, share: f64) -> bool {
        (self.told)(share);
        true
    }
}

impl Workers for Alone<'_> {
    fn each(&self, count: usize, work: &Task<'_>) -> Result<(), Interrupted> {
        (0..count).for_each(|place| work(place, &|share| self.goes_on(share)));
        Ok(())
    }
}

/// Fits. `told` hears of each run, with the share of it that is done.
///
/// # Errors
/// [`NoAnswer`].
pub fn fit(question: &Question, watch: &dyn Watch, told: &dyn Fn(f64)) -> Result<Answer, NoAnswer> {
    let Question { file, estimated, .. } = question;
    let is_fixed = |name: &String| !estimated.contains(name);
    let known =
        question.known.iter().filter(|(name, _)| is_fixed(name)).map(|(name, value)| (name.clone(), *value)).collect();
    let kind = Kind::of_name(&question.experiment)?;
    let units = question.units.clone();
    let signals = question.signals.keys().cloned();
    let given = Given { units, ..Given::new(kind, question.law, known, signals, question.options) };
    let experiment: Arc<dyn Experiment> = of_kind(given)?.into();
    check_plausible(&*experiment, question)?;
    let (records, mut notes) = kind.records(file, question.signals.clone())?;
    let parameters = parameters(&*experiment, question)?;
    let source = |record| Source { record, name: file.clone(), number: 0, validation: question.validation };
    let sources: Vec<Source> = records.into_iter().map(source).collect();
    notes.extend(assumed(&*experiment, &question.known, &parameters));
    let study = Study::cut(experiment, &sources, parameters, vec![]);
    check_size(&study, &sources)?;
    let workers = Alone { told };
    let (starts, loss) = (question.starts, Loss::Linear);
    let search = Search { workers: &workers, sources: &sources, starts, seed: 0, loss, solver: None };
    let mut reached = None;
    search.run(study, watch, &mut reached)?;
    let Some(Reached { study, fitted, best: Some(best), other_form, hidden }) = reached else {
        unreachable!("the search has ended")
    };
    notes.extend(study.notes.iter().cloned());
    watch.stage("intervals");
    let sure = fitted.with(&workers, |problem| certainty(problem, &best.x, Ends::Jacobian))?;
    let ends = fitted.parameters.iter().map(|one| &one.name).zip(&sure.reasons);
    let lost = ends.filter(|(name, reason)| reason.is_some() && hidden.contains(name));
    let lost: Vec<&str> = lost.map(|(name, _)| name.as_str()).collect();
    if !lost.is_empty() {
        notes.push(format!(
            "not identifiable at the start values: {}; what is found may be anything; where a value is known, fix it",
            lost.join(", ")
        ));
    }
    let begun = study.begun(&fitted, &best.x);
    let whole = begun.runs();
    let point = whole.point(&best.x[..whole.parameters.len()]);
    let read = |place| whole.readings(place, &point, TOLERANCE, &|share| workers.goes_on(share));
    let readings: Vec<_> = (0..begun.segments.len()).map(read).collect();
    let residuals = |is_validation| residuals(&whole, &readings, is_validation);
    let rms = residuals(false);
    let sensors = begun.sensors.iter().map(Sensor::whole_noise);
    let noise: BTreeMap<_, _> = begun.experiment.compared().iter().copied().zip(sensors).collect();
    let beside = rms.iter().map(|(signal, rms)| (*rms, noise[signal]));
    watch.stage("causes of the residuals");
    let simulation = fitted.simulation(&workers);
    let candidates = candidates(&simulation.runs);
    let causes = causes(&simulation, &candidates, &fitted.problem(&simulation), &best.x, is_quiet(beside))?;
    let is_simulated = rms.values().all(|rms| rms.is_finite());
    let estimate = |(place, one): (usize, &Parameter)| Estimate {
        parameter: (one.name.clone(), one.unit.clone()),
        value: one.outer(best.x[place]),
        interval: sure.intervals[place],
        undetermined: sure.reasons[place],
    };
    let first = |segment: &MeasuredSegment| {
        let row = segment.is_validation.iter().position(|is| *is)?;
        Some(segment.record.begin + segment.record.time[row])
    };
    Ok(Answer {
        converged: best.converged && is_simulated,
        message: if is_simulated { best.message } else { "the fitted values cannot be simulated".to_owned() },
        estimates: whole.parameters.iter().enumerate().map(estimate).collect(),
        validation_rms: residuals(true),
        rms,
        noise,
        cause: other_form.or_else(|| causes.into_iter().next()),
        notes,
        validation_from: whole.segments.iter().filter_map(first).reduce(f64::min),
        start: whole.segments.first().map(|segment| segment.begin.values.clone()).unwrap_or_default(),
        courses: courses(&whole, readings),
        units: question.units.clone(),
    })
}

/// Estimated parameters by their names.
fn parameters(experiment: &dyn Experiment, question: &Question) -> Result<Vec<Parameter>, Refused> {
    let names = &question.estimated;
    if names.is_empty() {
        return Err(Refused("no parameter is estimated: choose at least one".to_owned()));
    }
    let is_told = |name: &str| question.known.contains_key(name) || names.iter().any(|own| own == name);
    if let Some(missing) = experiment.unknown().into_iter().find(|name| !is_told(name)) {
        return Err(Refused(format!("{missing} has no default; it must be estimated, or given a value")));
    }
    let of_name = |name: &String| match question.known.get(name) {
        Some(start) => {
            let given = parameter(experiment, name)?.given(Some(*start), None);
            given.map_err(|Refused(why)| Refused(format!("{name}: {why}")))
        }
        None => parameter(experiment, name),
    };
    names.iter().map(of_name).collect()
}

/// A note on what a machine has of its own, and nobody has given: its defaults decide about the values.
fn assumed(experiment: &dyn Experiment, known: &Values, parameters: &[Parameter]) -> Option<String> {
    let given = experiment.given();
    let is_told = |name: &str| {
        known.contains_key(name) || given.signals.contains(name) || parameters.iter().any(|one| one.name == name)
    };
    let shown = |name: &&str| {
        let variable = given.table.table().find(name).expect("a variable of the model").variable;
        let variables::Kind::Real(unit) = variable.kind else { unreachable!("{name} is a real number") };
        format!("{name} = {} {}", variable.start.unwrap_or(f64::NAN), unit.name)
    };
    // The default of this one is another form of the law than the first publication's.
    let law: &[&str] = if given.law_name() == "LuGre" && !experiment.is_steady() { &[DAMPING_SPEED] } else { &[] };
    let names = given.kind.machine.iter().chain(law);
    let defaults: Vec<String> = names.filter(|name| !is_told(name)).map(shown).collect();
    (!defaults.is_empty()).then(|| format!("not given, so that the default counts: {}", defaults.join(", ")))
}

/// Refuses signals that cannot be meant.
fn check_plausible(experiment: &dyn Experiment, question: &Question) -> Result<(), Refused> {
    let Question { file, signals, .. } = question;
    let place = |signal: &str, row: usize| format!("{file}, sample {row} of {signal}");
    let facts = Facts { given: experiment.given(), columns: &BTreeMap::new(), units: &question.units.of_signals() };
    let found = plausibility::check(&facts, &Table { name: file, signals, place: &place });
    found.into_iter().find(|finding| finding.is_refused).map_or(Ok(()), |finding| Err(Refused(finding.text)))
}

fn check_size(study: &Study, sources: &[Source]) -> Result<(), Refused> {
    let Study { experiment, segments, parameters, .. } = study;
    if let (true, Some(Source { record, .. })) = (segments.is_empty(), sources.first()) {
        let (step, length) = (record.step, experiment.length(record.step).unwrap_or(f64::INFINITY));
        return Err(Refused(format!(
            "segment = {length} s is refused: no part has 10 samples, which are {step} s apart"
        )));
    }
    let rests = |segment: &MeasuredSegment| experiment.resting(&segment.record).iter().all(|rests| *rests);
    if experiment.compared().contains(&"position") && segments.iter().all(rests) {
        return Err(Refused("all at rest: the position never leaves its noise".to_owned()));
    }
    let samples: usize = segments.iter().map(|segment| segment.fitted().count()).sum();
    if samples == 0 {
        return Err(Refused("all at rest: no sample moves beyond the noise of the position".to_owned()));
    }
    for signal in experiment.compared() {
        if segments.iter().all(|segment| span(segment.record.of(signal)) == 0.0) {
            let value = segments[0].record.of(signal)[0];
            return Err(Refused(format!(
                "{signal} = {value} {} all the time; is it the right column?",
                experiment.given().units.of_signal(signal)
            )));
        }
    }
    let (size, count) = (samples * experiment.compared().len(), parameters.len());
    let least = if experiment.is_steady() { POINTS } else { SAMPLES };
    if size < least * count {
        return Err(Refused(format!("too short: {size} samples to compare for {count} estimated parameters")));
    }
    Ok(())
}

/// RMS residual of each signal at the fitted samples or at the validation samples; not finite where a run failed.
fn residuals(runs: &Runs<'_>, readings: &[Vec<Vec<f64>>], is_validation: bool) -> BTreeMap<&'static str, f64> {
    let of_signal = |(place, signal): (usize, &&'static str)| {
        let mut differences = Vec::new();
        for (segment, readings) in runs.segments.iter().zip(readings) {
            let rows = (0..segment.used.len())
                .filter(|row| segment.used[*row] && segment.is_validation[*row] == is_validation);
            let measured = segment.record.of(signal);
            differences.extend(rows.map(|row| measured[row] - readings[place][row]));
        }
        (!differences.is_empty()).then(|| (*signal, rms(&differences)))
    };
    runs.experiment.compared().iter().enumerate().filter_map(of_signal).collect()
}

/// Curves of all segments.
fn courses(runs: &Runs<'_>, readings: Vec<Vec<Vec<f64>>>) -> Vec<Course> {
    let of_segment = |(segment, readings): (&MeasuredSegment, Vec<Vec<f64>>)| {
        let record = &segment.record;
        let pair = |(signal, simulated): (&&'static str, Vec<f64>)| (*signal, record.of(signal).to_vec(), simulated);
        Course {
            time: record.time.iter().map(|time| time + record.begin).collect(),
            readings: runs.experiment.compared().iter().zip(readings).map(pair).collect(),
        }
    };
    runs.segments.iter().zip(readings).map(of_segment).collect()
}
