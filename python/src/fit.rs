//! Least squares and intervals of the crate `fit`.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use numpy::ndarray::{Array1, Array2, ShapeBuilder};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pneumatic_servo_fit::NoAnswer;
use pneumatic_servo_fit::candidates::candidates;
use pneumatic_servo_fit::causes::{self, Candidates, Cause};
use pneumatic_servo_fit::cross_validation::{Case, Friction, Group, cross_validate};
use pneumatic_servo_fit::driver::{Reached, Search};
use pneumatic_servo_fit::experiment::{Begin, Inputs, MeasuredSegment};
use pneumatic_servo_fit::expression::{Expression, NoExpression, Tie};
use pneumatic_servo_fit::guess::started;
use pneumatic_servo_fit::intervals::{self, Certainty, Ends, Linear};
use pneumatic_servo_fit::jacobian::{jacobian, sensitivities};
use pneumatic_servo_fit::matrix::{DMatrix, from_rows};
use pneumatic_servo_fit::parameter::{Parameter, Values};
use pneumatic_servo_fit::problem::{Interrupted, Problem, TOLERANCE};
use pneumatic_servo_fit::profile::profile;
use pneumatic_servo_fit::runs::Given;
use pneumatic_servo_fit::search::{self, Loss, ROUGH, Solution, Unwatched, Watch, refine, scattered};
use pneumatic_servo_fit::sensor::Sensor;
use pneumatic_servo_fit::series::{self, Joint};
use pneumatic_servo_fit::simulation::{Simulation, Task, Underivable, Workers};
use pneumatic_servo_fit::smoothing;
use pneumatic_servo_fit::study::{Source, Study};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyCFunction;
use rayon::prelude::*;

use crate::experiment::{Experiment, Measured, Segment, record_of};
use crate::failure::refused;
use crate::many::{Stage, watched};
use crate::threads::pool;

type Vector<'py> = Bound<'py, PyArray1<f64>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;
/// Vector, cost, whether the search has come to its end, and why it ended.
type Found<'py> = (Vector<'py>, f64, bool, String);
/// Noise, step of the converter, and whether readings are ranges.
type Noise = (f64, f64, bool);
/// Name, SI unit, start, lower and upper bound, scale, whether the user gave the start and the bounds, and the smallest and largest
/// value that the model accepts.
pub type Free = (String, String, f64, f64, f64, f64, bool, bool, f64, f64);
/// Name, text, fixed value, estimate, signal, share of its squares, decrease of the sum of squares, causes alike, and whether it is a
/// sensor.
type CauseParts = (String, String, Fixed, Estimated, String, f64, f64, Vec<String>, bool);
/// Vectors of all records, whether no step is left, half intervals, and probabilities.
type Together<'py> = (Vec<Vector<'py>>, bool, Vec<f64>, Vec<f64>);
/// Vector of the other conditions and its own, predicted and fitted RMS residual of each signal, and of friction the prediction with
/// its ends, the measurement with its ends, and the spread.
type LeftOut<'py> = (Vector<'py>, Vector<'py>, Vec<[f64; 2]>, Option<([f64; 3], [f64; 3], f64)>);
/// Derivatives of shape (samples, parameters), scores, and numbers of block and record of each sample.
type Linearised<'py> = (Matrix<'py>, Vector<'py>, Vec<usize>, Vec<usize>);

/// Adds what the Python package uses of the crate.
pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<LeastSquares>()?;
    module.add_function(wrap_pyfunction!(converter, module)?)?;
    module.add_function(wrap_pyfunction!(covariance, module)?)?;
    module.add_function(wrap_pyfunction!(expression_names, module)?)?;
    module.add_function(wrap_pyfunction!(given_parameter, module)?)?;
    module.add_function(wrap_pyfunction!(joint, module)?)?;
    module.add_function(wrap_pyfunction!(noise, module)?)?;
    module.add_function(wrap_pyfunction!(number, module)?)?;
    module.add_function(wrap_pyfunction!(sensed, module)?)?;
    module.add_function(wrap_pyfunction!(sensor_of, module)?)?;
    module.add_function(wrap_pyfunction!(slopes, module)?)?;
    module.add_function(wrap_pyfunction!(unseen, module)?)?;
    module.add_function(wrap_pyfunction!(with_noise_of, module)?)
}

