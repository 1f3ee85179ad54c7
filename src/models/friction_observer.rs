//! An observer of the cylinder as a model: estimates of its states and of the friction force, with their deviations, from voltage
//! and measurements.
//!
//! It is [`Observer`] at a period of its own. A sample takes the measurements of its communication point in, after a step of the
//! plant under the inputs of the sample before: so it goes on from sample to sample as the plant beside it does. What it finds is
//! shown until the next sample.

use std::any::TypeId;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::pneumatic_servo_cylinder as cylinder;
use super::pneumatic_servo_cylinder::PneumaticServoCylinder;
use crate::co_simulation::{Direction, Simulation, Snapshot, SnapshotError};
use crate::model::{
    Course, Experiment, Functions, Method, Model, Observed, Observer, ObserverError, Panel, SavedObserver, Setup,
    Signal, Start,
};
use crate::numbers::{Real, Scalar};
use crate::solver::StepError;
use crate::system::{Sample, System, Tables, Tuning, references};
use crate::variables::{
    Choice, Meaning, ParameterError, Place, Role, SettingError, Table, Value, Variable, find, table_cache, units,
};

/// The model. It is none of [`ALL`](super::ALL): its library is compiled with derivatives, and apart.
pub const MODEL: Model = Model {
    name: "FrictionObserver",
    description: "Observer of a pneumatic servo cylinder: states and friction force with their deviations, from voltage and measurements",
    functions: Functions {
        table: || table_cache::lent(TypeId::of::<FrictionObserver>(), make_table),
        shared_table: table,
        // Covariance and derivatives of as many quantities as there are, twice.
        snapshot_size: cylinder::MODEL.functions.snapshot_size + 8 * (2 * MOST * MOST + 8 * MOST) + 256,
        indicators: Vec::new,
        start: |start| Ok(Box::new(FrictionObserver::new(start)?)),
        vary: |_| Err(ParameterError::new("slopes", 0.0, "an observer has no derivatives along its run")),
    },
    experiment: Experiment {
        stop_time: 2.0,
        step_size: 1e-3,
        signals: &[
            Signal {
                input: "valveVoltage",
                text: "5 V + 0.8 V sin(2π t/s)",
                course: Course::Sine { mean: 5.0, amplitude: 0.8, frequency: 1.0, delay: 0.0 },
            },
            Signal {
                input: "measured.position",
                text: "250 mm + 20 mm sin(2π (t/s - 0.25))",
                course: Course::Sine { mean: 0.25, amplitude: 0.02, frequency: 1.0, delay: 0.25 },
            },
        ],
        panels: &[
            Panel { label: "position", curves: &["measured.position", "position"] },
            Panel { label: "velocity", curves: &["velocity"] },
            Panel { label: "pressure", curves: &["chamberB.pressure", "chamberA.pressure"] },
            Panel { label: "friction force", curves: &["frictionForce"] },
        ],
    },
};

/// The most samples within a communication step.
const MOST_SAMPLES: u64 = 1_000_000;

/// The most quantities that are estimated.
const MOST: usize = cylinder::MOST_STATES + 1;

/// Variables of the cylinder that may be measured, with the default deviation of the noise of each; 0: it is not measured.
const MEASURED: [(&str, f64, f64); 4] = [
    ("position", 0.25, 20e-6),
    ("velocity", 0.0, 0.0),
    ("chamberA.pressure", 101_325.0, 0.0),
    ("chamberB.pressure", 101_325.0, 0.0),
];

/// Computed variables of the cylinder that are shown.
const SHOWN: [&str; 8] = [
    "position",
    "velocity",
    "chamberA.pressure",
    "chamberB.pressure",
    "chamberA.temperature",
    "chamberB.temperature",
    "frictionForce",
    "rodForce",
];

/// States whose disturbance can be chosen.
const DISTURBED: [&str; 4] = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"];

/// The input that can be estimated.
const FORCE: &str = "externalForce";

/// Value references: those of the cylinder's inputs and parameters are its own.
const OWN: u32 = 8_000;

/// The table of the model.
fn table() -> Arc<Table> {
    table_cache::shared(TypeId::of::<FrictionObserver>(), make_table)
}

