//! Least squares and intervals of the crate `fit`.

use std::collections::BTreeMap;
use std::sync::Mutex;

use numpy::ndarray::{Array1, Array2, ShapeBuilder};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pneumatic_servo_fit::causes::{self, Candidates, Cause, Change, Changeable, Choice};
use pneumatic_servo_fit::experiment::{Begin, MeasuredSegment};
use pneumatic_servo_fit::expression::{Expression, NoExpression, Tie};
use pneumatic_servo_fit::intervals::{self, Linear};
use pneumatic_servo_fit::jacobian::{jacobian, sensitivities};
use pneumatic_servo_fit::matrix::{DMatrix, from_rows};
use pneumatic_servo_fit::parameter::{Parameter, Values};
use pneumatic_servo_fit::problem::{Interrupted, Problem, Simulated};
use pneumatic_servo_fit::runs::{Given, Point, Runs, Underivable};
use pneumatic_servo_fit::search::{self, Effort, Loss, Solution, Watch, refine, scattered, solve, with_likely_sensors};
use pneumatic_servo_fit::sensor::Sensor;
use pneumatic_servo_fit::smoothing;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::experiment::{Experiment, Segment};
use crate::failure::refused;
use crate::many::{Stage, watched};
use crate::threads::pool;

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
    module.add_function(wrap_pyfunction!(expression_names, module)?)?;
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

/// A least-squares problem of measured segments.
#[pyclass(frozen)]
pub struct LeastSquares {
    parameters: Vec<Parameter>,
    experiment: Py<Experiment>,
    segments: Vec<MeasuredSegment>,
    sensors: Vec<Sensor>,
    fixed: Values,
    ties: Vec<Tie>,
    choices: Choices,
    /// Names by which a run had no derivative, and why.
    underivable: Mutex<Underivable>,
}

/// How segments are simulated.
#[derive(Clone, Copy, FromPyObject)]
#[pyo3(from_item_all)]
struct Choices {
    /// Step of the differences that make the Jacobian, in inner values.
    step: f64,
    /// Factor of all friction, where the load factor is an input of the model.
    scale: f64,
    /// Factor of the tolerance of the solver.
    exactness: f64,
    /// Solver steps after which a run is given up.
    most: Option<f64>,
    /// Threads.
    workers: usize,
    /// Whether derivatives of runs take the place of differences.
    is_exact: bool,
}

/// A segment, its start values, the names of those that are estimated, and the number of its record.
type Placed = (Py<Segment>, Values, Vec<String>, usize);
/// Differences of a segment by signal.
type BySignal<'py> = BTreeMap<&'static str, Vector<'py>>;

#[pymethods]
impl LeastSquares {
    /// `ties` are names and expressions of parameters that follow from others.
    #[new]
    #[pyo3(signature = (parameters, experiment, segments, sensors, fixed, ties, choices))]
    fn new(
        parameters: Vec<Free>,
        experiment: Py<Experiment>,
        segments: Vec<Placed>,
        sensors: Vec<Noise>,
        fixed: Values,
        ties: Vec<(String, String)>,
        choices: Choices,
    ) -> PyResult<Self> {
        let placed = |(segment, values, estimated, number): Placed| MeasuredSegment {
            begin: Begin { values, estimated },
            number,
            ..segment.get().inner.clone()
        };
        Ok(Self {
            parameters: parameters.into_iter().map(parameter).collect(),
            experiment,
            segments: segments.into_iter().map(placed).collect(),
            sensors: sensors.into_iter().map(sensor).collect(),
            fixed,
            ties: ties_of(ties)?,
            choices,
            underivable: Mutex::default(),
        })
    }

    /// Names by which a run had no derivative until now, and why.
    #[getter]
    fn underivable(&self) -> BTreeMap<String, String> {
        self.underivable.lock().expect("no thread has panicked").clone()
    }

    /// Values of parameters that a vector stands for.
    fn values(&self, x: Vec<f64>) -> Values {
        self.runs().values(&x)
    }

    /// Start values of the segments that a vector stands for.
    fn begins(&self, x: Vec<f64>) -> Vec<Values> {
        self.runs().begins(&x)
    }

