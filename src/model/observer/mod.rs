//! An observer: a Kalman filter on the transitions of a plant.
//!
//! ```text
//! x- = f(x, u),  P- = A*P*A' + Q*T        K = P-*h'/(h*P-*h' + r),  x+ = x- + K*(y - h(x-))
//! ```
//!
//! `f` is a step of the plant with all its events. In the extended filter `A` and `h` are its derivatives, in the unscented one
//! the regression of steps from points around the estimate ([`Method`]). Measurements are taken in one by one, with the covariance in
//! Joseph's form, in units of nominal values.

mod extended;
mod unscented;

use std::fmt;

use serde::{Deserialize, Serialize};

use self::extended::Extended;
use self::unscented::Unscented;
use super::Setup;
use crate::enumeration;
use crate::sensitivity::Along;
use crate::session::{Snapshot, SnapshotError};
use crate::solver::StepError;
use crate::variables::{Kind, ParameterError, Place, SettingError, Variable, find};

/// Share of its start above which the estimate of a pressure or temperature stays.
const VACUUM: f64 = 0.01;

enumeration! {
    /// How an [`Observer`] carries its covariance over a step of the plant; ids are never reused.
    Method "ObserverMethod": "Kalman filter of an observer" {
        1 Extended: "Extended Kalman filter: along the derivative of a step, which is exact through stick and slip";
        2 Unscented: "Unscented Kalman filter: by steps from points around the estimate, for laws whose step has no useful derivative";
    }
}

/// Properties of an [`Observer`]; all deviations are standard deviations in SI units.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a> {
    /// Measured variables, and the deviations of their noise.
    pub measured: &'a [(&'a str, f64)],
    /// Period of the measurements in s.
    pub period: f64,
    /// States, and the deviations of the random walk that disturbs each, after 1 s. An input, too: it is estimated as a random walk
    /// then, as an unknown force is.
    pub process: &'a [(&'a str, f64)],
    /// States and inputs of these, and their deviations at the start.
    pub initial: &'a [(&'a str, f64)],
    /// How the covariance is carried over a step.
    pub method: Method,
}

/// Why there is no such observer.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ObserverError {
    /// A name is wrong.
    Setting(SettingError),
    /// A parameter of the plant is wrong, or a deviation is.
    Parameter(ParameterError),
}

impl fmt::Display for ObserverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setting(error) => error.fmt(f),
            Self::Parameter(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ObserverError {}

impl From<SettingError> for ObserverError {
    fn from(error: SettingError) -> Self {
        Self::Setting(error)
    }
}

impl From<ParameterError> for ObserverError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

/// What an observer saves of itself.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SavedObserver {
    plant: Snapshot,
    numbers: [Vec<f64>; 7],
}

/// An estimated quantity.
#[derive(Clone, Debug)]
struct Estimated {
    along: Along,
    name: &'static str,
    /// Unit of the filter.
    nominal: f64,
    /// Variance of the disturbance after 1 s, in this unit.
    process: f64,
    /// Least value, in SI units.
    least: f64,
}

/// What is estimated, and how well it is known.
struct Belief {
    estimated: Vec<Estimated>,
    /// Values of all continuous states of the table, in SI units.
    states: Vec<f64>,
    /// The inputs of the last step, estimates included.
    inputs: Vec<f64>,
    /// Slopes of the inputs over a step, which are held: 0 each.
    still: Vec<f64>,
    /// Offsets of the inputs that are estimated, by their places.
    offsets: Vec<f64>,
    /// Covariance in nominal units, by its rows.
    covariance: Vec<f64>,
}

/// The computed variables at an estimate.
struct Outputs {
    values: Vec<f64>,
    /// Their derivatives by what is estimated, row by row, in units of its nominal values.
    slopes: Vec<f64>,
    /// Variances that these leave unexplained, in SI units.
    residuals: Vec<f64>,
}

/// The way of an estimate over a step of the plant.
trait Propagation: Send {
    /// Goes a step of a size in s on: states and covariance, but for disturbances, are those at its end.
    fn step(&mut self, belief: &mut Belief, size: f64) -> Result<(), StepError>;

    /// Moves the plant to the present estimate, with its present modes.
    fn move_to(&mut self, belief: &Belief);