/// A least-squares problem of measured segments.
#[pyclass(frozen, module = "pneumatic_servo._native")]
pub struct LeastSquares {
    study: Study,
    /// Texts of the expressions of its ties.
    texts: Vec<(String, String)>,
    /// Threads.
    workers: usize,
    /// Names by which a run had no derivative, and why.
    underivable: Mutex<Underivable>,
}

/// The fixed value of a cause.
#[derive(IntoPyObject)]
pub enum Fixed {
    /// A number.
    Number(f64),
    /// The item of a choice.
    Item(String),
}

/// Its estimate.
#[derive(IntoPyObject)]
pub enum Estimated {
    /// Value, interval and SI unit.
    Number((f64, f64, f64, String)),
    /// The item of a choice.
    Item(String),
}

/// How segments are simulated.
#[derive(Clone, Copy, FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct Choices {
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
/// Lower and upper ends, correlations, why the data do not determine parameters, and values and ends of tied ones.
type Certain<'py> = (Vector<'py>, Vector<'py>, Matrix<'py>, Vec<(String, &'static str)>, Vec<[f64; 3]>);
/// What [`LeastSquares`] is made of.
type Made = (
    Vec<Free>,
    Experiment,
    Vec<(Segment, Values, Vec<String>, usize)>,
    Vec<Noise>,
    Values,
    Vec<(String, String)>,
    Choices,
);
/// Name, signals, number of the table, and share of validation data of a record.
type Recorded<'py> = (String, Measured<'py>, usize, f64);

/// How far a search has come.
#[derive(IntoPyObject)]
pub struct Outcome<'py> {
    /// Length in s of the segments, course of inputs, and whether forces are smoothed.
    options: (Option<f64>, Option<&'static str>, Option<bool>),
    /// Start and bounds of the parameters.
    parameters: Vec<(f64, f64, f64)>,
    /// Start values of all segments.
    begins: Vec<Values>,
    /// Sensors before and after the last search.
    sensors: [Vec<Noise>; 2],
    /// How segments are simulated.
    choices: Choices,
    best: Option<Found<'py>>,
    notes: Vec<String>,
    other_form: Option<CauseParts>,
    is_interrupted: bool,
}

/// Differences of a segment by signal.
type BySignal<'py> = BTreeMap<&'static str, Vector<'py>>;

