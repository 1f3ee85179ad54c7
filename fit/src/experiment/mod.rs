//! Experiments: which model is run with which signals, and which signals are compared.

mod balance;
mod cylinder;
mod force;
mod measured;
mod mechanical;
mod motion;
mod options;
mod pneumatic;
mod points;
mod pushed;
mod rig;
mod seal;
mod segments;

use std::collections::BTreeSet;
use std::sync::Arc;

use pneumatic_servo::model::Model;
use pneumatic_servo::models;
use pneumatic_servo::variables::{self, Role};

pub use balance::Balance;
pub use cylinder::{PRESSURES, rod_force};
pub use options::{Inputs, OPTIONS, Offered, Options, Range};
pub use segments::{OfRecord, segments};

use crate::arrays::interpolate;
use crate::expression::Tie;
use crate::law;
use crate::machine_units::MachineUnits;
use crate::parameter::{Parameter, Values};
use crate::record::{self, Record, Signals, unit_of};
use crate::refused::Refused;
use crate::smoothing::low_pass;

/// Parameters of the cylinder that make the load factor of a bench.
pub const OF_LOAD: [&str; 2] = ["friction.kappaA", "friction.direction.factor"];

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
    /// Time in s of the record at which the segment begins.
    pub begin: f64,
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

/// Velocity, friction and load factor as far as the data alone tell them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// Velocities in m/s.
    pub speed: Vec<f64>,
    /// Friction forces in N.
    pub force: Vec<f64>,
    /// Load factors.
    pub level: Vec<f64>,
}

/// An experiment.
pub trait Experiment: Send + Sync {
    /// Its settings.
    fn given(&self) -> &Given;

    /// Signals that are compared.
    fn compared(&self) -> &[&'static str];

    /// Measured signals that drive the model.
    fn driving(&self) -> Vec<&'static str>;

    /// Whether each sample is a steady motion of its own, without time, and no sample of a course.
    fn is_steady(&self) -> bool {
        false
    }

    /// Properties of a test bench that its model does not have, and that may be estimated.
    fn of_bench(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Parameters that the model has no default of.
    fn unknown(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Whether a parameter of the machine acts on the compared signals and has no part in what is simulated.
    fn lacks(&self, _name: &str) -> bool {
        false
    }

    /// Variables of the model that are recorded.
    fn outputs(&self) -> Vec<&'static str> {
        self.compared().to_vec()
    }

    /// Length in s of the segments of a record with a sample interval in s; nothing if a record is not cut.
    fn length(&self, _step: f64) -> Option<f64> {
        self.given().options.length
    }

    /// Samples at which a measured position does not change by more than its noise.
    fn resting(&self, record: &Record) -> Vec<bool> {
        match record.signals.contains_key("position") {
            true => measured::resting(record, self.given().options.width),
            false => vec![false; record.time.len()],
        }
    }

    /// Signals made ready at the communication points, samples that are compared, and notes.
    fn prepare(&self, record: &Record) -> (Signals, Vec<bool>, Vec<String>);

    /// Start of the simulation of a record.
    fn begin(&self, record: &Record, driven: &Signals) -> Begin;

    /// Whether the inputs run on straight lines from each communication point to the next; otherwise they are held.
    fn has_lines(&self) -> bool {
        false
    }

    /// Inputs at the communication points.
    fn inputs(&self, segment: &MeasuredSegment, values: &Values) -> Vec<(&'static str, Vec<f64>)>;

    /// Settings of a run without its start values.
    fn settings(&self, segment: &MeasuredSegment, values: &Values) -> Values;

    /// Compared signals at the communication points, of the recorded variables.
    fn predict(&self, _segment: &MeasuredSegment, outputs: Vec<Vec<f64>>, _values: &Values) -> Vec<Vec<f64>> {
        outputs
    }

    /// Velocity, friction and load factor, for a start of the fit.
    fn forces(&self, segment: &MeasuredSegment, values: &Values) -> Option<Forces>;

    /// Starts of parameters of the machine that the data tell; `values` has the estimated ones.
    fn guess(&self, _segments: &[MeasuredSegment], _values: &Values) -> Values {
        Values::new()
    }
}

/// Facts of a kind of experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// What is given and what is compared, in a sentence.
    pub about: &'static str,
    /// Signals that have to be measured.
    pub required: &'static [&'static str],
    /// Signals of which one of each pair has to be measured.
    pub either: &'static [[&'static str; 2]],
    /// Signals that are taken as well where they are measured.
    pub further: &'static [&'static str],
    /// Parameters that each machine has of its own.
    pub machine: &'static [&'static str],
    /// Model whose parameters are known or estimated.
    pub table: &'static str,
    /// Model that is simulated.
    pub simulated: &'static str,
}