    /// Reads the computed variables where the plant has been moved to.
    fn outputs(&mut self, belief: &Belief, outputs: &mut Outputs);

    /// The plant, and numbers that are carried from step to step beside it.
    fn save(&self) -> (Snapshot, &[f64]);

    /// Goes back to what was saved; nothing is changed where it does not fit.
    fn restore(&mut self, plant: &Snapshot, carried: &[f64]) -> Result<(), SnapshotError>;
}

/// A measured variable.
#[derive(Clone, Copy, Debug)]
struct Measured {
    /// Place among the computed variables.
    place: usize,
    variance: f64,
}

/// An observer of the states of a plant, from inputs and measurements.
pub struct Observer {
    setup: Setup,
    propagation: Box<dyn Propagation>,
    belief: Belief,
    outputs: Outputs,
    measured: Vec<Measured>,
    /// Whether all measured variables are continuous states.
    measures_states: bool,
    period: f64,
    /// Places of all continuous states of the table among the computed variables.
    places: Vec<usize>,
    gain: Vec<f64>,
    innovation: Vec<f64>,
    whitened: Vec<f64>,
}

impl fmt::Debug for Observer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.names().collect();
        f.debug_struct("Observer").field("estimated", &names).field("period", &self.period).finish_non_exhaustive()
    }
}

impl Observer {
    /// An observer of a plant that starts as it is set up.
    ///
    /// # Errors
    /// [`ObserverError`] for a name or a deviation that is wrong.
    pub fn new(setup: &Setup, observed: Observed) -> Result<Self, ObserverError> {
        let table = setup.table();
        let plant = setup.start(0.0)?;
        check_deviations(observed)?;
        let integrated: Vec<&Variable> = plant.states().collect();
        let mut estimated = Vec::new();
        let of = |list: &[(&str, f64)], name: &str| list.iter().find(|(own, _)| *own == name).map(|(_, it)| *it);
        for variable in integrated.iter().copied() {
            let entry = find(table, &variable.name)?;
            let nominal = entry.variable.nominal.filter(|nominal| *nominal != 0.0).unwrap_or(1.0);
            let start = plant.get(&variable.name)?;
            let is_absolute = matches!(unit(variable), "Pa" | "K") && start > 0.0;
            estimated.push(Estimated {
                along: Along::State(entry.state.expect("a continuous state")),
                name: &entry.variable.name,
                nominal,
                process: of(observed.process, &variable.name)
                    .map_or_else(|| default_process(variable), |own| own / nominal),
                least: if is_absolute { VACUUM * start } else { f64::NEG_INFINITY },
            });
        }
        let mut deviations: Vec<f64> = Vec::new();
        for own in &estimated {
            let start = table.find(own.name).map_or(0.0, |entry| default_start(entry.variable));
            let measured = of(observed.measured, own.name).map(|own_noise| own_noise / own.nominal);
            let given = of(observed.initial, own.name).map(|given| given / own.nominal);
            deviations.push(given.or(measured).unwrap_or(start));
        }
        for (name, deviation) in observed.process {
            let entry = find(table, name)?;
            match entry.place {
                Place::Input(place) if matches!(entry.variable.kind, Kind::Real(_)) => {
                    let nominal = entry.variable.nominal.filter(|nominal| *nominal != 0.0).unwrap_or(1.0);
                    estimated.push(Estimated {
                        along: Along::Input(place),
                        name: &entry.variable.name,
                        nominal,
                        process: deviation / nominal,
                        least: f64::NEG_INFINITY,
                    });
                    deviations.push(of(observed.initial, name).unwrap_or(*deviation) / nominal);
                }
                _ if integrated.iter().any(|state| state.name == *name) => {}
                _ => return Err(refused(name, "it is neither a continuous state of this run nor a real input")),
            }
        }
        for (name, _) in observed.initial {
            if !estimated.iter().any(|own| own.name == *name) {
                return Err(refused(name, "it is not estimated: it is no continuous state of this run"));
            }
        }
        let mut measured = Vec::new();
        for (name, deviation) in observed.measured {
            let entry = find(table, name)?;
            let Place::Computed(place) = entry.place else { return Err(refused(name, "it is not computed")) };
            if !matches!(entry.variable.kind, Kind::Real(_)) {
                return Err(refused(name, "it is no real number"));
            }
            measured.push(Measured { place, variance: deviation * deviation });
        }
        let (n, m, computed) = (estimated.len(), measured.len(), table.computed().count());
        let mut covariance = vec![0.0; n * n];
        for (place, deviation) in deviations.iter().enumerate() {
            covariance[place * n + place] = deviation * deviation;
        }
        for own in &mut estimated {
            own.process *= own.process;
        }
        let references: Vec<u32> = table.states().collect();
        let place_of = |reference: &u32| match table.by_reference(*reference).map(|entry| entry.place) {
            Some(Place::Computed(place)) => place,
            _ => unreachable!("a continuous state is computed"),
        };
        let places: Vec<usize> = references.iter().map(place_of).collect();
        let extended = Extended::new(setup, n)?;
        let held = extended.held();
        if let Some((name, _)) = observed.measured.iter().find(|(name, _)| held.iter().any(|own| own == name)) {
            let reason = "it is held between samples: give the variable itself, and the error of its sensor as noise";
            return Err(refused(name, reason));
        }
        let mut observer = Self {
            setup: setup.clone(),
            propagation: Box::new(extended),
            belief: Belief {
                estimated,
                states: places.iter().map(|place| plant.value(Place::Computed(*place))).collect(),
                inputs: setup.inputs().to_vec(),
                still: vec![0.0; setup.inputs().len()],
                offsets: vec![0.0; setup.inputs().len()],
                covariance,
            },
            outputs: Outputs {
                values: vec![0.0; computed],
                slopes: vec![0.0; computed * n],
                residuals: vec![0.0; computed],
            },
            measures_states: measured.iter().all(|own| places.contains(&own.place)),
            measured,
            period: observed.period,
            places,
            gain: vec![0.0; n],
            innovation: vec![f64::NAN; m],
            whitened: vec![f64::NAN; m],
        };
        observer.look();
        if let Some(place) =
            observer.measured.iter().position(|measured| observer.row(measured.place).iter().any(|it| it.is_nan()))
        {
            let reason = "it has no derivative by what is estimated where the run starts";
            return Err(refused(observed.measured[place].0, reason));
        }
        if observed.method == Method::Unscented {
            observer.propagation = Box::new(Unscented::new(setup, n)?);
            observer.look();
        }
        Ok(observer)
    }

