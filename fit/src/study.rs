//! Measured segments of an experiment, and what is estimated of them.

use std::sync::Arc;

use crate::arrays::mean;
use crate::experiment::{self, Experiment, Given, MeasuredSegment, Options, of_kind};
use crate::expression::Tie;
use crate::parameter::{Parameter, Values};
use crate::problem::{Interrupted, Problem, STEP, Simulated, TOLERANCE};
use crate::record::Record;
use crate::refused::Refused;
use crate::runs::{Runs, WORK};
use crate::sensor::Sensor;
use crate::simulation::{Simulation, Workers};

/// A record, and what is left out of its fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The record.
    pub record: Record,
    /// Where it is from.
    pub name: String,
    /// Number of the table that it is from.
    pub number: usize,
    /// Share at its end that is validation data.
    pub validation: f64,
}

/// A study: a least-squares problem together with what it is made of.
#[derive(Clone)]
pub struct Study {
    /// The experiment.
    pub experiment: Arc<dyn Experiment>,
    /// Its segments.
    pub segments: Vec<MeasuredSegment>,
    /// Estimated parameters.
    pub parameters: Vec<Parameter>,
    /// Sensor of each compared signal.
    pub sensors: Vec<Sensor>,
    /// Values that take the place of known ones.
    pub fixed: Values,
    /// Parameters that follow from others, each from those before it.
    pub ties: Vec<Tie>,
    /// Step of the differences that make the Jacobian, in inner values.
    pub step: f64,
    /// Factor of all friction, where the load factor is an input of the model.
    pub scale: f64,
    /// Factor of the tolerance of the solver.
    pub exactness: f64,
    /// Solver steps after which a run is given up.
    pub most: f64,
    /// Whether derivatives of runs take the place of differences.
    pub is_exact: bool,
    /// Notes on the preparation of the signals, and on choices that the data have made.
    pub notes: Vec<String>,
}

impl Study {
    /// A study of segments, with the usual choices, and sensors as their data tell them.
    pub fn new(experiment: Arc<dyn Experiment>, segments: Vec<MeasuredSegment>, parameters: Vec<Parameter>) -> Self {
        let sensors = sensors(&*experiment, &segments);
        let (fixed, ties, notes) = (Values::new(), vec![], vec![]);
        let (step, scale, exactness, most, is_exact) = (STEP, 1.0, 1.0, f64::INFINITY, false);
        Self { experiment, segments, parameters, sensors, fixed, ties, step, scale, exactness, most, is_exact, notes }
    }

    /// The segments of records.
    pub fn cut(
        experiment: Arc<dyn Experiment>,
        sources: &[Source],
        parameters: Vec<Parameter>,
        ties: Vec<Tie>,
    ) -> Self {
        let known = &experiment.given().known;
        let is_named = |name: &str| {
            let is_tied = ties.iter().any(|tie| tie.name == name);
            known.contains_key(name) || is_tied || parameters.iter().any(|one| one.name == name)
        };
        let (mut segments, mut notes) = (vec![], vec![]);
        for Source { record, name, number, validation } in sources {
            let found = experiment::segments(&*experiment, record, *number, *validation, &is_named);
            segments.extend(found.segments.into_iter().map(|(_, segment)| segment));
            notes.extend(found.notes.into_iter().map(|note| format!("{name}: {note}")));
        }
        Self { ties, notes, ..Self::new(experiment, segments, parameters) }
    }

    /// The same records under other options, with the usual choices.
    ///
    /// # Errors
    /// [`Refused`], as [`of_kind`].
    pub fn recut(&self, options: Options, sources: &[Source]) -> Result<Self, Refused> {
        let experiment = of_kind(Given { options, ..self.experiment.given().clone() })?.into();
        let cut = Self::cut(experiment, sources, self.parameters.clone(), self.ties.clone());
        Ok(Self { fixed: self.fixed.clone(), is_exact: self.is_exact, ..cut })
    }

    /// The same segments under changed settings.
    ///
    /// # Errors
    /// [`Refused`], as [`of_kind`].
    pub fn under(&self, change: impl FnOnce(&mut Given)) -> Result<Self, Refused> {
        let mut given = self.experiment.given().clone();
        change(&mut given);
        Ok(Self { experiment: of_kind(given)?.into(), ..self.clone() })
    }