#[pymethods]
impl LeastSquares {
    /// `ties` are names and expressions of parameters that follow from others.
    #[new]
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
        let Choices { step, scale, exactness, most, workers, is_exact } = choices;
        let study = Study {
            experiment: Arc::clone(&experiment.get().inner),
            segments: segments.into_iter().map(placed).collect(),
            parameters: parameters.into_iter().map(parameter).collect(),
            sensors: sensors.into_iter().map(sensor).collect(),
            fixed,
            ties: ties_of(ties.clone())?,
            step,
            scale,
            exactness,
            most: most.unwrap_or(f64::INFINITY),
            is_exact,
            notes: vec![],
        };
        Ok(Self { study, texts: ties, workers, underivable: Mutex::default() })
    }

    /// What is sent to other processes.
    fn __reduce__<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, Made) {
        let Study { experiment, segments, parameters, sensors, fixed, .. } = &self.study;
        let placed = |segment: &MeasuredSegment| {
            let Begin { values, estimated } = segment.begin.clone();
            (Segment { inner: segment.clone() }, values, estimated, segment.number)
        };
        let made = (
            parameters.iter().cloned().map(free).collect(),
            Experiment { inner: Arc::clone(experiment) },
            segments.iter().map(placed).collect(),
            sensors.iter().map(noise_of).collect(),
            fixed.clone(),
            self.texts.clone(),
            choices_of(&self.study, self.workers),
        );
        (py.get_type::<Self>().into_any(), made)
    }

    /// The vector of the start values.
    fn start<'py>(&self, py: Python<'py>) -> Vector<'py> {
        Array1::from(self.study.start()).into_pyarray(py)
    }

    /// Number of the residuals.
    fn size(&self) -> usize {
        self.study.size()
    }

    /// Start and bounds of the parameters, as the data tell them.
    fn started(&self) -> Vec<(f64, f64, f64)> {
        let Study { experiment, segments, parameters, .. } = &self.study;
        limits(&started(&**experiment, segments, parameters))
    }

    /// [`Search::run`]. Its progress goes to methods of `watch`: to `see` the least mean square and the number of vectors, once in
    /// `every` seconds; to `stage`, `done` and `hidden` their texts and names. `solver` searches elsewhere, in place of the threads
    /// here: it gets a problem, the number of starts, and a function that tells whether to stop.
    #[expect(clippy::too_many_arguments, reason = "the Python package calls it")]
    #[pyo3(signature = (sources, notes, starts, seed, loss, watch, every, solver=None))]
    fn search<'py>(
        &self,
        py: Python<'py>,
        sources: Vec<Recorded<'py>>,
        notes: Vec<String>,
        starts: usize,
        seed: u64,
        loss: &str,
        watch: Option<Py<PyAny>>,
        every: f64,
        solver: Option<Py<PyAny>>,
    ) -> PyResult<Option<Outcome<'py>>> {
        let source = |(name, measured, number, validation): Recorded<'py>| {
            let record = record_of(&measured);
            Source { record, name, number, validation }
        };
        let sources: Vec<Source> = sources.into_iter().map(source).collect();
        let study = Study { notes, ..self.study.clone() };
        let (loss, watch) = (loss_of(loss)?, Observer::new(watch, every));
        let (mut reached, stage) = (None, Arc::new(Stage::default()));
        let ended = self.watched(py, &stage, |workers| {
            let elsewhere = |study: &Study, starts, best: &dyn Watch| {
                let solver = solver.as_ref().expect("only then it is asked");
                let found = Python::attach(|py| self.elsewhere(py, solver, study, starts, &stage));
                let (found, is_interrupted) = watch.keep(found)?;
                best.see(&found.x, &Values::new(), 2.0 * found.cost / study.size() as f64)?;
                if is_interrupted { Err(Interrupted) } else { Ok(found) }
            };
            let solver: Option<&pneumatic_servo_fit::driver::Solver<'_>> =
                if solver.is_some() { Some(&elsewhere) } else { None };
            Search { workers, sources: &sources, starts, seed, loss, solver }.run(study, &watch, &mut reached)
        });
        let ended =
            match ended.map_err(Some).and_then(|ended| watch.raised().map_or(Ok(ended), |raised| Err(Some(raised)))) {
                Ok(Err(NoAnswer::Refused(why))) => Err(Some(refused(why.0))),
                Ok(Err(NoAnswer::Interrupted)) => Err(None),
                Ok(Ok(())) => Ok(()),
                Err(raised) => Err(raised),
            };
        let is_interrupted = match ended {
            Ok(()) => false,
            Err(Some(raised)) if !raised.is_instance_of::<PyKeyboardInterrupt>(py) => return Err(raised),
            Err(_) => true,
        };
        Ok(reached.map(|reached| outcome(py, reached, is_interrupted, self.workers)))
    }

    /// Names by which a run had no derivative until now, and why.
    #[getter]
    fn underivable(&self) -> BTreeMap<String, String> {
        self.underivable.lock().expect("no thread has panicked").clone()
    }

    /// Values of parameters that a vector stands for.
    fn values(&self, x: Vec<f64>) -> Values {
        self.study.runs().values(&x)
    }

    /// Start values of the segments that a vector stands for.
    fn begins(&self, x: Vec<f64>) -> Vec<Values> {
        self.study.runs().begins(&x)
    }

    /// Settings and inputs of the run of a segment.
    fn given<'py>(&self, py: Python<'py>, place: usize, x: Vec<f64>) -> (Values, BySignal<'py>) {
        let runs = self.study.runs();
        let Given { settings, inputs } = runs.given(place, &runs.point(&x));
        (settings, inputs.into_iter().map(|(name, course)| (name, Array1::from(course).into_pyarray(py))).collect())
    }

    /// Variables of the model at the communication points of each segment.
    fn recorded<'py>(&self, py: Python<'py>, x: Vec<f64>, outputs: Vec<String>) -> PyResult<Vec<Vec<Vector<'py>>>> {
        let names: Vec<&str> = outputs.iter().map(String::as_str).collect();
        let every = self.abreast(py, |simulated| {
            let (runs, point) = (&simulated.runs, simulated.runs.point(&x));
            simulated.by_segment(|place, goes_on| {
                let given = runs.given(place, &point);
                runs.recorded(place, &given, &names, TOLERANCE, goes_on).outputs
            })
        })?;
        let told = |courses: Vec<Vec<f64>>| courses.into_iter().map(|course| course.into_pyarray(py)).collect();
        Ok(every.into_iter().map(told).collect())
    }

    /// Solver steps that no run should take more than.
    fn limit(&self, py: Python<'_>) -> PyResult<f64> {
        let bounded = self.watched(py, &Stage::default(), |threads| self.study.clone().bounded(threads))?;
        bounded.map(|study| study.most).map_err(|Interrupted| refused("interrupted"))
    }

    /// Why a vector cannot be simulated; nothing if it can be.
    fn refusal(&self, x: Vec<f64>) -> Option<String> {
        self.study.runs().refusal(&x, TOLERANCE).map(|why| why.0)
    }

    /// Measured minus simulated values of a vector at all samples, for each segment by signal; NaN where a run failed.
    fn differences<'py>(&self, py: Python<'py>, x: Vec<f64>) -> PyResult<Vec<BySignal<'py>>> {
        let every = self.abreast(py, |simulated| {
            let (runs, point) = (&simulated.runs, simulated.runs.point(&x));
            simulated.by_segment(|place, goes_on| runs.differences(place, &point, TOLERANCE, goes_on))
        })?;
        let compared = self.study.experiment.compared();
        let by_signal = |signals: Vec<Vec<f64>>| {
            let pair = |(name, course): (&&'static str, Vec<f64>)| (*name, Array1::from(course).into_pyarray(py));
            compared.iter().zip(signals).map(pair).collect()
        };
        Ok(every.into_iter().map(by_signal).collect())
    }

    /// Measured minus simulated values of vectors, of shape (vectors, samples), at fitted samples or at those of validation data:
    /// segment by segment, in it signal by signal.
    fn stacked<'py>(&self, py: Python<'py>, vectors: Vec<Vec<f64>>, is_validation: bool) -> PyResult<Matrix<'py>> {
        let rows = self.abreast(py, |it| it.stacked(&vectors, TOLERANCE, is_validation))?;
        PyArray2::from_vec2(py, &rows).map_err(refused)
    }

    /// [`refine`], as accurately as for a search that another one continues.
    fn refine<'py>(&self, py: Python<'py>, start: Vec<f64>, loss: &str) -> PyResult<Found<'py>> {
        let loss = loss_of(loss)?;
        Ok(told(py, self.with(py, |problem| refine(problem, &start, loss, ROUGH, &Unwatched))?))
    }

    /// [`scattered`].
    fn scattered<'py>(&self, py: Python<'py>, number: usize, seed: u64) -> PyResult<Vec<Vector<'py>>> {
        let found = self.with(py, |problem| Ok(scattered(problem, number, seed)))?;
        Ok(found.into_iter().map(|x| Array1::from(x).into_pyarray(py)).collect())
    }

    /// Sums of the squares of the residuals of vectors.
    fn costs(&self, py: Python<'_>, vectors: Vec<Vec<f64>>) -> PyResult<Vec<f64>> {
        self.with(py, |problem| search::costs(problem, &vectors))
    }

    /// Derivatives of the differences, and the differences; with `of_residuals` derivatives of the residuals.
    fn sensitivities<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        is_central: bool,
        of_residuals: bool,
    ) -> PyResult<(Matrix<'py>, Vector<'py>)> {
        let (slopes, base) = self.with(py, |problem| {
            let base = problem.simulated.differences(std::slice::from_ref(&x), TOLERANCE)?.swap_remove(0);
            let of = if of_residuals { jacobian } else { sensitivities };
            Ok((of(problem, &x, &base, TOLERANCE, is_central)?, base))
        })?;
        Ok((matrix(py, slopes), Array1::from(base).into_pyarray(py)))
    }

    /// [`causes::causes`] of what is fixed, of RMS residuals beside the noises of the sensors. `units` are the machine's, by the name of
    /// a parameter or by the SI unit that they replace.
    fn causes(
        &self,
        py: Python<'_>,
        x: Vec<f64>,
        units: BTreeMap<String, String>,
        residuals: Vec<(f64, f64)>,
    ) -> PyResult<Vec<CauseParts>> {
        let is_noise = causes::is_quiet(residuals);
        let mut candidates = candidates(&self.study.runs());
        for one in candidates.settings.iter_mut().chain(&mut candidates.sensors) {
            one.unit = units.get(&one.name).or_else(|| units.get(&one.unit)).unwrap_or(&one.unit).clone();
        }
        if is_noise && !candidates.has_clock {
            return Ok(vec![]);
        }
        let found = self.watched(py, &Stage::default(), |threads| {
            let study = self.study.clone().bounded(threads)?;
            let simulated = study.simulation(threads);
            causes::causes(&simulated, &candidates, &study.problem(&simulated), &x, is_noise)
        })?;
        let found = found.map_err(|Interrupted| refused("interrupted"))?;
        Ok(found.into_iter().map(|cause| of_cause(cause, &candidates)).collect())
    }

    /// Choices that may be causes: name, fixed item, and the others.
    fn choices(&self) -> Vec<(String, String, Vec<String>)> {
        let choices = candidates(&self.study.runs()).choices;
        choices.into_iter().map(|one| (one.name, one.fixed, one.others)).collect()
    }

    /// [`cross_validate`] over conditions: of each its quantity, its name, and the places of its segments. Its progress goes to
    /// `watch`, as that of a search.
    fn cross_validate<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        groups: Vec<(String, String, Vec<usize>)>,
        loss: &str,
        law_error: f64,
        watch: Py<PyAny>,
    ) -> PyResult<Vec<LeftOut<'py>>> {
        let group = |(quantity, name, segments)| Group { quantity, name, segments };
        let groups: Vec<Group> = groups.into_iter().map(group).collect();
        let (loss, watch) = (loss_of(loss)?, Observer::new(Some(watch), 0.0));
        let found = self.watched(py, &Stage::default(), |workers| {
            cross_validate(&self.study, &x, &groups, loss, law_error, workers, &watch)
        })?;
        let told = |Case { others, asked, rms, friction }: Case| {
            let [others, asked] = [others, asked].map(|x| Array1::from(x).into_pyarray(py));
            (others, asked, rms, friction.map(|Friction { predicted, measured, spread }| (predicted, measured, spread)))
        };
        let found = found.map_err(|Interrupted| watch.raised().unwrap_or_else(|| refused("interrupted")))?;
        Ok(found.into_iter().map(told).collect())
    }

    /// Lower and upper ends of intervals, correlations, and why the data do not determine a parameter. Ends come from the Jacobian, by
    /// profile, or from draws of the bootstrap.
    #[pyo3(signature = (x, method, seed, draws=1000))]
    fn certainty<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        method: &str,
        seed: u64,
        draws: usize,
    ) -> PyResult<Certain<'py>> {
        let of = |ends| self.with(py, |problem| intervals::certainty(problem, &x, ends));
        let sure = match method {
            "jacobian" => of(Ends::Jacobian)?,
            "bootstrap" => of(Ends::Bootstrap(seed, draws))?,
            "profile" => {
                let found = self.watched(py, &Stage::default(), |workers| profile(&self.study, &x, workers))?;
                found.map_err(|Interrupted| refused("interrupted"))?
            }
            _ => {
                return Err(refused(format!(
                    "intervals = {method} is refused: it must be jacobian, profile or bootstrap"
                )));
            }
        };
        let (runs, names) =
            (self.study.runs(), self.study.ties.iter().map(|tie| tie.name.as_str()).collect::<Vec<_>>());
        let tied = intervals::tied(&runs.parameters, &names, &|x| runs.values(x), &x, &sure);
        let Certainty { intervals, correlation, reasons } = sure;
        let [low, high] =
            [0, 1].map(|end| intervals.iter().map(|ends| ends[end]).collect::<Array1<f64>>().into_pyarray(py));
        let named = self.study.parameters.iter().zip(reasons);
        let reasons = named.filter_map(|(one, reason)| Some((one.name.clone(), reason?))).collect();
        Ok((low, high, matrix(py, correlation), reasons, tied))
    }

    /// Parameters whose values have run to a bound, and the bounds.
    fn at_bounds(&self, x: Vec<f64>) -> Vec<(String, f64)> {
        let parameters = &self.study.parameters;
        let named = |(place, bound): (usize, f64)| (parameters[place].name.clone(), bound);
        intervals::at_bounds(parameters, &x).into_iter().map(named).collect()
    }

    /// [`intervals::linearised`].
    fn linearised<'py>(&self, py: Python<'py>, x: Vec<f64>) -> PyResult<Linearised<'py>> {
        let Linear { derivatives, scores, blocks, records } =
            self.with(py, |problem| intervals::linearised(problem, &x))?;
        Ok((matrix(py, derivatives), Array1::from(scores).into_pyarray(py), blocks, records))
    }
}