const BENCH: &str = "FrictionBench";
const CYLINDER: &str = "PneumaticServoCylinder";
const PNEUMATIC: &str = "pneumatic";

/// All kinds of experiments.
pub const KINDS: [Kind; 6] = [
    Kind {
        name: "motion",
        about: "The motion of a seal or a tribometer is given; its force is compared.",
        required: &["time"],
        either: &[["position", "velocity"], ["frictionForce", "force"]],
        further: &seal::LOADS,
        machine: &[],
        table: BENCH,
        simulated: BENCH,
    },
    Kind {
        name: "points",
        about: "Velocity and load of each row are given, without time; the force of steady sliding is compared.",
        required: &["velocity"],
        either: &[["frictionForce", "force"]],
        further: &seal::LOADS,
        machine: &[],
        table: BENCH,
        simulated: BENCH,
    },
    Kind {
        name: "force",
        about: "A force is given that moves a mass; position, velocity or both are compared.",
        required: &["time", "force"],
        either: &[["position", "velocity"]],
        further: &["normalForce"],
        machine: &["mass"],
        table: BENCH,
        simulated: BENCH,
    },
    Kind {
        name: "mechanical",
        about: "The pressures of a cylinder are given; the position of its carriage is compared.",
        required: &["time", "position", "chamberA.pressure", "chamberB.pressure"],
        either: &[],
        further: &["velocity", "externalForce"],
        machine: &["cylinder.bore", "cylinder.rod", "mass.moving"],
        table: CYLINDER,
        simulated: BENCH,
    },
    Kind {
        name: PNEUMATIC,
        about: "Position and valve voltage are given; the pressures are compared.",
        required: &["time", "position", "valveVoltage", "chamberA.pressure", "chamberB.pressure"],
        either: &[],
        further: &["supplyPressure"],
        machine: &["supplyPressure", "cylinder.bore", "cylinder.rod", "cylinder.stroke", "valve.C"],
        table: CYLINDER,
        simulated: CYLINDER,
    },
    Kind {
        name: "rig",
        about: "The valve voltage is given; position, velocity and pressures are compared.",
        required: &["time", "valveVoltage", "position"],
        either: &[],
        further: &["velocity", "chamberA.pressure", "chamberB.pressure", "supplyPressure", "externalForce"],
        machine: &["supplyPressure", "cylinder.bore", "cylinder.rod", "cylinder.stroke", "mass.moving", "valve.C"],
        table: CYLINDER,
        simulated: CYLINDER,
    },
];