fn make_table() -> Table {
    let Tables { inputs, computed, parameters } = <PneumaticServoCylinder as System<3>>::tables();
    let of = |list: &[Variable], name: &str| {
        list.iter().find(|variable| variable.name == name).expect("a variable of the cylinder").clone()
    };
    let force = of(&inputs, FORCE);
    // The same quantity under another name and in another role.
    let like = |variable: Variable, reference: u32, name: String, role: Role, text: String| Variable {
        name,
        reference,
        role,
        description: text,
        start: None,
        min: None,
        max: None,
        plausible: None,
        derivative_of: None,
        depends_on: matches!(role, Role::Output | Role::Local).then(Vec::new),
        starts_from: Vec::new(),
        counts_where: Vec::new(),
        ..variable
    };
    let shown = |name: &str, reference: u32, group: &str, text: &str| {
        like(of(&computed, name), reference, format!("{group}{name}"), Role::Output, format!("{text} {name}"))
    };
    let mut all = vec![Variable::time()];
    all.extend(inputs);
    for (place, (name, start, _)) in (1..).zip(MEASURED) {
        let text = format!("Measured {name} at the sample");
        let input = like(of(&computed, name), OWN + place, format!("measured.{name}"), Role::Input, text);
        all.push(Variable { start: Some(start), ..input });
    }
    all.push(
        Variable::switch(OWN + 20, "measured.valid", true)
            .text("False at a sample without measurements: the estimates go on without them"),
    );
    all.extend((101..).zip(SHOWN).map(|(place, name)| shown(name, OWN + place, "", "Estimate of")));
    all.extend(
        (121..)
            .zip(SHOWN)
            .map(|(place, name)| shown(name, OWN + place, "deviation.", "Standard deviation of the estimate of")),
    );
    let [estimate, deviation] =
        ["Estimate of externalForce; the input where it is not estimated", "Standard deviation of this estimate"];
    all.push(like(force.clone(), OWN + 141, format!("estimated.{FORCE}"), Role::Output, estimate.to_owned()));
    all.push(like(force.clone(), OWN + 142, format!("deviation.{FORCE}"), Role::Output, deviation.to_owned()));
    for (place, (name, ..)) in (151..).zip(MEASURED) {
        let text = format!("Measured {name} minus its prediction at the last sample; 0 where it was not measured");
        all.push(like(of(&computed, name), OWN + place, format!("innovation.{name}"), Role::Output, text));
    }
    all.push(
        Variable::output(OWN + 161, "normalisedSquare", units::ONE).nominal(1.0).depends_on(&[]).text(
            "Square of the innovations of the last sample in units of their deviations; its mean is the number of measured variables",
        ),
    );
    all.push(Variable::counter(OWN + 162, "samples").depends_on(&[]).text("Samples since initialization"));
    // What the plant is made of is known when the observer starts.
    all.extend(parameters.into_iter().map(|variable| Variable { role: Role::Fixed, ..variable }));
    all.push(
        Variable::parameter(OWN + 201, "observer.period", units::SECOND, 1e-3)
            .range(1e-6, 10.0)
            .text("Period of the samples"),
    );
    all.push(
        Variable::choice(OWN + 202, "observer.method", Method::Extended)
            .text("Kalman filter; under friction.law = Bristle the bands of the extended one are too narrow"),
    );
    for (place, (name, _, noise)) in (211..).zip(MEASURED) {
        let text = format!("Standard deviation of the noise of measured.{name}; 0: it is not measured");
        let own = like(of(&computed, name), OWN + place, format!("noise.{name}"), Role::Fixed, text);
        all.push(Variable { start: Some(noise), min: Some(0.0), ..own });
    }
    for (place, name) in (221..).zip(DISTURBED) {
        let text = format!(
            "Standard deviation of the random walk that disturbs {name}, after 1 s; 0: the default of the observer"
        );
        let own = like(of(&computed, name), OWN + place, format!("process.{name}"), Role::Fixed, text);
        all.push(Variable { start: Some(0.0), min: Some(0.0), ..own });
    }
    let text = format!("Standard deviation after 1 s of {FORCE} as a random walk that is estimated; 0: it is known");
    let own = like(force, OWN + 231, format!("process.{FORCE}"), Role::Fixed, text);
    all.push(Variable { start: Some(0.0), min: Some(0.0), ..own });
    let solving = Tuning::grouped(references::SOLVER).into_iter();
    all.extend(solving.map(|it| Variable { role: Role::Fixed, ..it.meaning(Meaning::Solving) }));
    Table::new(all)
}