impl LeastSquares {
    /// Does something with a simulator on threads, while this one waits for an interrupt.
    fn watched<T: Send>(
        &self,
        py: Python<'_>,
        stage: &Stage,
        work: impl FnOnce(&Threads<'_>) -> T + Send,
    ) -> PyResult<T> {
        let pool = pool(self.workers)?;
        let threads = Threads { pool: &pool, stage, underivable: &self.underivable };
        let (found, ended) = py.detach(|| watched(stage, crate::watch::Watch::new(None), || work(&threads)));
        ended.map(|()| found)
    }

    /// Does something with the simulation.
    fn abreast<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Simulation<'_>) -> Result<T, Interrupted> + Send,
    ) -> PyResult<T> {
        let found = self.watched(py, &Stage::default(), |threads| work(&self.study.simulation(threads)))?;
        found.map_err(|Interrupted| refused("interrupted"))
    }

    /// Does something with the problem.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Problem<'_>) -> Result<T, Interrupted> + Send,
    ) -> PyResult<T> {
        self.abreast(py, |simulated| work(&self.study.problem(simulated)))
    }

    /// Lets a function of Python search from several starts, with one thread for each of its tasks.
    fn elsewhere(
        &self,
        py: Python<'_>,
        solver: &Py<PyAny>,
        study: &Study,
        starts: usize,
        stage: &Arc<Stage>,
    ) -> PyResult<(Solution, bool)> {
        let own = Self { study: study.clone(), texts: self.texts.clone(), workers: 1, underivable: Mutex::default() };
        let stage = Arc::clone(stage);
        let is_halted = PyCFunction::new_closure(py, None, None, move |_, _| stage.is_halted())?;
        let found = solver.call1(py, (own, starts, is_halted))?;
        let (x, cost, converged, message, is_interrupted): (Vec<f64>, _, _, _, _) = found.extract(py)?;
        Ok((Solution { x, cost, converged, message }, is_interrupted))
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

/// Threads, while the one that Python waits in looks for an interrupt.
struct Threads<'a> {
    pool: &'a rayon::ThreadPool,
    stage: &'a Stage,
    underivable: &'a Mutex<Underivable>,
}

