//! Experiments: which model is run with which signals, and which signals are compared.

mod motion;
mod rig;

use std::collections::BTreeSet;
use std::sync::Arc;

use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{Role, Variable};

pub use motion::Motion;
pub use rig::Rig;

use crate::arrays::interpolate;
use crate::parameter::{Parameter, Values};
use crate::record::{Record, Signals, unit_of};
use crate::refused::Refused;
use crate::smoothing::low_pass;

/// Parameters of the cylinder that make the load level of a bench.
const OF_LOAD: [&str; 2] = ["friction.kappaA", "friction.direction.factor"];

/// Options of the use of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Normal force in N at which the load level is 1.
    pub rated: f64,
    /// Width in s of the parabolas that give velocities.
    pub width: f64,
    /// Play in m that hides the jitter of a position at rest; by default three times its noise.
    pub play: Option<f64>,
}

/// Start values of a simulation, as they were measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Begin {
    /// Settings of the model.
    pub values: Values,
    /// Names of those that are estimated along, since their sensors err.
    pub estimated: Vec<String>,
}

/// Signals of the whole record of a segment, made ready: a sensor that lags reads after the end of a segment what was true in it.
#[derive(Debug, PartialEq)]
pub struct Whole {
    /// Communication points in s.
    pub grid: Vec<f64>,
    /// Signals at these.
    pub driven: Signals,
}

/// A segment of a record that is simulated in one go.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSegment {
    /// Measured signals.
    pub record: Record,
    /// The same made ready, at the communication points.
    pub driven: Signals,
    /// Samples that are compared at all.
    pub used: Vec<bool>,
    /// Samples that are validation data: predicted, not fitted.
    pub is_validation: Vec<bool>,
    /// Start of the simulation.
    pub begin: Begin,
    /// Number of the record.
    pub number: usize,
    /// The record.
    pub whole: Arc<Whole>,
}

impl MeasuredSegment {
    /// Whether a sample is fitted.
    pub fn is_fitted(&self, row: usize) -> bool {
        self.used[row] && !self.is_validation[row]
    }

    /// Rows of the samples that are fitted.
    pub fn fitted(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.used.len()).filter(|row| self.is_fitted(*row))
    }

    /// The segment up to its last sample that is fitted; nothing if there is none.
    pub fn trained(&self) -> Option<Self> {
        let last = self.fitted().last()? + 1;
        let record = self.record.part(0, last);
        let points = record.grid.len();
        let cut = |(name, values): (&String, &Vec<f64>)| (name.clone(), values[..points.min(values.len())].to_vec());
        Some(Self {
            driven: self.driven.iter().map(cut).collect(),
            record,
            used: self.used[..last].to_vec(),
            is_validation: self.is_validation[..last].to_vec(),
            ..self.clone()
        })
    }
}

/// Velocity, friction and load level as far as the data alone tell them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// Velocities in m/s.
    pub speed: Vec<f64>,
    /// Friction forces in N.
    pub force: Vec<f64>,
    /// Load levels.
    pub level: Vec<f64>,
}

/// An experiment.
pub trait Experiment {
    /// Its settings.
    fn given(&self) -> &Given;

    /// Signals that are compared.
    fn compared(&self) -> &[&'static str];

    /// Measured signals that drive the model.
    fn driving(&self) -> Vec<&'static str>;

    /// Parameters that the model has no default of.
    fn unknown(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Parameters that each machine has of its own.
    fn machine(&self) -> &'static [&'static str] {
        &[]
    }

    /// Variables of the model that are recorded.
    fn outputs(&self) -> Vec<&'static str>;

    /// Signals made ready at the communication points, samples that are compared, and notes.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>);

    /// Start of the simulation of a record.
    fn begin(&self, record: &Record, driven: &Signals) -> Begin;

    /// Inputs at the communication points.
    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)>;

    /// Settings of a run, besides its start.
    fn settings(&self, values: &Values) -> Values;

    /// Compared signals at the communication points, of the recorded variables.
    fn predict(&self, segment: &MeasuredSegment, outputs: Vec<Vec<f64>>, values: &Values) -> Vec<Vec<f64>>;

