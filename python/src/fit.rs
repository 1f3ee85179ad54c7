//! Least squares and intervals of the crate `fit`, over segments that the Python package simulates.

use std::cell::RefCell;

use numpy::ndarray::{Array1, Array2, ShapeBuilder};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pneumatic_servo_fit::causes::{self, Candidates, Cause, Change, Changeable, Choice};
use pneumatic_servo_fit::intervals::{self, Linear};
use pneumatic_servo_fit::jacobian::{jacobian, sensitivities};
use pneumatic_servo_fit::matrix::{DMatrix, from_rows};
use pneumatic_servo_fit::parameter::{Parameter, Values};
use pneumatic_servo_fit::problem::{Interrupted, Problem, Segment, Simulated};
use pneumatic_servo_fit::search::{self, Effort, Loss, Solution, Watch, refine, scattered, solve, with_likely_sensors};
use pneumatic_servo_fit::sensor::Sensor;
use pneumatic_servo_fit::smoothing;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::failure::refused;

type Vector<'py> = Bound<'py, PyArray1<f64>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;
/// Vector, cost, whether the search has come to its end, and why it ended.
type Found<'py> = (Vector<'py>, f64, bool, String);
/// Noise, step of the converter, and whether readings are ranges.
type Noise = (f64, f64, bool);
/// Name, SI unit, start, lower and upper bound, scale, and whether the user gave the bounds.
type Free = (String, String, f64, f64, f64, f64, bool);
/// Name, text, value and interval, item, signal, share of its squares, decrease of the sum of squares, causes alike, and whether
/// it is a sensor.
type Told = (String, String, Option<(f64, f64, f64)>, Option<String>, String, f64, f64, Vec<String>, bool);
/// Derivatives of shape (samples, parameters), scores, and numbers of block and record of each sample.
type Linearised<'py> = (Matrix<'py>, Vector<'py>, Vec<usize>, Vec<usize>);

/// Adds what the Python package uses of the crate.
pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<LeastSquares>()?;
    module.add_function(wrap_pyfunction!(bootstrap, module)?)?;
    module.add_function(wrap_pyfunction!(converter, module)?)?;
    module.add_function(wrap_pyfunction!(covariance, module)?)?;
    module.add_function(wrap_pyfunction!(follow, module)?)?;
    module.add_function(wrap_pyfunction!(is_quiet, module)?)?;
    module.add_function(wrap_pyfunction!(low_pass, module)?)?;
    module.add_function(wrap_pyfunction!(noise, module)?)?;
    module.add_function(wrap_pyfunction!(nonnegative, module)?)?;
    module.add_function(wrap_pyfunction!(parabolas, module)?)?;
    module.add_function(wrap_pyfunction!(sensed, module)?)?;
    module.add_function(wrap_pyfunction!(sensor_of, module)?)?;
    module.add_function(wrap_pyfunction!(unseen, module)?)?;
    module.add_function(wrap_pyfunction!(with_noise_of, module)?)
}

/// A least-squares problem whose segments a function of Python simulates.
#[pyclass(frozen)]
pub struct LeastSquares {
    parameters: Vec<Parameter>,
    segments: Vec<Segment>,
    sensors: Vec<Sensor>,
    step: f64,
    differences: Py<PyAny>,
    near: Option<Py<PyAny>>,
}

#[pymethods]
impl LeastSquares {
    /// Segments are samples, estimated start values and record; `differences` is called with vectors and the solver's tolerance,
    /// and returns measured minus simulated values of shape (vectors, samples). `near` is called with a vector before these, and
    /// returns the same by the derivatives of the run there.
    #[new]
    #[pyo3(signature = (parameters, segments, sensors, step, differences, near=None))]
    fn new(
        parameters: Vec<Free>,
        segments: Vec<(usize, usize, usize)>,
        sensors: Vec<Noise>,
        step: f64,
        differences: Py<PyAny>,
        near: Option<Py<PyAny>>,
    ) -> Self {
        let segment = |(samples, begins, record)| Segment { samples, begins, record };
        Self {
            parameters: parameters.into_iter().map(parameter).collect(),
            segments: segments.into_iter().map(segment).collect(),
            sensors: sensors.into_iter().map(sensor).collect(),
            step,
            differences,
            near,
        }
    }