impl Kind {
    /// The kind of a name.
    ///
    /// # Errors
    /// [`Refused`] for a name that there is not.
    pub fn of_name(name: &str) -> Result<&'static Self, Refused> {
        let names = || KINDS.map(|kind| kind.name).join(", ");
        let missing = || Refused(format!("experiment = {name} is refused: it must be one of {}", names()));
        KINDS.iter().find(|kind| kind.name == name).ok_or_else(missing)
    }

    /// Whether its tables are courses over time; otherwise each row is a point.
    pub fn has_time(&self) -> bool {
        self.required.contains(&"time")
    }

    /// All signals that are taken, each once.
    pub fn signals(&self) -> impl Iterator<Item = &'static str> {
        let either = self.either.iter().flatten();
        self.required.iter().chain(either).chain(self.further).copied()
    }

    /// [`OPTIONS`] that act in this kind of experiment.
    pub fn options(&self) -> impl Iterator<Item = &'static Offered> {
        let has_load = self.signals().any(|signal| signal == "normalForce");
        let is_pushed = ["force", "mechanical"].contains(&self.name);
        let acts = move |option: &&Offered| match option.name {
            "width" | "segment" => self.has_time(),
            "smoothing" => is_pushed,
            "rated" => has_load,
            "play" => self.name == "motion",
            // Pressures that move a mass run on a smooth curve, and a motion is prescribed.
            _ => ["force", "rig", PNEUMATIC].contains(&self.name),
        };
        OPTIONS.iter().filter(acts)
    }

    /// Whether its machine may rotate: then its force is a torque, its mass an inertia, and its position an angle.
    pub fn may_rotate(&self) -> bool {
        self.name == "force"
    }

    /// Parameters that a fit usually estimates: of the law, in `points` only the ones on which friction in steady motion depends; in
    /// `pneumatic`, where friction has no part, the conductance of the valve.
    pub fn usual(&self, model: &Model, law: i32, known: &Values) -> Vec<String> {
        if self.name == PNEUMATIC {
            return vec!["valve.C".to_owned()];
        }
        let mut names = law::usual(model, law, known);
        names.retain(|name| self.has_time() || law::acts_on_steady_motion(model, name));
        names
    }

    /// Records of signals, with notes: courses without gaps, or the points of a table as one record.
    ///
    /// # Errors
    /// [`Refused`], as [`record::split`] and [`record::points`].
    pub fn split(&self, name: &str, signals: Signals) -> Result<(Vec<Record>, Vec<String>), Refused> {
        if self.has_time() { record::split(name, signals) } else { Ok((vec![record::points(name, signals)?], vec![])) }
    }

    /// The same of signals that are all there is: they must move.
    ///
    /// # Errors
    /// [`Refused`], as [`split`](Self::split) and [`record::check_motion`].
    pub fn records(&self, name: &str, signals: Signals) -> Result<(Vec<Record>, Vec<String>), Refused> {
        let (records, notes) = self.split(name, signals)?;
        record::check_motion(&records)?;
        Ok((records, notes))
    }

    /// Refuses too few signals, and a time where there is none.
    fn check(&self, signals: &BTreeSet<String>) -> Result<(), Refused> {
        let name = self.name;
        if !self.has_time() && signals.contains("time") {
            let courses = KINDS.iter().find(|kind| kind.has_time()).expect("an experiment over time").name;
            return Err(Refused(format!(
                "experiment {name} takes points without a time, but there is a column for time; leave it out, or fit \
                 the course over time as experiment {courses}"
            )));
        }
        let missing: Vec<&str> = self.required.iter().copied().filter(|signal| !signals.contains(*signal)).collect();
        if !missing.is_empty() {
            let required = self.required.join(", ");
            let missing = missing.join(", ");
            return Err(Refused(format!("experiment {name} needs columns for {required}; {missing} is missing")));
        }
        match self.either.iter().find(|pair| !pair.iter().any(|signal| signals.contains(*signal))) {
            Some([one, other]) => Err(Refused(format!("experiment {name} needs a column for {one} or {other}"))),
            None => Ok(()),
        }
    }
}

/// An experiment of a kind.
///
/// # Errors
/// [`Refused`] for too few signals, and for a known parameter that acts and that the experiment or its machine does without.
pub fn of_kind(given: Given) -> Result<Box<dyn Experiment>, Refused> {
    given.kind.check(&given.signals)?;
    let experiment: Box<dyn Experiment> = match given.kind.name {
        "motion" => Box::new(motion::Motion::new(given)),
        "points" => Box::new(points::Points::new(given)?),
        "force" => Box::new(force::Force::new(given)?),
        "mechanical" => Box::new(mechanical::Mechanical::new(given)),
        PNEUMATIC => Box::new(pneumatic::Pneumatic::new(given)),
        _ => Box::new(rig::Rig::new(given)),
    };
    let given = experiment.given();
    let acts = |(name, value): &(&String, &f64)| {
        let usual = given.table.table().find(name).and_then(|entry| entry.variable.start);
        experiment.lacks(name) && usual != Some(**value)
    };
    match given.known.iter().find(acts) {
        Some((name, value)) => Err(given.lacking(&format!("{name} = {value}"))),
        None => Ok(experiment),
    }
}