/// An observer between two samples.
struct FrictionObserver {
    observer: Observer,
    /// Number of the plant's inputs, which are the first ones.
    plant_inputs: usize,
    /// Inputs that are measured, by their places, in the order of the observer.
    measured: Vec<usize>,
    /// Places of the flag of valid measurements among the inputs, and of the force among the plant's.
    valid: usize,
    force: usize,
    /// Places in the plant's table of what is shown.
    shown: [Place; SHOWN.len()],
    period: f64,
    time: f64,
    /// The inputs and their slopes from a time on.
    since: f64,
    inputs: Vec<f64>,
    slopes: Vec<f64>,
    /// The inputs now, those of the plant at the last sample, and the measurements.
    now: Vec<f64>,
    held: Vec<f64>,
    taken: Vec<Option<f64>>,
    begin: f64,
    count: u64,
}

/// What is saved.
#[derive(Serialize, Deserialize)]
struct Saved {
    begin: f64,
    count: u64,
    held: Vec<f64>,
    observer: SavedObserver,
}

fn refused(error: SettingError) -> ParameterError {
    match error {
        SettingError::Refused(error) => error,
        other => ParameterError::new("observer", 0.0, &other.to_string()),
    }
}

impl FrictionObserver {
    fn new(start: &Start) -> Result<Self, ParameterError> {
        let (table, plant) = (table(), cylinder::MODEL.table());
        let value = |name: &str| match table.find(name).map(|entry| entry.place) {
            Some(Place::Parameter(place)) => start.parameters[place],
            _ => unreachable!("a parameter of the table"),
        };
        let mut setup = Setup::new(&cylinder::MODEL);
        if let Some(tolerance) = start.tolerance {
            setup = setup.tolerance(tolerance);
        }
        let parameters = table.parameters().zip(start.parameters);
        for (variable, value) in parameters.chain(table.inputs().zip(start.inputs)) {
            if plant.find(&variable.name).is_some() {
                setup.change(&variable.name, Value::from(*value)).map_err(refused)?;
            }
        }
        let noise = MEASURED.map(|(name, ..)| (name, value(&format!("noise.{name}"))));
        let measured: Vec<_> = noise.into_iter().filter(|(_, noise)| *noise > 0.0).collect();
        if measured.is_empty() {
            return Err(ParameterError::new(
                "noise.position",
                0.0,
                "at least one variable must be measured, with a noise above 0",
            ));
        }
        let disturbed = DISTURBED.iter().chain([&FORCE]).map(|name| (*name, value(&format!("process.{name}"))));
        let process: Vec<_> = disturbed.filter(|(_, deviation)| *deviation > 0.0).collect();
        let period = value("observer.period");
        let method = Method::from_id(value("observer.method")).ok_or_else(|| {
            ParameterError::new("observer.method", value("observer.method"), "there is no such method")
        })?;
        let observed = Observed { measured: &measured, period, process: &process, initial: &[], method };
        let observer = Observer::new(&setup, observed).map_err(|error| match error {
            ObserverError::Setting(error) => refused(error),
            ObserverError::Parameter(error) => error,
        })?;
        let input = |name: &str| match table.find(name).map(|entry| entry.place) {
            Some(Place::Input(place)) => place,
            _ => unreachable!("an input of the table"),
        };
        let of_plant = |name: &str| find(plant, name).expect("a variable of the cylinder").place;
        let plant_inputs = plant.inputs().count();
        Ok(Self {
            plant_inputs,
            measured: measured.iter().map(|(name, _)| input(&format!("measured.{name}"))).collect(),
            taken: vec![None; measured.len()],
            valid: input("measured.valid"),
            force: input(FORCE),
            shown: SHOWN.map(of_plant),
            observer,
            period,
            time: start.time,
            since: start.time,
            inputs: start.inputs.to_vec(),
            slopes: vec![0.0; start.inputs.len()],
            now: start.inputs.to_vec(),
            held: start.inputs[..plant_inputs].to_vec(),
            begin: start.time,
            count: 0,
        })
    }

    fn next_sample(&self) -> Sample<Real> {
        Sample::periodic(Real::of(self.begin + self.count as f64 * self.period), self.period)
    }