    /// Its simulation as runs.
    pub fn runs(&self) -> Runs<'_> {
        Runs {
            fixed: self.fixed.clone(),
            ties: &self.ties,
            scale: self.scale,
            exactness: self.exactness,
            most: self.most,
            ..Runs::new(&*self.experiment, &self.segments, self.parameters.clone())
        }
    }

    /// The least-squares problem, on a simulation of the study.
    pub fn problem<'a>(&self, simulated: &'a dyn Simulated) -> Problem<'a> {
        Problem {
            parameters: self.parameters.clone(),
            segments: self.runs().layout(),
            sensors: self.sensors.clone(),
            simulated,
            step: self.step,
        }
    }

    /// Its simulation by workers.
    pub fn simulation<'a>(&'a self, workers: &'a dyn Workers) -> Simulation<'a> {
        Simulation { runs: self.runs(), workers, is_exact: self.is_exact }
    }

    /// Does something with the problem.
    pub fn with<T>(&self, workers: &dyn Workers, work: impl FnOnce(&Problem<'_>) -> T) -> T {
        let simulation = self.simulation(workers);
        work(&self.problem(&simulation))
    }

    /// The vector of the start values.
    pub fn start(&self) -> Vec<f64> {
        let begins = self.segments.iter().map(|segment| segment.begin.estimated.len()).sum();
        let inner = self.parameters.iter().map(|one| one.inner(one.start));
        inner.chain(std::iter::repeat_n(0.0, begins)).collect()
    }

    /// Number of the residuals of the data.
    pub fn size(&self) -> usize {
        self.sensors.len() * self.segments.iter().map(|segment| segment.fitted().count()).sum::<usize>()
    }

    /// The same without validation data, which a search need not simulate.
    pub fn trained(&self) -> Self {
        let segments = self.segments.iter().filter_map(MeasuredSegment::trained).collect();
        Self { segments, ..self.clone() }
    }

    /// Some of its segments alone, and their part of a vector.
    pub fn of_segments(&self, x: &[f64], places: &[usize]) -> (Self, Vec<f64>) {
        let (own, mut begins) = x.split_at(self.parameters.len());
        let mut part =
            |segment: &MeasuredSegment| begins.split_off(..segment.begin.estimated.len()).expect("its start values");
        let parts: Vec<&[f64]> = self.segments.iter().map(&mut part).collect();
        let theirs = places.iter().flat_map(|place| parts[*place]);
        let vector = own.iter().chain(theirs).copied().collect();
        (Self { segments: places.iter().map(|place| self.segments[*place].clone()).collect(), ..self.clone() }, vector)
    }

    /// The same, whose segments begin as a vector of the trained study says; those without fitted samples as they were measured.
    pub fn begun(mut self, trained: &Self, x: &[f64]) -> Self {
        let is_fitted = |segment: &&mut MeasuredSegment| segment.fitted().next().is_some();
        for (segment, values) in self.segments.iter_mut().filter(is_fitted).zip(trained.runs().begins(x)) {
            segment.begin.values = values;
        }
        self
    }

    /// The same, whose parameters start where a vector is; bounds that nobody gave move along.
    pub fn starting_at(mut self, x: &[f64]) -> Self {
        self.parameters = self.parameters.iter().zip(x).map(|(one, x)| one.moved(one.outer(*x))).collect();
        self
    }

    /// The same, which gives up runs that take many times the work of the start.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn bounded(self, workers: &dyn Workers) -> Result<Self, Interrupted> {
        let (simulation, runs) = (self.simulation(workers), self.runs());
        let point = runs.point(&self.start());
        let steps = simulation.by_segment(|place, goes_on| runs.run(place, &point, TOLERANCE, goes_on).steps)?;
        Ok(Self { most: WORK * steps.into_iter().fold(1.0, f64::max), ..self.clone() })
    }

    /// Residuals of the data at a vector, in units of the noise.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn residuals(&self, workers: &dyn Workers, x: &[f64]) -> Result<Vec<f64>, Interrupted> {
        self.with(workers, |problem| {
            let differences = problem.simulated.differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0);
            Ok(problem.residuals(&differences))
        })
    }

    /// Mean square of these at the start, without validation data.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn mean_square(&self, workers: &dyn Workers) -> Result<f64, Interrupted> {
        let trained = self.trained();
        let residuals = trained.residuals(workers, &trained.start())?;
        Ok(mean(&residuals.iter().map(|residual| residual * residual).collect::<Vec<_>>()))
    }
}

/// Sensors of the compared signals, as the data of segments tell them.
pub fn sensors(experiment: &dyn Experiment, segments: &[MeasuredSegment]) -> Vec<Sensor> {
    let of = |signal: &&'static str| {
        if experiment.is_steady() {
            return of_points(experiment, segments, signal);
        }
        let courses: Vec<&[f64]> = segments.iter().map(|segment| segment.record.of(signal)).collect();
        Sensor::of(&courses)
    };
    experiment.compared().iter().map(of).collect()
}

/// The sensor of a signal of points, from all that are used.
fn of_points(experiment: &dyn Experiment, segments: &[MeasuredSegment], signal: &str) -> Sensor {
    let driving = experiment.driving();
    let mut points: Vec<(Vec<f64>, f64)> = Vec::new();
    for MeasuredSegment { record, used, .. } in segments {
        // The velocity comes first among the signals that drive, and last in the order of the points.
        let at = |row: usize| driving.iter().rev().map(|driving| record.of(driving)[row]).collect();
        points.extend((0..used.len()).filter(|row| used[*row]).map(|row| (at(row), record.of(signal)[row])));
    }
    Sensor::of_points(points)
}