    /// Goes a period on under inputs in the order of the table, and takes measurements at its end in; those that are missing are
    /// left out.
    ///
    /// # Errors
    /// [`StepError`] when the plant cannot be followed.
    ///
    /// # Panics
    /// If the numbers of inputs or measurements are others.
    pub fn update(&mut self, inputs: &[f64], measured: &[Option<f64>]) -> Result<(), StepError> {
        assert_eq!((inputs.len(), measured.len()), (self.belief.inputs.len(), self.measured.len()));
        self.predict(inputs)?;
        self.innovation.fill(f64::NAN);
        self.whitened.fill(f64::NAN);
        for (place, value) in measured.iter().enumerate() {
            if let Some(value) = value {
                self.correct(place, *value);
            }
        }
        self.belief.constrain();
        self.look();
        Ok(())
    }

    /// Goes a period on.
    fn predict(&mut self, inputs: &[f64]) -> Result<(), StepError> {
        let belief = &mut self.belief;
        for ((slot, own), offset) in belief.inputs.iter_mut().zip(inputs).zip(&belief.offsets) {
            *slot = own + offset;
        }
        self.propagation.step(belief, self.period)?;
        let n = belief.estimated.len();
        for (place, own) in belief.estimated.iter().enumerate() {
            belief.covariance[place * n + place] += own.process * self.period;
        }
        if self.measures_states {
            self.values_from_states();
        } else {
            self.look();
        }
        Ok(())
    }