impl Workers for Threads<'_> {
    fn each(&self, count: usize, work: &Task<'_>) -> Result<(), Interrupted> {
        let goes_on = |_| !self.stage.is_halted();
        self.pool.install(|| (0..count).into_par_iter().for_each(|place| work(place, &goes_on)));
        if self.stage.is_halted() { Err(Interrupted) } else { Ok(()) }
    }

    fn underivable(&self, mut names: Underivable) {
        self.underivable.lock().expect("no thread has panicked").append(&mut names);
    }
}

/// An object of Python that hears of a search, and what it has raised.
struct Observer {
    watch: Option<Py<PyAny>>,
    /// Interval in s at which it is told of vectors.
    every: f64,
    seen: Mutex<Seen>,
    raised: Mutex<Option<PyErr>>,
}

/// Vectors that nobody has been told of yet.
struct Seen {
    number: usize,
    least: f64,
    told: Option<Instant>,
}

impl Observer {
    fn new(watch: Option<Py<PyAny>>, every: f64) -> Self {
        let seen = Seen { number: 0, least: f64::INFINITY, told: None };
        Self { watch, every, seen: Mutex::new(seen), raised: Mutex::default() }
    }

    fn keep<T>(&self, called: PyResult<T>) -> Result<T, Interrupted> {
        called.map_err(|raised| {
            self.raised.lock().expect("no thread has panicked").get_or_insert(raised);
            Interrupted
        })
    }