    /// Velocity, friction and load level, for a start of the fit.
    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces>;
}

/// The experiment of a name, `motion` or `rig`, for signals.
///
/// # Errors
/// [`Refused`] for another name, or too few signals.
pub fn of_name(
    name: &str,
    law: i32,
    known: Values,
    signals: &Signals,
    options: Options,
) -> Result<Box<dyn Experiment>, Refused> {
    let signals: BTreeSet<String> = signals.keys().cloned().collect();
    let needs = |required: &[&str]| match required.iter().find(|signal| !signals.contains(**signal)) {
        Some(missing) => {
            Err(Refused(format!("experiment {name} needs columns for {}; {missing} is missing", required.join(", "))))
        }
        None => Ok(()),
    };
    let given = |model| Given { model, law, known: known.clone(), signals: signals.clone(), options };
    match name {
        "rig" => {
            needs(&["time", "valveVoltage", "position"])?;
            Ok(Box::new(Rig::new(given(model("PneumaticServoCylinder")))))
        }
        "motion" => {
            needs(&["time"])?;
            for (one, other) in [("position", "velocity"), ("frictionForce", "force")] {
                if !signals.contains(one) && !signals.contains(other) {
                    return Err(Refused(format!("experiment {name} needs a column for {one} or {other}")));
                }
            }
            Ok(Box::new(Motion::new(given(model("FrictionBench")))))
        }
        _ => Err(Refused(format!("experiment = {name} is refused: it must be motion or rig"))),
    }
}

/// A property of a sensor, of a bench or of the model, by its name, as an estimated parameter.
///
/// # Errors
/// [`Refused`] for a name that has no part in the experiment.
pub fn parameter(experiment: &dyn Experiment, name: &str) -> Result<Parameter, Refused> {
    if let Some((kind, signal)) = name.split_once('.')
        && let Some(found) = Parameter::of_sensor(kind, signal, unit_of(signal))
    {
        let (mut there, place) = match kind {
            "lag" => (vec![], "compared"),
            _ => (experiment.driving(), "compared or driving"),
        };
        there.splice(0..0, experiment.compared().iter().copied());
        if !there.contains(&signal) {
            return Err(Refused(format!("{name}: {signal} is not {place} here, only {}", there.join(", "))));
        }
        return Ok(found);
    }
    let bench = experiment.given().model;
    if name == "area" && bench.name == "FrictionBench" {
        return Ok(Parameter::area());
    }
    // The cylinder has them, too; the bench gets the load level that they make.
    let is_of_load = OF_LOAD.contains(&name) && bench.table().find(name).is_none();
    let table = if is_of_load { model("PneumaticServoCylinder").table() } else { bench.table() };
    let Some(entry) = table.find(name) else {
        return Err(Refused(format!("there is no parameter {name} of {}", bench.name)));
    };
    Parameter::of_variable(entry.variable)
        .ok_or_else(|| Refused(format!("{name} is no real parameter, so that it cannot be estimated")))
}

/// A model of the library.
pub(crate) fn model(name: &str) -> &'static Model {
    models::ALL.iter().find(|model| model.name == name).expect("a model of the library")
}

/// Model, law, known values and signals of an experiment.
#[derive(Clone)]
pub struct Given {
    /// Model that is simulated.
    pub model: &'static Model,
    /// Number of the friction law.
    pub law: i32,
    /// Values that are fixed.
    pub known: Values,
    /// Signals that are measured.
    pub signals: BTreeSet<String>,
    /// Options of the use of the data.
    pub options: Options,
}