    /// [`refine`]; an effort is relative changes of cost and vector, the tolerance, and whether derivatives are central and the
    /// search gives up. `see` hears of each vector and its mean square.
    fn refine<'py>(
        &self,
        py: Python<'py>,
        start: Vec<f64>,
        loss: &str,
        effort: (f64, f64, f64, bool, bool),
        see: Option<Py<PyAny>>,
    ) -> PyResult<Found<'py>> {
        let (cost, step, tolerance, is_central, gives_up) = effort;
        let effort = Effort { cost, step, tolerance, is_central, gives_up };
        let loss = loss_of(loss)?;
        let watch = Observer::new(see, None);
        Ok(told(py, self.with(&watch, |problem| refine(problem, &start, loss, effort, &watch))?))
    }

    /// [`solve`]; `done` hears how far it is.
    #[pyo3(signature = (starts, seed, loss, see=None, done=None))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        starts: usize,
        seed: u64,
        loss: &str,
        see: Option<Py<PyAny>>,
        done: Option<Py<PyAny>>,
    ) -> PyResult<Found<'py>> {
        let loss = loss_of(loss)?;
        let watch = Observer::new(see, done);
        Ok(told(py, self.with(&watch, |problem| solve(problem, starts, seed, loss, &watch))?))
    }

    /// [`with_likely_sensors`]: the sensors, and the solution with them.
    #[pyo3(signature = (x, cost, loss, see=None, stage=None))]
    fn weighed<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        cost: f64,
        loss: &str,
        see: Option<Py<PyAny>>,
        stage: Option<Py<PyAny>>,
    ) -> PyResult<(Vec<Noise>, Found<'py>)> {
        let loss = loss_of(loss)?;
        let watch = Observer::new(see, stage);
        let best = Solution { x, cost, converged: true, message: String::new() };
        let (sensors, found) = self.with(&watch, |problem| {
            let (fitted, found) = with_likely_sensors(problem.clone(), best, loss, &watch)?;
            Ok((fitted.sensors, found))
        })?;
        Ok((sensors.iter().map(|one| (one.noise, one.step, one.is_coarse)).collect(), told(py, found)))
    }

    /// [`scattered`].
    fn scattered<'py>(&self, py: Python<'py>, number: usize, seed: u64) -> PyResult<Vec<Vector<'py>>> {
        let watch = Observer::new(None, None);
        let found = self.with(&watch, |problem| Ok(scattered(problem, number, seed)))?;
        Ok(found.into_iter().map(|x| Array1::from(x).into_pyarray(py)).collect())
    }

    /// Sums of the squares of the residuals of vectors.
    fn costs(&self, vectors: Vec<Vec<f64>>) -> PyResult<Vec<f64>> {
        let watch = Observer::new(None, None);
        self.with(&watch, |problem| search::costs(problem, &vectors))
    }

    /// Derivatives of the differences, and the differences; with `of_residuals` derivatives of the residuals.
    fn sensitivities<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        tolerance: f64,
        is_central: bool,
        of_residuals: bool,
    ) -> PyResult<(Matrix<'py>, Vector<'py>)> {
        let watch = Observer::new(None, None);
        let (slopes, base) = self.with(&watch, |problem| {
            let base = problem.simulated.differences(std::slice::from_ref(&x), tolerance)?.swap_remove(0);
            let of = if of_residuals { jacobian } else { sensitivities };
            Ok((of(problem, &x, &base, tolerance, is_central)?, base))
        })?;
        Ok((matrix(py, slopes), Array1::from(base).into_pyarray(py)))
    }

    /// [`causes::causes`] of settings, sensors and choices. `changed` returns the problem with a change: of a kind,
    /// `estimated`, `chosen` or `clock`, with a name, an item and a number.
    #[expect(clippy::too_many_arguments, reason = "the Python package calls it")]
    fn causes(
        &self,
        x: Vec<f64>,
        signals: Vec<String>,
        settings: Vec<Free>,
        sensors: Vec<Free>,
        choices: Vec<(String, String, Vec<String>)>,
        has_clock: bool,
        is_noise: bool,
        changed: Py<PyAny>,
    ) -> PyResult<Vec<Told>> {
        let watch = Observer::new(None, None);
        let of = |every: Vec<Free>| every.into_iter().map(parameter).collect();
        let choice = |(name, fixed, others)| Choice { name, fixed, others };
        let choices = choices.into_iter().map(choice).collect();
        let candidates = Candidates { settings: of(settings), sensors: of(sensors), choices, has_clock };
        let changes = Changes { signals, changed, watch: &watch };
        let found = self.with(&watch, |problem| causes::causes(&changes, &candidates, problem, &x, is_noise))?;
        let told = |Cause { name, text, estimate, item, signal, share, gain, alike, is_sensor }| {
            let estimate = estimate.map(|(value, [low, high])| (value, low, high));
            (name, text, estimate, item, signal, share, gain, alike, is_sensor)
        };
        Ok(found.into_iter().map(told).collect())
    }

    /// [`intervals::linearised`].
    fn linearised<'py>(&self, py: Python<'py>, x: Vec<f64>) -> PyResult<Linearised<'py>> {
        let watch = Observer::new(None, None);
        let Linear { derivatives, scores, blocks, records } =
            self.with(&watch, |problem| intervals::linearised(problem, &x))?;
        Ok((matrix(py, derivatives), Array1::from(scores).into_pyarray(py), blocks, records))
    }
}

