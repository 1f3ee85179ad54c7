//! Many runs of one model on all cores, each with the same bits as alone.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use pneumatic_servo::model::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::variables::{Notice, Place};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::{refused_setting, room, stopped};
use crate::model::Model;
use crate::recording::{Driven, Grid, Noticed, Reached, Rows, places, record};
use crate::signal::Signal;
use crate::threads::pool;
use crate::value::{Setting, apply, setup};
use crate::watch::{INTERVAL, STEPS_PER_LOOK, Watch};

/// What a solver has done by the variables of every model.
const COUNTERS: [&str; 2] = ["solver.steps", "solver.rejectedSteps"];

/// An input of all runs as the Python package hands it over.
#[derive(FromPyObject)]
pub enum Courses<'py> {
    /// One value for all runs.
    Constant(f64),
    /// One value per run.
    Constants(PyReadonlyArray1<'py, f64>),
    /// Times in s, and values `[run, time]`; a single row is for all runs.
    Table(PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>),
}

/// [`Courses`] without Python, for all threads.
pub enum Signals<'a> {
    /// One value for all runs.
    Constant(f64),
    /// One value per run.
    Constants(&'a [f64]),
    /// Points of one run after the other, or of all.
    Table {
        /// Times in s.
        times: &'a [f64],
        /// Values.
        values: &'a [f64],
    },
}

impl Courses<'_> {
    /// As all threads read them.
    pub fn signals(&self) -> PyResult<Signals<'_>> {
        Ok(match self {
            Self::Constant(value) => Signals::Constant(*value),
            Self::Constants(values) => Signals::Constants(values.as_slice()?),
            Self::Table(times, values) => Signals::Table { times: times.as_slice()?, values: values.as_slice()? },
        })
    }
}

/// Inputs as all threads read them.
pub fn signals<'a>(courses: &'a [(String, Courses<'_>)]) -> PyResult<Vec<(String, Signals<'a>)>> {
    courses.iter().map(|(name, courses)| Ok((name.clone(), courses.signals()?))).collect()
}

impl Signals<'_> {
    /// The input of one run.
    pub fn of(&self, run: usize) -> Signal<'_> {
        match *self {
            Self::Constant(value) => Signal::Constant(value),
            Self::Constants(values) => Signal::Constant(values[run]),
            Self::Table { times, values } => {
                let first = if values.len() == times.len() { 0 } else { run * times.len() };
                Signal::Table { times, values: &values[first..first + times.len()] }
            }
        }
    }
}

/// Everything the runs need, shared by all threads.
struct Plan<'a> {
    setup: Setup,
    runs: Vec<Vec<Setting>>,
    inputs: Vec<(String, Signals<'a>)>,
    grid: Grid,
    outputs: Vec<Place>,
    /// Solver steps, rejected ones included, after which a run is given up.
    most: Option<u64>,
    /// Where they are counted.
    counters: Vec<Place>,
}

/// How far work on other threads is.
#[derive(Default)]
pub struct Stage {
    /// Set when nothing is to go on.
    halted: AtomicBool,
    /// Finished parts.
    pub finished: AtomicUsize,
}

impl Stage {
    /// Whether nothing is to go on.
    pub fn is_halted(&self) -> bool {
        self.halted.load(Ordering::Relaxed)
    }
}

impl Plan<'_> {
    /// Makes one run; an error names what is wrong with it.
    fn run(&self, index: usize, slots: &mut [f64], stage: &Stage) -> Reached {
        let mut reached = Reached::default();
        let mut setup = self.setup.clone();
        let outcome = apply(&mut setup, &self.runs[index]).map_err(refused_setting).and_then(|()| {
            let signals = self.inputs.iter().map(|(name, signals)| Ok((name, signals.of(index))));
            let mut driven = Driven::all(setup.table(), signals)?;
            let rows = Rows { outputs: &self.outputs, slots, slopes: None };
            record(setup.clone(), &mut driven, self.grid, rows, &mut reached, |step, plant| {
                if step % STEPS_PER_LOOK != 0 {
                    return Ok(true);
                }
                self.limit(plant)?;
                Ok(!stage.is_halted())
            })
        });
        stage.finished.fetch_add(1, Ordering::Relaxed);
        let problem = outcome.err().map(|error| Python::attach(|py| error.value(py).to_string()));
        reached.failure = problem.or(reached.failure);
        reached
    }

    /// Refuses to go on with a plant that has taken too many solver steps.
    fn limit(&self, plant: &mut Plant) -> PyResult<()> {
        let Some(most) = self.most else { return Ok(()) };
        let steps: f64 = self.counters.iter().map(|counter| plant.value(*counter)).sum();
        if steps <= most as f64 {
            return Ok(());
        }
        Err(stopped(format!("at t = {} s the run was given up after {steps} solver steps of {most}", plant.time())))
    }

    /// Makes all runs on a number of threads.
    fn run_all(&self, pool: &rayon::ThreadPool, slots: &mut [f64], stage: &Stage) -> Vec<Reached> {
        let size = self.outputs.len() * self.grid.rows();
        pool.install(|| {
            slots.par_chunks_mut(size.max(1)).enumerate().map(|(index, slots)| self.run(index, slots, stage)).collect()
        })
    }
}