impl Given {
    /// Name of the friction law.
    pub fn law_name(&self) -> &'static str {
        let (_, laws) = self.model.table().friction_law().expect("a model with a law");
        laws.items.iter().find(|(id, ..)| *id == self.law).map_or("", |(_, name, _)| *name)
    }

    /// Prefix of the parameters of the law, with its dot; empty for a law without parameters.
    pub fn law_group(&self) -> String {
        let table = self.model.table();
        let of_law = |variable: &&Variable| {
            variable.counts_for.is_some_and(|case| {
                case.item == self.law && table.case(case).is_some_and(|(choice, _)| choice.name == "friction.law")
            })
        };
        let first = table.parameters().find(of_law).and_then(|variable| variable.name.rsplit_once('.'));
        first.map_or(String::new(), |(group, _)| format!("{group}."))
    }

    /// A parameter: estimated, known, or by default.
    pub fn value(&self, name: &str, values: &Values) -> f64 {
        let default = || self.model.table().find(name).and_then(|entry| entry.variable.start).unwrap_or(0.0);
        values.get(name).or_else(|| self.known.get(name)).copied().unwrap_or_else(default)
    }

    /// A property that is no parameter of the model: estimated, known, or as usual.
    pub fn beside(&self, name: &str, values: &Values, usual: f64) -> f64 {
        values.get(name).or_else(|| self.known.get(name)).copied().unwrap_or(usual)
    }

    /// A reading without the gain and the offset of its sensor.
    pub fn truth(&self, signal: &str, reading: Vec<f64>, values: &Values) -> Vec<f64> {
        let gain = self.beside(&format!("gain.{signal}"), values, 1.0);
        let offset = self.beside(&format!("offset.{signal}"), values, 0.0);
        if gain == 1.0 && offset == 0.0 {
            return reading;
        }
        reading.into_iter().map(|value| gain * (value - offset)).collect()
    }

    /// True course of a measured signal at the communication points.
    pub fn measured(&self, segment: &MeasuredSegment, signal: &str, values: &Values) -> Vec<f64> {
        self.truth(signal, self.reading(segment, signal, signal, values), values)
    }

    /// A signal made ready under a name, as it is read after the delay of its sensor.
    pub fn reading(&self, segment: &MeasuredSegment, name: &str, signal: &str, values: &Values) -> Vec<f64> {
        let delay = self.beside(&format!("delay.{signal}"), values, 0.0);
        if delay == 0.0 {
            return segment.driven[name].clone();
        }
        // A segment has the first sample of its record.
        let places = segment.record.grid.iter().map(|time| time + delay);
        interpolate(places, &segment.whole.grid, &segment.whole.driven[name])
    }

    /// Reading at the samples of a record, of a true course at its communication points: through the filter, the delay, the
    /// gain and the offset of its sensor. True time is the record's, times a clock.
    pub fn read(&self, record: &Record, clock: f64, signal: &str, truth: &[f64], values: &Values) -> Vec<f64> {
        let of = |kind: &str, usual| self.beside(&format!("{kind}.{signal}"), values, usual);
        let (lag, delay, gain, offset) = (of("lag", 0.0), of("delay", 0.0), of("gain", 1.0), of("offset", 0.0));
        let passed = if lag == 0.0 { truth.to_vec() } else { low_pass(truth, clock * record.step, lag) };
        let seen = interpolate(record.time.iter().map(|time| time - delay / clock), &record.grid, &passed);
        seen.into_iter().map(|value| value / gain + offset).collect()
    }

    /// Known and estimated values that the model has as parameters, or as inputs that nobody measures.
    pub fn of_model(&self, values: &Values) -> Values {
        let has = |name: &str| {
            self.model.table().find(name).is_some_and(|entry| match entry.variable.role {
                Role::Fixed | Role::Tunable => true,
                Role::Input => !self.signals.contains(name),
                Role::Time | Role::Output | Role::Local => false,
            })
        };
        let both = self.known.iter().chain(values).filter(|(name, _)| has(name));
        both.map(|(name, value)| (name.clone(), *value)).collect()
    }

    /// Start values of readings as true values, as far as gains and offsets of sensors are known.
    pub fn corrected(&self, mut begin: Begin) -> Begin {
        let none = Values::new();
        for (name, value) in &mut begin.values {
            if name == "velocity0" && !self.signals.contains("velocity") {
                *value *= self.beside("gain.position", &none, 1.0);
            } else {
                *value = self.truth(name.trim_end_matches('0'), vec![*value], &none)[0];
            }
        }
        begin
    }
}