impl LeastSquares {
    /// Its simulation.
    fn calls<'a>(&self, watch: &'a Observer) -> Calls<'a> {
        Python::attach(|py| Calls {
            differences: self.differences.clone_ref(py),
            near: self.near.as_ref().map(|near| near.clone_ref(py)),
            watch,
        })
    }

    /// Does something with the problem; what Python has raised meanwhile is raised.
    fn with<T>(&self, watch: &Observer, work: impl FnOnce(&Problem<'_>) -> Result<T, Interrupted>) -> PyResult<T> {
        let calls = self.calls(watch);
        let problem = Problem {
            parameters: self.parameters.clone(),
            segments: self.segments.clone(),
            sensors: self.sensors.clone(),
            simulated: &calls,
            step: self.step,
        };
        let found = work(&problem);
        match watch.raised.take() {
            Some(raised) => Err(raised),
            None => found.map_err(|Interrupted| refused("interrupted")),
        }
    }
}

/// The calls of a function of Python that simulates.
struct Calls<'a> {
    differences: Py<PyAny>,
    near: Option<Py<PyAny>>,
    watch: &'a Observer,
}

impl Simulated for Calls<'_> {
    fn differences(&self, vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        if vectors.is_empty() {
            return Ok(vec![]);
        }
        let called = Python::attach(|py| {
            let vectors = PyArray2::from_vec2(py, vectors)?;
            rows(py, &self.differences.call1(py, (vectors, tolerance))?)
        });
        self.watch.keep(called)
    }

    fn near(&self, x: &[f64], vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        let Some(near) = self.near.as_ref().filter(|_| !vectors.is_empty()) else {
            return self.differences(vectors, tolerance);
        };
        let called = Python::attach(|py| {
            let vectors = PyArray2::from_vec2(py, vectors)?;
            rows(py, &near.call1(py, (x.to_vec().into_pyarray(py), vectors, tolerance))?)
        });
        self.watch.keep(called)
    }
}

fn rows(py: Python<'_>, found: &Py<PyAny>) -> PyResult<Vec<Vec<f64>>> {
    let found: PyReadonlyArray2<'_, f64> = found.extract(py).map_err(PyErr::from)?;
    Ok(found.as_array().rows().into_iter().map(|row| row.to_vec()).collect())
}

/// A function of Python that changes a problem.
struct Changes<'a> {
    signals: Vec<String>,
    changed: Py<PyAny>,
    watch: &'a Observer,
}

impl Changeable for Changes<'_> {
    fn signals(&self) -> Vec<String> {
        self.signals.clone()
    }

    fn changed<'a>(&'a self, change: Change<'a>) -> Result<Box<dyn Simulated + 'a>, Interrupted> {
        let of = match change {
            Change::Estimated(parameter) => ("estimated", parameter.name.as_str(), "", 1.0),
            Change::Chosen { name, item } => ("chosen", name, item, 1.0),
            Change::Clock(clock) => ("clock", "", "", clock),
        };
        let called = Python::attach(|py| -> PyResult<Calls<'a>> {
            let found = self.changed.call1(py, of)?;
            let problem: PyRef<'_, LeastSquares> = found.extract(py).map_err(PyErr::from)?;
            Ok(problem.calls(self.watch))
        });
        Ok(Box::new(self.watch.keep(called)?))
    }
}