    /// Settings and inputs of the run of a segment.
    fn given<'py>(&self, py: Python<'py>, place: usize, x: Vec<f64>) -> (Values, BySignal<'py>) {
        let runs = self.runs();
        let Given { settings, inputs } = runs.given(place, &runs.point(&x));
        (settings, inputs.into_iter().map(|(name, course)| (name, Array1::from(course).into_pyarray(py))).collect())
    }

    /// Variables of the model at the communication points of each segment.
    fn recorded<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        tolerance: f64,
        outputs: Vec<String>,
    ) -> PyResult<Vec<Vec<Vector<'py>>>> {
        let names: Vec<&str> = outputs.iter().map(String::as_str).collect();
        let every = self.abreast(py, &Observer::new(None, None), |simulated| {
            let point = simulated.runs.point(&x);
            simulated.each(self.segments.len(), |place, goes_on| {
                let given = simulated.runs.given(place, &point);
                simulated.runs.recorded(place, &given, &names, tolerance, goes_on).outputs
            })
        })?;
        let told = |courses: Vec<Vec<f64>>| courses.into_iter().map(|course| course.into_pyarray(py)).collect();
        Ok(every.into_iter().map(told).collect())
    }

    /// Solver steps that no run of a vector should take more than.
    fn limit(&self, py: Python<'_>, x: Vec<f64>, tolerance: f64) -> PyResult<f64> {
        self.abreast(py, &Observer::new(None, None), |simulated| {
            let mut runs = simulated.runs.clone();
            runs.limit_work(&x, tolerance, &|_| !simulated.stage.is_halted());
            Ok(runs.most)
        })
    }

    /// Why a vector cannot be simulated; nothing if it can be.
    fn refusal(&self, x: Vec<f64>, tolerance: f64) -> Option<String> {
        self.runs().refusal(&x, tolerance).map(|why| why.0)
    }

    /// Measured minus simulated values of a vector at all samples, for each segment by signal; NaN where a run failed.
    fn differences<'py>(&self, py: Python<'py>, x: Vec<f64>, tolerance: f64) -> PyResult<Vec<BySignal<'py>>> {
        let every = self.abreast(py, &Observer::new(None, None), |simulated| {
            let point = simulated.runs.point(&x);
            simulated.each(self.segments.len(), |place, goes_on| {
                simulated.runs.differences(place, &point, tolerance, goes_on)
            })
        })?;
        let compared = self.experiment.get().inner.compared();
        let by_signal = |signals: Vec<Vec<f64>>| {
            let pair = |(name, course): (&&'static str, Vec<f64>)| (*name, Array1::from(course).into_pyarray(py));
            compared.iter().zip(signals).map(pair).collect()
        };
        Ok(every.into_iter().map(by_signal).collect())
    }

    /// Measured minus simulated values of vectors, of shape (vectors, samples), at fitted samples or at those of validation data:
    /// segment by segment, in it signal by signal.
    fn stacked<'py>(
        &self,
        py: Python<'py>,
        vectors: Vec<Vec<f64>>,
        tolerance: f64,
        is_validation: bool,
    ) -> PyResult<Matrix<'py>> {
        let rows = self.abreast(py, &Observer::new(None, None), |it| it.stacked(&vectors, tolerance, is_validation))?;
        PyArray2::from_vec2(py, &rows).map_err(refused)
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
        Ok(told(py, self.with(py, &watch, |problem| refine(problem, &start, loss, effort, &watch))?))
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
        Ok(told(py, self.with(py, &watch, |problem| solve(problem, starts, seed, loss, &watch))?))
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
        let (sensors, found) = self.with(py, &watch, |problem| {
            let (fitted, found) = with_likely_sensors(problem.clone(), best, loss, &watch)?;
            Ok((fitted.sensors, found))
        })?;
        Ok((sensors.iter().map(|one| (one.noise, one.step, one.is_coarse)).collect(), told(py, found)))
    }

    /// [`scattered`].
    fn scattered<'py>(&self, py: Python<'py>, number: usize, seed: u64) -> PyResult<Vec<Vector<'py>>> {
        let watch = Observer::new(None, None);
        let found = self.with(py, &watch, |problem| Ok(scattered(problem, number, seed)))?;
        Ok(found.into_iter().map(|x| Array1::from(x).into_pyarray(py)).collect())
    }

    /// Sums of the squares of the residuals of vectors.
    fn costs(&self, py: Python<'_>, vectors: Vec<Vec<f64>>) -> PyResult<Vec<f64>> {
        let watch = Observer::new(None, None);
        self.with(py, &watch, |problem| search::costs(problem, &vectors))
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
        let (slopes, base) = self.with(py, &watch, |problem| {
            let base = problem.simulated.differences(std::slice::from_ref(&x), tolerance)?.swap_remove(0);
            let of = if of_residuals { jacobian } else { sensitivities };
            Ok((of(problem, &x, &base, tolerance, is_central)?, base))
        })?;
        Ok((matrix(py, slopes), Array1::from(base).into_pyarray(py)))
    }

    /// [`causes::causes`] of settings, sensors and choices.
    #[expect(clippy::too_many_arguments, reason = "the Python package calls it")]
    fn causes(
        &self,
        py: Python<'_>,
        x: Vec<f64>,
        settings: Vec<Free>,
        sensors: Vec<Free>,
        choices: Vec<(String, String, Vec<String>)>,
        has_clock: bool,
        is_noise: bool,
    ) -> PyResult<Vec<Told>> {
        let watch = Observer::new(None, None);
        let of = |every: Vec<Free>| every.into_iter().map(parameter).collect();
        let choice = |(name, fixed, others)| Choice { name, fixed, others };
        let choices = choices.into_iter().map(choice).collect();
        let candidates = Candidates { settings: of(settings), sensors: of(sensors), choices, has_clock };
        let found = self.abreast(py, &watch, |simulated| {
            causes::causes(simulated, &candidates, &self.problem(simulated), &x, is_noise)
        })?;
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
            self.with(py, &watch, |problem| intervals::linearised(problem, &x))?;
        Ok((matrix(py, derivatives), Array1::from(scores).into_pyarray(py), blocks, records))
    }
}