/// Names of the properties of all sensors. What is true is `gain.SIGNAL * (reading - offset.SIGNAL)`, and a reading comes
/// `delay.SIGNAL` late; one that is compared may have gone through a filter of first order with the time constant `lag.SIGNAL`.
pub fn sensors(experiment: &dyn Experiment) -> Vec<String> {
    let compared = experiment.compared().to_vec();
    let both = [compared.clone(), experiment.driving()].concat();
    let of = |kinds: &[&str], signals: &[&str]| -> Vec<String> {
        signals.iter().flat_map(|signal| kinds.iter().map(move |kind| format!("{kind}.{signal}"))).collect()
    };
    // Without a time no reading is late.
    let mut names = match experiment.is_steady() {
        true => of(&["gain", "offset"], &both),
        false => [of(&["gain", "offset", "delay"], &both), of(&["lag"], &compared)].concat(),
    };
    // The zero of a position that prescribes a motion has no effect.
    names.retain(|name| experiment.given().kind.name != "motion" || name != "offset.position");
    names
}

/// A property of a sensor, of a bench or of the model, by its name, as an estimated parameter in the units of the machine.
///
/// # Errors
/// [`Refused`] for a name that has no part in the experiment.
pub fn parameter(experiment: &dyn Experiment, name: &str) -> Result<Parameter, Refused> {
    let found = of_sliding(experiment, name)?;
    let unit = experiment.given().units.of_parameter(&found.name, &found.unit);
    Ok(Parameter { unit, ..found })
}

/// The same in the units of a machine that slides.
fn of_sliding(experiment: &dyn Experiment, name: &str) -> Result<Parameter, Refused> {
    if let Some((kind, signal)) = name.split_once('.')
        && let Some(found) = Parameter::of_sensor(kind, signal, unit_of(signal))
    {
        let names = sensors(experiment);
        if !names.iter().any(|own| own == name) {
            let of_kind = |own: &'_ String| own.strip_prefix(kind)?.strip_prefix('.').map(str::to_owned);
            let there: Vec<String> = names.iter().filter_map(of_kind).collect();
            let place = if kind == "lag" { "compared" } else { "compared or driving" };
            return Err(Refused(format!("{signal} is not {place} here, only {}", there.join(", "))));
        }
        return Ok(found);
    }
    let given = experiment.given();
    if experiment.of_bench().contains(&name) {
        return Ok(Parameter::of_bench(name).expect("a property of a bench"));
    }
    if name == "area" {
        return Err(Refused(
            "area needs the columns force and pressure, in the experiments motion and points".to_owned(),
        ));
    }
    if experiment.lacks(name) {
        return Err(given.lacking(name));
    }
    // The cylinder has them, too; the bench gets the load factor that they make.
    let is_of_load = OF_LOAD.contains(&name) && given.table.table().find(name).is_none();
    let table = if is_of_load { given.cylinder.table() } else { given.table.table() };
    let Some(entry) = table.find(name) else {
        return Err(Refused(format!("there is no parameter {name} of {}", given.table.name)));
    };
    Parameter::of_variable(entry.variable)
        .ok_or_else(|| Refused(format!("{name} is no real parameter, so that it cannot be fitted")))
}

/// A model of the library.
pub(crate) fn model(name: &str) -> &'static Model {
    models::ALL.iter().find(|model| model.name == name).expect("a model of the library")
}