/// Functions of Python that hear of a search, and what they have raised.
struct Observer {
    see: Option<Py<PyAny>>,
    text: Option<Py<PyAny>>,
    raised: RefCell<Option<PyErr>>,
}

impl Observer {
    fn new(see: Option<Py<PyAny>>, text: Option<Py<PyAny>>) -> Self {
        Self { see, text, raised: RefCell::default() }
    }

    fn keep<T>(&self, called: PyResult<T>) -> Result<T, Interrupted> {
        called.map_err(|raised| {
            self.raised.replace(Some(raised));
            Interrupted
        })
    }

    fn tell(&self, text: &str) {
        let Some(told) = &self.text else { return };
        // What it raises is raised at the end.
        let _ = self.keep(Python::attach(|py| told.call1(py, (text,))));
    }
}

impl Watch for Observer {
    fn see(&self, x: &[f64], _: &Values, mean_square: f64) -> Result<(), Interrupted> {
        if self.raised.borrow().is_some() {
            return Err(Interrupted);
        }
        let Some(see) = &self.see else { return Ok(()) };
        let called = Python::attach(|py| see.call1(py, (PyArray1::from_slice(py, x), mean_square)));
        self.keep(called).map(drop)
    }

    fn stage(&self, text: &str) {
        self.tell(text);
    }

    fn done(&self, text: &str) {
        self.tell(text);
    }
}

/// Whether RMS residuals, each beside the noise of its sensor, are hardly more than noise.
#[pyfunction]
pub fn is_quiet(residuals: Vec<(f64, f64)>) -> bool {
    causes::is_quiet(residuals)
}

/// Covariance of inner values, and the factors from deviations to half intervals.
#[pyfunction]
pub fn covariance<'py>(
    py: Python<'py>,
    derivatives: PyReadonlyArray2<'py, f64>,
    scores: PyReadonlyArray1<'py, f64>,
    blocks: Vec<usize>,
    records: Vec<usize>,
) -> PyResult<(Matrix<'py>, Vec<f64>)> {
    let (covariance, factors) = intervals::covariance(&linear(&derivatives, &scores, blocks, records)?);
    Ok((matrix(py, covariance), factors))
}

/// Ends of intervals of inner values by the bootstrap of blocks.
#[pyfunction]
pub fn bootstrap(
    derivatives: PyReadonlyArray2<'_, f64>,
    scores: PyReadonlyArray1<'_, f64>,
    blocks: Vec<usize>,
    x: Vec<f64>,
    seed: u64,
    draws: usize,
) -> PyResult<Vec<[f64; 2]>> {
    let records = vec![0; blocks.len()];
    Ok(intervals::bootstrap(&linear(&derivatives, &scores, blocks, records)?, &x, seed, draws))
}

/// Parameters that take part in a direction that the residuals do not see.
#[pyfunction]
pub fn unseen(derivatives: PyReadonlyArray2<'_, f64>) -> Vec<bool> {
    intervals::blind(&dense(&derivatives))
}

/// A function of a sensor, `residual`, `slope`, `score`, `weight` or `log_density`, at each difference.
#[pyfunction]
pub fn sensed<'py>(
    py: Python<'py>,
    function: &str,
    noise: Noise,
    differences: PyReadonlyArray1<'py, f64>,
) -> PyResult<Vector<'py>> {
    let of = match function {
        "residual" => Sensor::residual,
        "slope" => Sensor::slope,
        "score" => Sensor::weighted_score,
        "weight" => Sensor::weight,
        "log_density" => Sensor::log_density,
        _ => return Err(refused(format!("a sensor has no {function}"))),
    };
    let sensor = sensor(noise);
    Ok(differences.as_array().mapv(|difference| of(&sensor, difference)).into_pyarray(py))
}

/// Noise and rounding, and the converter, from measured courses of a signal.
#[pyfunction]
pub fn sensor_of(courses: Vec<PyReadonlyArray1<'_, f64>>) -> Noise {
    let courses: Vec<Vec<f64>> = courses.iter().map(plain).collect();
    let courses: Vec<&[f64]> = courses.iter().map(Vec::as_slice).collect();
    let Sensor { noise, step, is_coarse } = Sensor::of(&courses);
    (noise, step, is_coarse)
}