impl LeastSquares {
    fn runs(&self) -> Runs<'_> {
        Runs {
            fixed: self.fixed.clone(),
            ties: &self.ties,
            scale: self.choices.scale,
            exactness: self.choices.exactness,
            most: self.choices.most.unwrap_or(f64::INFINITY),
            ..Runs::new(&*self.experiment.get().inner, &self.segments, self.parameters.clone())
        }
    }

    fn problem<'a>(&self, simulated: &'a Abreast<'_>) -> Problem<'a> {
        Problem {
            parameters: self.parameters.clone(),
            segments: simulated.runs.layout(),
            sensors: self.sensors.clone(),
            simulated,
            step: self.choices.step,
        }
    }

    /// Does something with the simulation on threads, while this one waits for an interrupt; what Python has raised meanwhile is
    /// raised.
    fn abreast<T: Send>(
        &self,
        py: Python<'_>,
        watch: &Observer,
        work: impl FnOnce(&Abreast<'_>) -> Result<T, Interrupted> + Send,
    ) -> PyResult<T> {
        let (pool, stage) = (pool(self.choices.workers)?, Stage::default());
        let (found, ended) = py.detach(|| {
            watched(&stage, crate::watch::Watch::new(None), || {
                let (runs, is_exact, underivable) = (self.runs(), self.choices.is_exact, &self.underivable);
                work(&Abreast { runs, pool: &pool, stage: &stage, is_exact, underivable })
            })
        });
        ended?;
        match watch.raised.lock().expect("no thread has panicked").take() {
            Some(raised) => Err(raised),
            None => found.map_err(|Interrupted| refused("interrupted")),
        }
    }

    /// Does something with the problem.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        watch: &Observer,
        work: impl FnOnce(&Problem<'_>) -> Result<T, Interrupted> + Send,
    ) -> PyResult<T> {
        self.abreast(py, watch, |simulated| work(&self.problem(simulated)))
    }
}

/// Parameters that follow from others, of names and expressions.
///
/// # Errors
/// `ValueError` for what is no expression.
pub fn ties_of(given: Vec<(String, String)>) -> PyResult<Vec<Tie>> {
    let tie = |(name, text): (String, String)| {
        let expression = Expression::checked(&text).map_err(refused)?;
        Ok(Tie { name, expression })
    };
    given.into_iter().map(tie).collect()
}