/// What `simulate_many` returns: values `[run, output, row]`, for each run the rows recorded and why it stopped early,
/// an exception that ended all of them, and what was noticed first of each variable, with the number of its run.
type Outcome<'py> = (Bound<'py, PyArray3<f64>>, Vec<(usize, Option<String>)>, Option<PyErr>, Vec<(usize, Noticed)>);

/// Runs a model as often as there are lists in `runs`, whose settings come on top of `settings`. A run of more than `most`
/// solver steps is given up. With `lines` inputs run on straight lines from each communication point to the next.
#[pyfunction]
#[pyo3(signature = (model, settings, runs, inputs, grid, outputs, workers, progress, most=None, lines=false))]
#[expect(clippy::too_many_arguments, reason = "the Python package calls it, and names them")]
pub fn simulate_many<'py>(
    py: Python<'py>,
    model: &Model,
    settings: Vec<Setting>,
    runs: Vec<Vec<Setting>>,
    inputs: Vec<(String, Courses<'py>)>,
    grid: (f64, f64, usize, usize),
    outputs: Vec<String>,
    workers: usize,
    progress: Option<Py<PyAny>>,
    most: Option<u64>,
    lines: bool,
) -> PyResult<Outcome<'py>> {
    let grid = Grid { has_lines: lines, ..Grid::from(grid) };
    let setup = setup(model.model, &settings)?;
    let outputs = places(setup.table(), &outputs)?;
    let inputs = signals(&inputs)?;
    let number = runs.len();
    let counters = most.map_or(Ok(Vec::new()), |_| places(setup.table(), &COUNTERS.map(String::from)))?;
    let plan = Plan { setup, runs, inputs, grid, outputs, most, counters };
    let mut slots = room(plan.outputs.len(), grid.rows(), number)?;
    let (pool, stage, watch) = (pool(workers)?, Stage::default(), Watch::new(progress));
    let (reached, ended) = py.detach(|| watched(&stage, watch, || plan.run_all(&pool, &mut slots, &stage)));
    let shape = (number, plan.outputs.len(), grid.rows());
    let values = Array3::from_shape_vec(shape, slots).expect("one slot per run, output and row");
    let (reached, noticed) = told(reached);
    Ok((values.into_pyarray(py), reached, ended.err(), noticed))
}

/// For each run the rows recorded and why it stopped early; and what was noticed first of each variable, with the number of its run.
type Endings = (Vec<(usize, Option<String>)>, Vec<(usize, Noticed)>);

/// The ends of runs as Python takes them.
pub fn told(runs: Vec<Reached>) -> Endings {
    let mut noticed: Vec<(usize, Notice)> = Vec::new();
    for (run, notice) in runs.iter().enumerate().flat_map(|(run, it)| it.noticed.iter().map(move |it| (run, *it))) {
        if noticed.iter().all(|(_, known)| known.variable != notice.variable) {
            noticed.push((run, notice));
        }
    }
    let noticed = noticed.into_iter().map(|(run, notice)| (run, notice.into())).collect();
    (runs.into_iter().map(|it| (it.rows, it.failure)).collect(), noticed)
}

/// Does work on other threads, while this one watches.
pub fn watched<R: Send>(stage: &Stage, mut watch: Watch, work: impl FnOnce() -> R + Send) -> (R, PyResult<()>) {
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        scope.spawn(move || sender.send(work()));
        let mut ended = Ok(());
        loop {
            if let Ok(done) = receiver.recv_timeout(INTERVAL) {
                let told = Python::attach(|py| watch.tell(py, stage.finished.load(Ordering::Relaxed)));
                return (done, ended.and(told));
            }
            if ended.is_ok() {
                ended = watch.look(stage.finished.load(Ordering::Relaxed));
                stage.halted.store(ended.is_err(), Ordering::Relaxed);
            }
        }
    })
}