/// Kind, models, law, known values and signals of an experiment.
#[derive(Clone)]
pub struct Given {
    /// Kind of the experiment.
    pub kind: &'static Kind,
    /// Model whose parameters are known or estimated.
    pub table: &'static Model,
    /// Model that is simulated.
    pub model: &'static Model,
    /// The cylinder, which has parameters of the load factor.
    pub cylinder: &'static Model,
    /// Number of the friction law.
    pub law: i32,
    /// Values that are fixed.
    pub known: Values,
    /// Signals that are measured.
    pub signals: BTreeSet<String>,
    /// Options of the use of the data.
    pub options: Options,
    /// Units of the machine and of the readings.
    pub units: MachineUnits,
}

impl Given {
    /// The settings of an experiment with models of the library.
    pub fn new(
        kind: &'static Kind,
        law: i32,
        known: Values,
        signals: impl IntoIterator<Item = String>,
        options: Options,
    ) -> Self {
        let signals = signals.into_iter().collect();
        let [table, model, cylinder] = [kind.table, kind.simulated, CYLINDER].map(model);
        let units = MachineUnits::default();
        Self { kind, table, model, cylinder, law, known, signals, options, units }
    }

    fn lacking(&self, what: &str) -> Refused {
        let own = self.kind.name;
        Refused(format!(
            "{what} is refused: experiment {own} does without it; rig and pneumatic run the whole cylinder"
        ))
    }

    /// Name of the friction law.
    pub fn law_name(&self) -> &'static str {
        let (_, laws) = self.table.table().friction_law().expect("a model with a law");
        laws.items.iter().find(|(id, ..)| *id == self.law).map_or("", |(_, name, _)| *name)
    }

    /// Prefix of the parameters of the law, with its dot; empty for a law without parameters.
    pub fn law_group(&self) -> String {
        law::group(self.table, self.law)
    }

    /// A parameter: estimated, known, or by default.
    pub fn value(&self, name: &str, values: &Values) -> f64 {
        let default = || self.table.table().find(name).and_then(|entry| entry.variable.start).unwrap_or(0.0);
        values.get(name).or_else(|| self.known.get(name)).copied().unwrap_or_else(default)
    }

    /// Adds the values of parameters that follow from others, each from those before it.
    pub fn follow(&self, ties: &[Tie], values: &mut Values) {
        for tie in ties {
            let value = tie.expression.value(&|name| self.value(name, values));
            values.insert(tie.name.clone(), value);
        }
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
        let places = segment.record.grid.iter().map(|time| segment.whole.begin + time + delay);
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

    /// Factor of a slope of the measured motion, as far as the gain of its sensor is known.
    pub fn pace(&self) -> f64 {
        let is_measured = self.signals.contains("velocity");
        self.beside(if is_measured { "gain.velocity" } else { "gain.position" }, &Values::new(), 1.0)
    }

    /// Settings of a run under the law, with more values.
    pub fn run(&self, values: &Values, more: &[(&str, f64)]) -> Values {
        let mut settings = self.of_model(values);
        settings.insert("friction.law".to_owned(), f64::from(self.law));
        settings.extend(more.iter().map(|(name, value)| ((*name).to_owned(), *value)));
        settings
    }

    /// Number of an item of an enumeration of the simulated model.
    fn item(&self, name: &str, item: &str) -> f64 {
        let variable = self.model.table().find(name).expect("a variable of the model").variable;
        let variables::Kind::Enumeration(items) = variable.kind else { unreachable!("{name} is enumerated") };
        items.items.iter().find(|(_, own, _)| *own == item).map_or(f64::NAN, |(id, ..)| f64::from(*id))
    }

    /// Whether a signal is measured.
    pub fn has(&self, signal: &str) -> bool {
        self.signals.contains(signal)
    }

    /// Start values of readings as true values, as far as gains and offsets of sensors are known.
    pub fn corrected(&self, mut begin: Begin) -> Begin {
        let none = Values::new();
        for (name, value) in &mut begin.values {
            if name == "velocity0" && !self.has("velocity") {
                *value *= self.pace();
            } else {
                *value = self.truth(name.trim_end_matches('0'), vec![*value], &none)[0];
            }
        }
        begin
    }
}