/// Segments that are simulated side by side.
struct Abreast<'a> {
    runs: Runs<'a>,
    pool: &'a rayon::ThreadPool,
    stage: &'a Stage,
    is_exact: bool,
    underivable: &'a Mutex<Underivable>,
}

impl Abreast<'_> {
    /// Does pieces of work, each of which asks now and then whether to go on.
    fn each<T: Send>(
        &self,
        count: usize,
        work: impl Fn(usize, &dyn Fn(f64) -> bool) -> T + Sync,
    ) -> Result<Vec<T>, Interrupted> {
        let goes_on = |_| !self.stage.is_halted();
        let found = self.pool.install(|| (0..count).into_par_iter().map(|place| work(place, &goes_on)).collect());
        if self.stage.is_halted() { Err(Interrupted) } else { Ok(found) }
    }

    fn stacked(&self, vectors: &[Vec<f64>], tolerance: f64, is_validation: bool) -> Result<Vec<Vec<f64>>, Interrupted> {
        let number = self.runs.segments.len();
        let points: Vec<Point> = vectors.iter().map(|x| self.runs.point(x)).collect();
        let every = self.each(number * vectors.len(), |piece, goes_on| {
            self.runs.differences(piece % number, &points[piece / number], tolerance, goes_on)
        })?;
        Ok(every.chunks(number.max(1)).map(|own| self.runs.stacked(own, is_validation)).collect())
    }
}

impl Simulated for Abreast<'_> {
    fn differences(&self, vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        self.stacked(vectors, tolerance, false)
    }

    fn near(&self, x: &[f64], vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        if !self.is_exact || vectors.is_empty() {
            return self.differences(vectors, tolerance);
        }
        let at = self.runs.point(x);
        let points: Vec<Point> = vectors.iter().map(|x| self.runs.point(x)).collect();
        let every = self.each(self.runs.segments.len(), |place, goes_on| {
            let mut underivable = Underivable::new();
            let found = self.runs.near(place, &at, &points, tolerance, goes_on, &mut underivable);
            self.underivable.lock().expect("no thread has panicked").append(&mut underivable);
            found
        })?;
        let of_point = |point: usize| {
            let own: Vec<_> = every.iter().map(|segment| segment[point].clone()).collect();
            self.runs.stacked(&own, false)
        };
        Ok((0..vectors.len()).map(of_point).collect())
    }
}

impl Changeable for Abreast<'_> {
    fn signals(&self) -> Vec<String> {
        self.runs.signals()
    }

    fn changed<'a>(&'a self, change: Change<'a>) -> Result<Box<dyn Simulated + 'a>, Interrupted> {
        Ok(Box::new(Abreast { runs: self.runs.changed(change), ..*self }))
    }
}

/// Functions of Python that hear of a search, and what they have raised.
struct Observer {
    see: Option<Py<PyAny>>,
    text: Option<Py<PyAny>>,
    raised: Mutex<Option<PyErr>>,
}

impl Observer {
    fn new(see: Option<Py<PyAny>>, text: Option<Py<PyAny>>) -> Self {
        Self { see, text, raised: Mutex::default() }
    }

    fn keep<T>(&self, called: PyResult<T>) -> Result<T, Interrupted> {
        called.map_err(|raised| {
            self.raised.lock().expect("no thread has panicked").get_or_insert(raised);
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
        if self.raised.lock().expect("no thread has panicked").is_some() {
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

/// Names in an expression of parameters; nothing of a text that is written otherwise, or is but one name.
///
/// # Errors
/// `ValueError` for a function that there is not.
#[pyfunction]
pub fn expression_names(text: &str) -> PyResult<Option<Vec<String>>> {
    match Expression::read(text) {
        Ok(Expression::Name(_)) | Err(NoExpression::Other) => Ok(None),
        Ok(found) => Ok(Some(found.names()).filter(|names| !names.is_empty())),
        Err(NoExpression::Unknown(_)) => Err(Expression::checked(text).map_or_else(refused, |_| refused(text))),
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