/// The sensor whose noise makes differences most likely.
#[pyfunction]
pub fn with_noise_of(noise: Noise, differences: PyReadonlyArray1<'_, f64>) -> Noise {
    let Sensor { noise, step, is_coarse } = sensor(noise).with_noise_of(&plain(&differences));
    (noise, step, is_coarse)
}

/// Step of the converter on whose lattice values lie; 0 if they lie on none.
#[pyfunction]
pub fn converter(values: PyReadonlyArray1<'_, f64>) -> f64 {
    pneumatic_servo_fit::sensor::converter(&plain(&values))
}

/// Standard deviation of noise and of quantisation of a signal.
#[pyfunction]
pub fn noise(values: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
    Ok(smoothing::noise(values.as_slice()?))
}

/// Values and slopes of the parabolas about each of equidistant samples.
#[pyfunction]
pub fn parabolas<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    step: f64,
    width: f64,
) -> PyResult<(Vector<'py>, Vector<'py>)> {
    let (smooth, slope) = smoothing::parabolas(values.as_slice()?, step, width);
    Ok((Array1::from(smooth).into_pyarray(py), Array1::from(slope).into_pyarray(py)))
}

/// Output of a filter of first order.
#[pyfunction]
pub fn low_pass<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    step: f64,
    lag: f64,
) -> PyResult<Vector<'py>> {
    Ok(Array1::from(smoothing::low_pass(values.as_slice()?, step, lag)).into_pyarray(py))
}

/// Output of a backlash that follows a signal.
#[pyfunction]
pub fn follow<'py>(py: Python<'py>, values: PyReadonlyArray1<'py, f64>, play: f64) -> PyResult<Vector<'py>> {
    Ok(Array1::from(smoothing::follow(values.as_slice()?, play)).into_pyarray(py))
}

/// Factors, none of them negative, of columns whose sum comes closest to a right side.
#[pyfunction]
pub fn nonnegative(columns: PyReadonlyArray2<'_, f64>, right: PyReadonlyArray1<'_, f64>) -> Vec<f64> {
    pneumatic_servo_fit::nonnegative::nonnegative(&dense(&columns), &plain(&right))
}

fn plain(values: &PyReadonlyArray1<'_, f64>) -> Vec<f64> {
    values.as_array().to_vec()
}

fn sensor((noise, step, is_coarse): Noise) -> Sensor {
    Sensor { noise, step, is_coarse }
}

fn parameter((name, unit, start, low, high, scale, is_bounded): Free) -> Parameter {
    Parameter {
        name,
        unit,
        start,
        bounds: [low, high],
        scale,
        is_given: false,
        is_bounded,
        legal: [f64::NEG_INFINITY, f64::INFINITY],
    }
}

fn loss_of(name: &str) -> PyResult<Loss> {
    name.parse().map_err(PyValueError::new_err::<String>)
}

fn told(py: Python<'_>, Solution { x, cost, converged, message }: Solution) -> Found<'_> {
    (Array1::from(x).into_pyarray(py), cost, converged, message)
}

fn matrix(py: Python<'_>, matrix: DMatrix<f64>) -> Matrix<'_> {
    let shape = matrix.shape().f();
    Array2::from_shape_vec(shape, matrix.as_slice().to_vec()).expect("a number for each place").into_pyarray(py)
}

fn dense(matrix: &PyReadonlyArray2<'_, f64>) -> DMatrix<f64> {
    let [rows, columns] = [matrix.shape()[0], matrix.shape()[1]];
    from_rows(rows, columns, matrix.as_array().iter().copied())
}

fn linear(
    derivatives: &PyReadonlyArray2<'_, f64>,
    scores: &PyReadonlyArray1<'_, f64>,
    blocks: Vec<usize>,
    records: Vec<usize>,
) -> PyResult<Linear> {
    let (derivatives, scores) = (dense(derivatives), plain(scores));
    let rows = derivatives.nrows();
    if [scores.len(), blocks.len(), records.len()].iter().any(|length| *length != rows) {
        return Err(refused(format!("{rows} derivatives need as many scores, blocks and records")));
    }
    Ok(Linear { derivatives, scores, blocks, records })
}