    /// Takes a measurement in.
    fn correct(&mut self, number: usize, value: f64) {
        let Self { belief, outputs, .. } = self;
        let (n, Measured { place, variance }) = (belief.estimated.len(), self.measured[number]);
        let variance = variance + outputs.residuals[place];
        let predicted = outputs.values[place];
        let row: &[f64] = &outputs.slopes[place * n..(place + 1) * n];
        // P*h'.
        for (slot, of) in self.gain.iter_mut().zip(belief.covariance.chunks(n)) {
            *slot = of.iter().zip(row).map(|(entry, slope)| entry * slope).sum();
        }
        let own: f64 = self.gain.iter().zip(row).map(|(entry, slope)| entry * slope).sum();
        let total = own + variance;
        let innovation = value - predicted;
        self.innovation[number] = innovation;
        self.whitened[number] = innovation / total.sqrt();
        for (place, own) in belief.estimated.iter().enumerate() {
            let change = self.gain[place] / total * innovation * own.nominal;
            match own.along {
                Along::State(state) => belief.states[state] += change,
                Along::Input(input) => {
                    belief.offsets[input] += change;
                    belief.inputs[input] += change;
                }
                _ => {}
            }
        }
        // The predictions of the other measurements follow.
        for later in number + 1..self.measured.len() {
            let place = self.measured[later].place;
            let row = &outputs.slopes[place * n..(place + 1) * n];
            let change: f64 = row.iter().zip(&self.gain).map(|(slope, gain)| slope * gain).sum();
            outputs.values[place] += change / total * innovation;
        }
        // Joseph's form (I - K*h)*P*(I - K*h)' + K*r*K', with the products that K*h has in common.
        for row in 0..n {
            let gain = self.gain[row] / total;
            let left = self.gain[row] - gain * own;
            for column in 0..=row {
                let other = self.gain[column] / total;
                let once = belief.covariance[row * n + column] - gain * self.gain[column];
                let entry = once - left * other + gain * variance * other;
                belief.covariance[row * n + column] = entry;
                belief.covariance[column * n + row] = entry;
            }
        }
    }

    /// Everything that changes from step to step.
    pub(crate) fn save(&self) -> SavedObserver {
        let Self { belief: Belief { states, inputs, offsets, covariance, .. }, innovation, whitened, .. } = self;
        let (plant, carried) = self.propagation.save();
        let numbers = [states, inputs, offsets, covariance, carried, innovation, whitened].map(<[f64]>::to_vec);
        SavedObserver { plant, numbers }
    }

    /// Goes back to what was saved of the same observer.
    ///
    /// # Errors
    /// [`SnapshotError`] when it does not fit.
    pub(crate) fn restore(&mut self, saved: &SavedObserver) -> Result<(), SnapshotError> {
        let Self { belief: Belief { states, inputs, offsets, covariance, .. }, innovation, whitened, .. } = self;
        let [.., carried, _, _] = &saved.numbers;
        let own = [(0, states), (1, inputs), (2, offsets), (3, covariance), (5, innovation), (6, whitened)];
        if own.iter().any(|(place, own)| own.len() != saved.numbers[*place].len()) {
            return Err(SnapshotError::Lengths);
        }
        // Innovations may be missing.
        if !saved.numbers[..5].iter().flatten().all(|number| number.is_finite()) {
            return Err(SnapshotError::NotFinite);
        }
        self.propagation.restore(&saved.plant, carried)?;
        own.into_iter().for_each(|(place, own)| own.copy_from_slice(&saved.numbers[place]));
        self.look();
        Ok(())
    }

    /// Reads values, and their derivatives by what is estimated, at the estimate.
    fn look(&mut self) {
        self.propagation.move_to(&self.belief);
        self.propagation.outputs(&self.belief, &mut self.outputs);
        self.values_from_states();
    }

    /// States are what they are estimated as, whatever mode follows.
    fn values_from_states(&mut self) {
        let Outputs { values, slopes, residuals } = &mut self.outputs;
        let n = self.belief.estimated.len();
        for (column, own) in self.belief.estimated.iter().enumerate() {
            if let Along::State(state) = own.along {
                let place = self.places[state];
                (values[place], residuals[place]) = (self.belief.states[state], 0.0);
                let row = &mut slopes[place * n..(place + 1) * n];
                row.fill(0.0);
                row[column] = own.nominal;
            }
        }
    }

    fn row(&self, place: usize) -> &[f64] {
        let n = self.belief.estimated.len();
        &self.outputs.slopes[place * n..(place + 1) * n]
    }