    /// What it has raised.
    fn raised(&self) -> Option<PyErr> {
        self.raised.lock().expect("no thread has panicked").take()
    }

    fn tell<A: for<'py> pyo3::call::PyCallArgs<'py> + Send>(&self, method: &str, told: A) -> Result<(), Interrupted> {
        if self.raised.lock().expect("no thread has panicked").is_some() {
            return Err(Interrupted);
        }
        let Some(watch) = &self.watch else { return Ok(()) };
        self.keep(Python::attach(|py| watch.call_method1(py, method, told))).map(drop)
    }
}

impl Watch for Observer {
    fn see(&self, _: &[f64], _: &Values, mean_square: f64) -> Result<(), Interrupted> {
        let mut seen = self.seen.lock().expect("no thread has panicked");
        (seen.number, seen.least) = (seen.number + 1, seen.least.min(mean_square));
        if self.watch.is_none() || seen.told.is_some_and(|told| told.elapsed().as_secs_f64() < self.every) {
            return self.raised.lock().expect("no thread has panicked").as_ref().map_or(Ok(()), |_| Err(Interrupted));
        }
        let (number, least) = (seen.number, seen.least);
        *seen = Seen { number: 0, least: f64::INFINITY, told: Some(Instant::now()) };
        drop(seen);
        self.tell("see", (mean_square, least, number))
    }