    /// Takes the sample that is due; the first finds the start, of which nothing is to be told yet.
    fn sample(&mut self) -> Result<(), StepError> {
        self.time = self.time.max(self.next_sample().time.value);
        let passed = self.time - self.since;
        let moved = self.inputs.iter().zip(&self.slopes).map(|(value, slope)| value + slope * passed);
        self.now.iter_mut().zip(moved).for_each(|(slot, value)| *slot = value);
        if self.count > 0 {
            let is_valid = self.now[self.valid] != 0.0;
            for (slot, place) in self.taken.iter_mut().zip(&self.measured) {
                *slot = is_valid.then_some(self.now[*place]);
            }
            self.observer.update(&self.held, &self.taken)?;
        }
        self.held.copy_from_slice(&self.now[..self.plant_inputs]);
        self.count += 1;
        Ok(())
    }
}

impl Simulation for FrictionObserver {
    fn time(&self) -> f64 {
        self.time
    }

    fn set_inputs(&mut self, values: &[f64], slopes: &[f64]) {
        self.since = self.time;
        self.inputs.copy_from_slice(values);
        self.slopes.copy_from_slice(slopes);
    }

    /// No parameter is tunable.
    fn retune(&mut self, _parameters: &[f64]) -> Result<(), ParameterError> {
        Ok(())
    }

    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        let mut samples = 0;
        while self.next_sample().is_before(end) {
            if samples == MOST_SAMPLES {
                return Err(StepError::TooManySamples { time: self.time, limit: MOST_SAMPLES });
            }
            self.sample()?;
            samples += 1;
        }
        self.time = end;
        Ok(())
    }

    fn is_finite(&self) -> bool {
        self.shown
            .iter()
            .all(|place| self.observer.value(*place).is_finite() && self.observer.deviation(*place).is_finite())
    }

    fn values(&self, computed: &mut [f64]) {
        let observer = &self.observer;
        let force = Place::Input(self.force);
        let estimates = self.shown.iter().map(|place| observer.value(*place));
        let deviations = self.shown.iter().map(|place| observer.deviation(*place));
        let of_force = [observer.value(force), observer.deviation(force)];
        let number = |own: f64| if own.is_nan() { 0.0 } else { own };
        let first = self.plant_inputs;
        let innovation = |input: usize| {
            let found = self.measured.iter().position(|place| *place == input);
            found.map_or(0.0, |own| number(observer.innovation()[own]))
        };
        let innovations = (first..first + MEASURED.len()).map(innovation);
        let square = observer.whitened().iter().map(|own| number(*own) * number(*own)).sum();
        // FMI integers have 32 bits; a run that exceeds them shows the largest.
        let samples = f64::from(i32::try_from(self.count).unwrap_or(i32::MAX));
        let all = estimates.chain(deviations).chain(of_force).chain(innovations).chain([square, samples]);
        computed.iter_mut().zip(all).for_each(|(slot, value)| *slot = value);
    }

    /// Between samples nothing moves.
    fn rates(&self, computed: &mut [f64]) {
        computed.fill(0.0);
    }

    /// Between samples nothing reacts.
    fn directional_derivative(&self, _direction: Direction, computed: &mut [f64]) {
        computed.fill(0.0);
    }

    fn save(&self) -> Snapshot {
        let saved =
            Saved { begin: self.begin, count: self.count, held: self.held.clone(), observer: self.observer.save() };
        let memory = postcard::to_allocvec(&saved).expect("plain data");
        Snapshot { time: self.time, states: Vec::new(), memory }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let saved: Saved = postcard::from_bytes(&snapshot.memory).map_err(|_| SnapshotError::Unreadable)?;
        if !snapshot.states.is_empty() {
            return Err(SnapshotError::States { found: snapshot.states.len(), expected: 0 });
        }
        if saved.held.len() != self.held.len() {
            return Err(SnapshotError::Lengths);
        }
        let numbers = saved.held.iter().chain([&snapshot.time, &saved.begin]);
        if !numbers.copied().all(f64::is_finite) {
            return Err(SnapshotError::NotFinite);
        }
        self.observer.restore(&saved.observer)?;
        self.held.copy_from_slice(&saved.held);
        (self.time, self.since, self.begin, self.count) = (snapshot.time, snapshot.time, saved.begin, saved.count);
        Ok(())
    }
}