    /// The plant that is followed.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Names of the estimated states, and of the inputs that are estimated.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.belief.estimated.iter().map(|own| own.name)
    }

    /// The estimate of a computed variable, or of an input, in a place of the table.
    pub fn value(&self, place: Place) -> f64 {
        match place {
            Place::Computed(place) => self.outputs.values[place],
            Place::Input(place) => self.belief.inputs[place],
            _ => f64::NAN,
        }
    }

    /// The standard deviation of this estimate.
    pub fn deviation(&self, place: Place) -> f64 {
        let n = self.belief.estimated.len();
        match place {
            Place::Computed(place) => {
                let row = self.row(place);
                let rows = self.belief.covariance.chunks(n).zip(row);
                let sum: f64 = rows
                    .map(|(of, slope)| slope * of.iter().zip(row).map(|(entry, other)| entry * other).sum::<f64>())
                    .sum();
                (sum + self.outputs.residuals[place]).max(0.0).sqrt()
            }
            Place::Input(place) => {
                let own = self.belief.estimated.iter().position(|own| own.along == Along::Input(place));
                own.map_or(0.0, |own| self.belief.covariance[own * n + own].sqrt() * self.belief.estimated[own].nominal)
            }
            _ => 0.0,
        }
    }

    /// The measurements minus their predictions, in the order of the measured variables; not a number where one was missing.
    pub fn innovation(&self) -> &[f64] {
        &self.innovation
    }

    /// The innovations in units of their predicted deviations: independent, with a variance of 1, where the plant is that of the
    /// observer. The sum of their squares is the normalised square of the innovation.
    pub fn whitened(&self) -> &[f64] {
        &self.whitened
    }

    /// Covariance of the estimated quantities in SI units, by its rows.
    pub fn covariance(&self) -> Vec<f64> {
        let Belief { estimated, covariance, .. } = &self.belief;
        let n = estimated.len();
        let entry = |place: usize| {
            let (row, column) = (place / n, place % n);
            covariance[place] * estimated[row].nominal * estimated[column].nominal
        };
        (0..n * n).map(entry).collect()
    }
}

impl Belief {
    /// Keeps pressures and temperatures above vacuum.
    fn constrain(&mut self) {
        for own in &self.estimated {
            if let Along::State(state) = own.along {
                self.states[state] = self.states[state].max(own.least);
            }
        }
    }
}

fn refused(name: &str, reason: &'static str) -> ObserverError {
    SettingError::NotSettable { name: name.to_owned(), reason }.into()
}

fn check_deviations(observed: Observed) -> Result<(), ObserverError> {
    let Observed { measured, period, process, initial, .. } = observed;
    if !(period > 0.0 && period.is_finite()) {
        return Err(ParameterError::new("period", period, "must be positive").into());
    }
    for (name, deviation) in measured {
        if !(*deviation > 0.0 && deviation.is_finite()) {
            return Err(ParameterError::new(name, *deviation, "a standard deviation of noise must be positive").into());
        }
    }
    for (name, deviation) in process.iter().chain(initial) {
        if !(*deviation >= 0.0 && deviation.is_finite()) {
            return Err(ParameterError::new(name, *deviation, "a standard deviation must not be negative").into());
        }
    }
    Ok(())
}

fn unit(variable: &Variable) -> &'static str {
    if let Kind::Real(unit) = variable.kind { unit.name } else { "" }
}

/// The deviation of the random walk that disturbs a state after 1 s, in units of its nominal value, where none is given: 2 mm/s and
/// 1 kPa in the cylinder, as little as lets the innovations tell a wrong law. A position and states of the friction without a nominal
/// value follow from the velocity.
fn default_process(variable: &Variable) -> f64 {
    match unit(variable) {
        _ if variable.nominal.is_none() => 0.0,
        "Pa" => 0.01,
        "K" => 0.001,
        "m/s" => 0.02,
        "m" => 0.0,
        _ => 0.003,
    }
}

/// The deviation at the start in the same unit.
fn default_start(variable: &Variable) -> f64 {
    match unit(variable) {
        _ if variable.nominal.is_none() => 0.0,
        "Pa" => 0.1,
        _ => 0.01,
    }
}