    // What these raise ends the search at the next vector.
    fn stage(&self, text: &str) {
        self.seen.lock().expect("no thread has panicked").least = f64::INFINITY;
        let _ = self.tell("stage", (text,));
    }

    fn done(&self, text: &str) {
        let _ = self.tell("done", (text,));
    }

    fn hidden(&self, names: &[String]) {
        let _ = self.tell("hidden", (names.to_vec(),));
    }
}

fn outcome(py: Python<'_>, reached: Reached, is_interrupted: bool, workers: usize) -> Outcome<'_> {
    let Reached { study, fitted, best, other_form, .. } = reached;
    let options = study.experiment.given().options;
    Outcome {
        options: (options.length, options.inputs.map(Inputs::name), options.smoothing),
        parameters: limits(&study.parameters),
        begins: study.segments.iter().map(|segment| segment.begin.values.clone()).collect(),
        sensors: [&study, &fitted].map(|study| study.sensors.iter().map(noise_of).collect()),
        choices: choices_of(&fitted, workers),
        best: best.map(|best| told(py, best)),
        notes: study.notes,
        other_form: other_form.map(|cause| of_cause(cause, &candidates(&fitted.runs()))),
        is_interrupted,
    }
}

fn of_cause(
    Cause { name, text, estimate, item, signal, share, gain, alike, is_sensor }: Cause,
    candidates: &Candidates,
) -> CauseParts {
    let mut numbers = candidates.settings.iter().chain(&candidates.sensors);
    let (start, unit) = numbers.find(|one| one.name == name).map_or((1.0, "1"), |one| (one.start, &one.unit));
    let (fixed, estimate) = match (estimate, candidates.choices.iter().find(|choice| choice.name == name), item) {
        (None, Some(choice), Some(item)) => (Fixed::Item(choice.fixed.clone()), Estimated::Item(item)),
        (estimate, ..) => {
            let (value, [low, high]) = estimate.unwrap_or((f64::NAN, [f64::NAN; 2]));
            (Fixed::Number(start), Estimated::Number((value, low, high, unit.to_owned())))
        }
    };
    (name, text, fixed, estimate, signal, share, gain, alike, is_sensor)
}

fn choices_of(study: &Study, workers: usize) -> Choices {
    let Study { step, scale, exactness, most, is_exact, .. } = *study;
    Choices { step, scale, exactness, most: most.is_finite().then_some(most), workers, is_exact }
}

fn limits(parameters: &[Parameter]) -> Vec<(f64, f64, f64)> {
    parameters.iter().map(|one| (one.start, one.bounds[0], one.bounds[1])).collect()
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

/// A parameter with a start and bounds that the user gives.
#[pyfunction]
pub fn given_parameter(one: Free, start: Option<f64>, bounds: Option<[f64; 2]>) -> PyResult<Free> {
    parameter(one).given(start, bounds).map(free).map_err(|why| refused(why.0))
}

/// A number that only expressions use.
#[pyfunction]
pub fn number(name: &str, start: f64) -> Free {
    free(Parameter::of_number(name, start))
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

/// [`series::joint`].
#[pyfunction]
pub fn joint<'py>(
    py: Python<'py>,
    problems: Vec<Py<LeastSquares>>,
    alone: Vec<Vec<f64>>,
    common: usize,
) -> PyResult<Together<'py>> {
    let every: Vec<&LeastSquares> = problems.iter().map(Py::get).collect();
    let found = every[0].watched(py, &Stage::default(), |workers| {
        let simulations: Vec<Simulation<'_>> = every.iter().map(|one| one.study.simulation(workers)).collect();
        let pairs = every.iter().zip(&simulations);
        let problems: Vec<Problem<'_>> = pairs.map(|(one, simulation)| one.study.problem(simulation)).collect();
        series::joint(&problems, &alone, common)
    })?;
    let Joint { vectors, converged, halves, p } = found.map_err(|Interrupted| refused("interrupted"))?;
    Ok((vectors.into_iter().map(|x| Array1::from(x).into_pyarray(py)).collect(), converged, halves, p))
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

/// Slopes of the parabolas about each of equidistant samples.
#[pyfunction]
pub fn slopes<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    step: f64,
    width: f64,
) -> PyResult<Vector<'py>> {
    Ok(Array1::from(smoothing::parabolas(values.as_slice()?, step, width).1).into_pyarray(py))
}

fn plain(values: &PyReadonlyArray1<'_, f64>) -> Vec<f64> {
    values.as_array().to_vec()
}

fn sensor((noise, step, is_coarse): Noise) -> Sensor {
    Sensor { noise, step, is_coarse }
}

fn noise_of(sensor: &Sensor) -> Noise {
    (sensor.noise, sensor.step, sensor.is_coarse)
}

fn parameter((name, unit, start, low, high, scale, is_given, is_bounded, least, most): Free) -> Parameter {
    Parameter { name, unit, start, bounds: [low, high], scale, is_given, is_bounded, legal: [least, most] }
}

/// A parameter as Python takes it.
pub fn free(Parameter { name, unit, start, bounds, scale, is_given, is_bounded, legal }: Parameter) -> Free {
    (name, unit, start, bounds[0], bounds[1], scale, is_given, is_bounded, legal[0], legal[1])
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
