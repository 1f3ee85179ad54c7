//! An observer: an extended Kalman filter on the transitions of a plant.
//!
//! ```text
//! x- = f(x, u),  P- = A*P*A' + Q*T        K = P-*h'/(h*P-*h' + r),  x+ = x- + K*(y - h(x-))
//! ```
//!
//! `f` is a step of the plant with all its events, and `A` its exact derivative (`Varied`), through stick and slip. Measurements
//! are taken in one by one, with the covariance in Joseph's form, in units of nominal values.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Setup;
use crate::numbers::{DIRECTIONS, Tangent};
use crate::sensitivity::{Along, Varied};
use crate::session::{Snapshot, SnapshotError};
use crate::solver::StepError;
use crate::variables::{Kind, ParameterError, Place, SettingError, Variable, find};

/// Share of its start above which the estimate of a pressure or temperature stays.
const VACUUM: f64 = 0.01;

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
    /// Runs of the plant beside each other, each with slopes in a few directions.
    runs: Vec<Box<dyn Varied>>,
    estimated: Vec<Estimated>,
    measured: Vec<Measured>,
    /// Whether all measured variables are continuous states.
    measures_states: bool,
    period: f64,
    /// Values of all continuous states of the table, in SI units.
    states: Vec<f64>,
    /// Places of these among the computed variables.
    places: Vec<usize>,
    /// The inputs of the last step, estimates included.
    inputs: Vec<f64>,
    /// Offsets of the inputs that are estimated, by their places.
    offsets: Vec<f64>,
    /// Covariance in nominal units, by its rows.
    covariance: Vec<f64>,
    transition: Vec<f64>,
    room: Vec<f64>,
    gain: Vec<f64>,
    /// Continuous states and computed variables with slopes, of one run.
    moved: Vec<Tangent>,
    shown: Vec<Tangent>,
    /// Values of the computed variables, and their derivatives by what is estimated, row by row.
    values: Vec<f64>,
    slopes: Vec<f64>,
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
        let mut runs = (0..n.div_ceil(DIRECTIONS)).map(|_| setup.varied(0.0, &[])).collect::<Result<Vec<_>, _>>()?;
        runs.iter_mut().for_each(|run| run.be_silent());
        let mut observer = Self {
            setup: setup.clone(),
            runs,
            estimated,
            measures_states: measured.iter().all(|own| places.contains(&own.place)),
            measured,
            period: observed.period,
            states: vec![0.0; references.len()],
            places,
            inputs: setup.inputs().to_vec(),
            offsets: vec![0.0; setup.inputs().len()],
            covariance,
            transition: identity(n),
            room: vec![0.0; n * n],
            gain: vec![0.0; n],
            moved: vec![Tangent::still(0.0); references.len()],
            shown: vec![Tangent::still(0.0); computed],
            values: vec![0.0; computed],
            slopes: vec![0.0; computed * n],
            innovation: vec![f64::NAN; m],
            whitened: vec![f64::NAN; m],
        };
        for (state, place) in observer.places.iter().enumerate() {
            observer.states[state] = plant.value(Place::Computed(*place));
        }
        observer.seed();
        observer.look();
        if let Some(place) =
            observer.measured.iter().position(|measured| observer.row(measured.place).iter().any(|it| it.is_nan()))
        {
            let reason = "it is rounded: give the variable before its rounding, and the rounding as noise";
            return Err(refused(observed.measured[place].0, reason));
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
        assert_eq!((inputs.len(), measured.len()), (self.inputs.len(), self.measured.len()));
        self.predict(inputs)?;
        self.innovation.fill(f64::NAN);
        self.whitened.fill(f64::NAN);
        for (place, value) in measured.iter().enumerate() {
            if let Some(value) = value {
                self.correct(place, *value);
            }
        }
        self.constrain();
        self.seed();
        self.look();
        Ok(())
    }

    /// Goes a period on.
    fn predict(&mut self, inputs: &[f64]) -> Result<(), StepError> {
        let n = self.estimated.len();
        for ((slot, own), offset) in self.inputs.iter_mut().zip(inputs).zip(&self.offsets) {
            *slot = own + offset;
        }
        for (number, run) in self.runs.iter_mut().enumerate() {
            run.set_inputs(&self.inputs, &[0.0; 64][..self.inputs.len()]);
            run.step(self.period)?;
            run.states(&mut self.moved);
            for direction in 0..DIRECTIONS {
                let column = number * DIRECTIONS + direction;
                if column >= n || run.lost(direction).is_some() {
                    // The derivative of the step before serves.
                    continue;
                }
                for (row, own) in self.estimated.iter().enumerate() {
                    self.transition[row * n + column] = match own.along {
                        Along::State(state) => {
                            self.moved[state].slopes[direction] * self.estimated[column].nominal / own.nominal
                        }
                        _ => f64::from(u8::from(row == column)),
                    };
                }
            }
        }
        self.states.iter_mut().zip(&self.moved).for_each(|(slot, moved)| *slot = moved.value);
        // A*P*A' + Q*T.
        for row in 0..n {
            for column in 0..n {
                let terms = (0..n).map(|k| self.transition[row * n + k] * self.covariance[k * n + column]);
                self.room[row * n + column] = terms.sum();
            }
        }
        for row in 0..n {
            for column in 0..=row {
                let terms = (0..n).map(|k| self.room[row * n + k] * self.transition[column * n + k]);
                let sum: f64 = terms.sum();
                self.covariance[row * n + column] = sum;
                self.covariance[column * n + row] = sum;
            }
            self.covariance[row * n + row] += self.estimated[row].process * self.period;
        }
        if self.measures_states {
            self.values_from_states();
        } else {
            self.seed();
            self.look();
        }
        Ok(())
    }

    /// Takes a measurement in.
    fn correct(&mut self, number: usize, value: f64) {
        let (n, Measured { place, variance }) = (self.estimated.len(), self.measured[number]);
        let predicted = self.values[place];
        let row: &[f64] = &self.slopes[place * n..(place + 1) * n];
        // P*h'.
        for (slot, of) in self.gain.iter_mut().zip(self.covariance.chunks(n)) {
            *slot = of.iter().zip(row).map(|(entry, slope)| entry * slope).sum();
        }
        let own: f64 = self.gain.iter().zip(row).map(|(entry, slope)| entry * slope).sum();
        let total = own + variance;
        let innovation = value - predicted;
        self.innovation[number] = innovation;
        self.whitened[number] = innovation / total.sqrt();
        for (place, own) in self.estimated.iter().enumerate() {
            let change = self.gain[place] / total * innovation * own.nominal;
            match own.along {
                Along::State(state) => self.states[state] += change,
                Along::Input(input) => {
                    self.offsets[input] += change;
                    self.inputs[input] += change;
                }
                _ => {}
            }
        }
        // The predictions of the other measurements follow.
        for later in number + 1..self.measured.len() {
            let place = self.measured[later].place;
            let row = &self.slopes[place * n..(place + 1) * n];
            let change: f64 = row.iter().zip(&self.gain).map(|(slope, gain)| slope * gain).sum();
            self.values[place] += change / total * innovation;
        }
        // Joseph's form (I - K*h)*P*(I - K*h)' + K*r*K', with the products that K*h has in common.
        for row in 0..n {
            let gain = self.gain[row] / total;
            let left = self.gain[row] - gain * own;
            for column in 0..=row {
                let other = self.gain[column] / total;
                let once = self.covariance[row * n + column] - gain * self.gain[column];
                let entry = once - left * other + gain * variance * other;
                self.covariance[row * n + column] = entry;
                self.covariance[column * n + row] = entry;
            }
        }
    }

    /// Keeps pressures and temperatures above vacuum.
    fn constrain(&mut self) {
        for own in &self.estimated {
            if let Along::State(state) = own.along {
                self.states[state] = self.states[state].max(own.least);
            }
        }
    }

    /// Everything that changes from step to step.
    pub(crate) fn save(&self) -> SavedObserver {
        let Self { states, inputs, offsets, covariance, transition, innovation, whitened, .. } = self;
        let numbers = [states, inputs, offsets, covariance, transition, innovation, whitened].map(Clone::clone);
        SavedObserver { plant: self.runs[0].save(), numbers }
    }

    /// Goes back to what was saved of the same observer.
    ///
    /// # Errors
    /// [`SnapshotError`] when it does not fit.
    pub(crate) fn restore(&mut self, saved: &SavedObserver) -> Result<(), SnapshotError> {
        let Self { states, inputs, offsets, covariance, transition, innovation, whitened, .. } = self;
        let own = [states, inputs, offsets, covariance, transition, innovation, whitened];
        if own.iter().zip(&saved.numbers).any(|(own, saved)| own.len() != saved.len()) {
            return Err(SnapshotError::Lengths);
        }
        // Innovations may be missing.
        if !saved.numbers[..5].iter().flatten().all(|number| number.is_finite()) {
            return Err(SnapshotError::NotFinite);
        }
        for run in &mut self.runs {
            run.place(&saved.plant, &[])?;
        }
        own.into_iter().zip(&saved.numbers).for_each(|(own, saved)| own.copy_from_slice(saved));
        self.seed();
        self.look();
        Ok(())
    }

    /// Lets each run vary in its directions, from the present estimates.
    fn seed(&mut self) {
        let mut along = [Along::Input(0); DIRECTIONS];
        for (number, run) in self.runs.iter_mut().enumerate() {
            let own = &self.estimated[number * DIRECTIONS..self.estimated.len().min((number + 1) * DIRECTIONS)];
            for (slot, it) in along.iter_mut().zip(own) {
                *slot = it.along;
            }
            run.reseed(&self.states, &along[..own.len()]);
            run.set_inputs(&self.inputs, &[0.0; 64][..self.inputs.len()]);
        }
    }

    /// Reads values, and their derivatives by what is estimated, where the runs are seeded.
    fn look(&mut self) {
        let n = self.estimated.len();
        for (number, run) in self.runs.iter_mut().enumerate() {
            run.outputs(&mut self.shown);
            for (place, shown) in self.shown.iter().enumerate() {
                self.values[place] = shown.value;
                for (direction, slope) in shown.slopes.iter().enumerate() {
                    let column = number * DIRECTIONS + direction;
                    if column < n {
                        self.slopes[place * n + column] = slope * self.estimated[column].nominal;
                    }
                }
            }
        }
        self.values_from_states();
    }

    /// States are what they are estimated as, whatever mode follows.
    fn values_from_states(&mut self) {
        let n = self.estimated.len();
        for (column, own) in self.estimated.iter().enumerate() {
            if let Along::State(state) = own.along {
                let place = self.places[state];
                self.values[place] = self.states[state];
                let row = &mut self.slopes[place * n..(place + 1) * n];
                row.fill(0.0);
                row[column] = own.nominal;
            }
        }
    }

    fn row(&self, place: usize) -> &[f64] {
        let n = self.estimated.len();
        &self.slopes[place * n..(place + 1) * n]
    }

    /// The plant that is followed.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Names of the estimated states, and of the inputs that are estimated.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.estimated.iter().map(|own| own.name)
    }

    /// The estimate of a computed variable, or of an input, in a place of the table.
    pub fn value(&self, place: Place) -> f64 {
        match place {
            Place::Computed(place) => self.values[place],
            Place::Input(place) => self.inputs[place],
            _ => f64::NAN,
        }
    }

    /// The standard deviation of this estimate.
    pub fn deviation(&self, place: Place) -> f64 {
        let n = self.estimated.len();
        match place {
            Place::Computed(place) => {
                let row = self.row(place);
                let rows = self.covariance.chunks(n).zip(row);
                let sum: f64 = rows
                    .map(|(of, slope)| slope * of.iter().zip(row).map(|(entry, other)| entry * other).sum::<f64>())
                    .sum();
                sum.max(0.0).sqrt()
            }
            Place::Input(place) => {
                let own = self.estimated.iter().position(|own| own.along == Along::Input(place));
                own.map_or(0.0, |own| self.covariance[own * n + own].sqrt() * self.estimated[own].nominal)
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
        let n = self.estimated.len();
        let entry = |place: usize| {
            let (row, column) = (place / n, place % n);
            self.covariance[place] * self.estimated[row].nominal * self.estimated[column].nominal
        };
        (0..n * n).map(entry).collect()
    }
}

fn identity(n: usize) -> Vec<f64> {
    (0..n * n).map(|place| f64::from(u8::from(place / n == place % n))).collect()
}

fn refused(name: &str, reason: &'static str) -> ObserverError {
    SettingError::NotSettable { name: name.to_owned(), reason }.into()
}

fn check_deviations(observed: Observed) -> Result<(), ObserverError> {
    let Observed { measured, period, process, initial } = observed;
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
