//! Closed loops of a plant and a controller, a model of the library or an FMU, which run side by side without a step through
//! Python.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;

use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray2, PyArray3};
use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::variables::{Place, SettingError};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::{refused, refused_at, refused_setting, refused_value, room};
use crate::fmu::{self, Fmu};
use crate::many::{Courses, Signals, Stage, signals, told, watched};
use crate::model::Model;
use crate::recording::{Driven, Grid, Log, Logged, Noticed, Reached, place, places, started};
use crate::signal::Reader;
use crate::simulation::Simulation;
use crate::threads::pool;
use crate::value::{Given, Setting, apply, setup};
use crate::watch::{STEPS_PER_LOOK, Watch};

/// A controller before it takes its first sample.
trait Controller: Sync {
    /// A controller that runs.
    type Running: Send;
    /// Where it has a variable.
    type Spot: Copy + Send + Sync;

    /// The place of a variable.
    fn spot(&self, name: &str) -> PyResult<Self::Spot>;

    /// Starts with values of inputs, at the time 0 s of its own and one in s of the plant's.
    fn begin(&self, inputs: Vec<(&str, f64)>, time: f64) -> PyResult<Self::Running>;

    /// Sets an input, at a time in s of the plant's.
    fn set(running: &mut Self::Running, input: (&str, Self::Spot), value: f64, time: f64) -> PyResult<()>;

    /// Takes a step of a size in s; tells why it cannot.
    fn step(running: &mut Self::Running, size: f64) -> Result<(), String>;

    /// The value of a variable.
    fn value(running: &mut Self::Running, spot: Self::Spot) -> PyResult<f64>;

    /// What it warns of.
    fn warnings(_running: &mut Self::Running) -> Vec<String> {
        Vec::new()
    }

    /// As Python takes it.
    fn given_back(py: Python<'_>, running: Self::Running) -> PyResult<Py<PyAny>>;
}

/// A model of the library as a controller.
impl Controller for Setup {
    type Running = Plant;
    type Spot = Place;

    fn spot(&self, name: &str) -> PyResult<Place> {
        place(self.table(), name)
    }

    fn begin(&self, inputs: Vec<(&str, f64)>, time: f64) -> PyResult<Plant> {
        let mut setup = self.clone();
        for (name, value) in inputs {
            change_at(&mut setup, name, value, time)?;
        }
        setup.start(0.0).map_err(refused_value)
    }

    fn set(running: &mut Plant, (name, spot): (&str, Place), value: f64, time: f64) -> PyResult<()> {
        let Place::Input(input) = spot else { return Err(refused(format!("{name} is not an input"))) };
        running.set_input(input, value).map_err(|error| refused_at(error, time))
    }

    fn step(running: &mut Plant, size: f64) -> Result<(), String> {
        running.step(size).map_err(|error| error.to_string())
    }

    fn value(running: &mut Plant, spot: Place) -> PyResult<f64> {
        Ok(running.value(spot))
    }

    fn given_back(py: Python<'_>, running: Plant) -> PyResult<Py<PyAny>> {
        Ok(Py::new(py, Simulation::new(running))?.into_any())
    }
}

/// An FMU as a controller, with the settings that it starts with.
impl Controller for (Fmu, Vec<Setting>) {
    type Running = fmu::Running;
    type Spot = fmu::Spot;

    fn spot(&self, name: &str) -> PyResult<fmu::Spot> {
        self.0.spot(name)
    }

    fn begin(&self, inputs: Vec<(&str, f64)>, _time: f64) -> PyResult<fmu::Running> {
        let inputs = inputs.into_iter().map(|(name, value)| Setting { name: name.into(), given: Given::Number(value) });
        let settings: Vec<Setting> = self.1.iter().cloned().chain(inputs).collect();
        self.0.begin(&settings, 0.0)
    }

    fn set(running: &mut fmu::Running, (name, spot): (&str, fmu::Spot), value: f64, _time: f64) -> PyResult<()> {
        running.put(name, spot, value)
    }

    fn step(running: &mut fmu::Running, size: f64) -> Result<(), String> {
        running.step(size)
    }

    fn value(running: &mut fmu::Running, spot: fmu::Spot) -> PyResult<f64> {
        running.value(spot)
    }

    fn warnings(running: &mut fmu::Running) -> Vec<String> {
        running.take_warnings()
    }

    fn given_back(py: Python<'_>, running: fmu::Running) -> PyResult<Py<PyAny>> {
        Ok(Py::new(py, fmu::FmuSimulation::new(running))?.into_any())
    }
}

/// Changes a value that a plant or a controller starts with at a time in s of the plant's.
fn change_at(setup: &mut Setup, name: &str, value: f64, time: f64) -> PyResult<()> {
    setup.change(name, value).map_err(|error| match error {
        SettingError::Refused(error) => refused_at(error, time),
        other => refused_setting(other),
    })
}

/// What all runs share.
struct Loop<'a, C: Controller> {
    plant: Setup,
    runs: Vec<Vec<Setting>>,
    controller: C,
    /// Inputs of the plant over time.
    inputs: Vec<(String, Signals<'a>)>,
    /// Inputs of the controller alone over time.
    own: Vec<(C::Spot, String, Signals<'a>)>,
    grid: Grid,
    /// Period of the controller in s and in steps, and steps from a sample until it acts.
    sampling: (f64, usize, usize),
    /// Variables of the plant that are inputs of the controller.
    measured: Vec<(Place, C::Spot, String)>,
    /// Variables of the controller that are inputs of the plant.
    driven: Vec<(C::Spot, usize, String)>,
    outputs: Vec<Place>,
    /// Recorded variables of the controller.
    noted: Vec<C::Spot>,
    /// Counters of the solver that a single run logs.
    counters: Option<Vec<String>>,
}

/// A run, and what only a single one keeps.
struct Done<R> {
    reached: Reached,
    /// Smallest and largest value of each input of the plant.
    extremes: Vec<(f64, f64)>,
    /// Inputs of the plant over each step, step by step.
    history: Vec<f64>,
    controller: Option<R>,
    /// What the controller warns of.
    warnings: Vec<String>,
    refused: Option<PyErr>,
}

impl<R> Default for Done<R> {
    fn default() -> Self {
        Self {
            reached: Reached::default(),
            extremes: Vec::new(),
            history: Vec::new(),
            controller: None,
            warnings: Vec::new(),
            refused: None,
        }
    }
}

/// An input of the controller alone.
struct Own<'a, S> {
    input: (&'a str, S),
    reader: Reader<'a>,
}

impl<C: Controller> Loop<'_, C> {
    /// Makes a run and writes its rows; an error is a value that is refused.
    fn run(
        &self,
        index: usize,
        slots: &mut [f64],
        stage: &Stage,
        keeps: bool,
        done: &mut Done<C::Running>,
    ) -> PyResult<()> {
        let mut setup = self.plant.clone();
        apply(&mut setup, &self.runs[index]).map_err(refused_setting)?;
        let signals = self.inputs.iter().map(|(name, signals)| Ok((name, signals.of(index))));
        let mut inputs = Driven::all(setup.table(), signals)?;
        let own = self
            .own
            .iter()
            .map(|(spot, name, signals)| Own { input: (name, *spot), reader: Reader::new(name, signals.of(index)) });
        let mut own: Vec<_> = own.collect();
        done.extremes = vec![(f64::INFINITY, f64::NEG_INFINITY); setup.inputs().len()];
        // Until the first sample is taken, which the plant then starts with, as in a replay of the record.
        let mut plant = started(setup.clone(), &mut inputs, self.grid)?;
        done.reached.notice(&plant);
        let mut rows = Rows { outputs: &self.outputs, slots, rows: self.grid.rows() };
        let outcome = self.go((&mut plant, &setup), (&mut inputs, &mut own), &mut rows, stage, keeps, done);
        done.reached.end_log(&plant);
        if let Some(controller) = &mut done.controller {
            done.warnings = C::warnings(controller);
        }
        outcome
    }

    /// Takes a plant of a setup over the grid.
    fn go(
        &self,
        (plant, setup): (&mut Plant, &Setup),
        (inputs, own): (&mut [Driven<'_>], &mut [Own<'_, C::Spot>]),
        rows: &mut Rows<'_>,
        stage: &Stage,
        keeps: bool,
        done: &mut Done<C::Running>,
    ) -> PyResult<()> {
        let Self { grid, sampling: (period, samples, delay), .. } = *self;
        let mut noted = vec![f64::NAN; self.noted.len()];
        rows.read(plant, &noted, 0);
        done.reached.begin_log(plant);
        done.reached.count(plant);
        done.reached.rows = 1;
        // What the controller has set and does not act yet.
        let mut pending = VecDeque::with_capacity((delay / samples + 1) * self.driven.len());
        let mut due = delay;
        for step in 0..grid.count {
            if step % STEPS_PER_LOOK == 0 {
                if stage.is_halted() {
                    return Ok(());
                }
                if keeps {
                    stage.finished.store(step, Ordering::Relaxed);
                }
            }
            let point = grid.point(step);
            for input in &mut *inputs {
                let value = input.at(point)?;
                plant.set_input(input.place, value).map_err(|error| refused_at(error, point))?;
            }
            if step % samples == 0 {
                let controller = match &mut done.controller {
                    Some(controller) => controller,
                    none => none.insert(self.begin(plant, own, point)?),
                };
                for (from, to, name) in &self.measured {
                    C::set(controller, (name, *to), plant.value(*from), point)?;
                }
                for own in &mut *own {
                    C::set(controller, own.input, own.reader.at(point)?, point)?;
                }
                if let Err(failure) = C::step(controller, period) {
                    done.reached.failure = Some(failure);
                    return Ok(());
                }
                for (from, _, _) in &self.driven {
                    pending.push_back(C::value(controller, *from)?);
                }
                for (slot, spot) in noted.iter_mut().zip(&self.noted) {
                    *slot = C::value(controller, *spot)?;
                }
            }
            let acts = step == due;
            if acts {
                due += samples;
            }
            if step == 0 {
                let mut first = setup.clone();
                for input in &mut *inputs {
                    first.change(input.name(), input.at(point)?).map_err(refused_setting)?;
                }
                for ((_, _, name), value) in self.driven.iter().zip(&pending).filter(|_| acts) {
                    change_at(&mut first, name, *value, point)?;
                }
                *plant = first.start(grid.start).map_err(refused_value)?;
                rows.read(plant, &noted, 0);
                done.reached.begin_log(plant);
                done.reached.count(plant);
            }
            if acts {
                for (_, to, _) in &self.driven {
                    let value = pending.pop_front().expect("a value for each input that the controller sets");
                    plant.set_input(*to, value).map_err(|error| refused_at(error, point))?;
                }
            }
            for (place, (low, high)) in done.extremes.iter_mut().enumerate() {
                let value = plant.value(Place::Input(place));
                (*low, *high) = (low.min(value), high.max(value));
                if keeps {
                    done.history.push(value);
                }
            }
            // Each step ends at its point plus its size, as in runs without a controller.
            if let Err(error) = plant.step(point + grid.step - plant.time()) {
                done.history.truncate(step * done.extremes.len());
                done.reached.failure = Some(error.to_string());
                return Ok(());
            }
            if (step + 1) % grid.every == 0 || step + 1 == grid.count {
                rows.read(plant, &noted, done.reached.rows);
                done.reached.count(plant);
                done.reached.rows += 1;
            }
        }
        Ok(())
    }

    /// A controller that starts with the inputs of its first sample, at a time in s of the plant's.
    fn begin(&self, plant: &Plant, own: &mut [Own<'_, C::Spot>], time: f64) -> PyResult<C::Running> {
        let mut inputs: Vec<(&str, f64)> =
            self.measured.iter().map(|(from, _, name)| (name.as_str(), plant.value(*from))).collect();
        for own in own {
            inputs.push((own.input.0, own.reader.at(time)?));
        }
        self.controller.begin(inputs, time)
    }

    /// Makes all runs on a number of threads; a single one may keep more.
    fn run_all(
        &self,
        pool: &rayon::ThreadPool,
        slots: &mut [f64],
        stage: &Stage,
        keeps: bool,
    ) -> Vec<Done<C::Running>> {
        let size = (self.outputs.len() + self.noted.len()) * self.grid.rows();
        let make = |(index, slots): (usize, &mut [f64])| {
            let mut done = Done::default();
            if let Some(counters) = self.counters.as_deref().filter(|_| keeps) {
                done.reached.log = Log::new(self.plant.table(), counters).ok();
            }
            let outcome = self.run(index, slots, stage, keeps, &mut done);
            if !keeps {
                done.controller = None;
                stage.finished.fetch_add(1, Ordering::Relaxed);
            }
            match outcome {
                Err(error) if keeps => done.refused = Some(error),
                Err(error) => done.reached.failure = Some(Python::attach(|py| error.value(py).to_string())),
                Ok(()) => (),
            }
            done
        };
        pool.install(|| slots.par_chunks_mut(size.max(1)).enumerate().map(make).collect())
    }
}

/// Rows of a run: the plant's outputs, then what is noted of the controller.
struct Rows<'a> {
    outputs: &'a [Place],
    slots: &'a mut [f64],
    rows: usize,
}

impl Rows<'_> {
    fn read(&mut self, plant: &Plant, noted: &[f64], row: usize) {
        let values = self.outputs.iter().map(|place| plant.value(*place)).chain(noted.iter().copied());
        for (output, value) in values.enumerate() {
            self.slots[output * self.rows + row] = value;
        }
    }
}

/// What only a single run keeps: inputs `[input, step]`, the controller, and the log of the solver if it is asked for.
type Kept<'py> = (Bound<'py, PyArray2<f64>>, Option<Py<PyAny>>, Option<Logged<'py>>);

/// Values `[run, output, row]`, for each run the rows recorded and why it stopped early, an exception that ended all, what was
/// noticed first of each variable, the smallest and largest value of each input of the plant, and what a single run keeps.
type Outcome<'py> = (
    Bound<'py, PyArray3<f64>>,
    Vec<(usize, Option<String>)>,
    Option<PyErr>,
    Vec<(usize, Noticed)>,
    Vec<(f64, f64)>,
    Option<Kept<'py>>,
);

/// The model of a controller.
#[derive(FromPyObject)]
pub enum Making<'py> {
    /// One of the library.
    Own(PyRef<'py, Model>),
    /// One in an FMU.
    Fmu(PyRef<'py, Fmu>),
}

/// A controller, its settings, its inputs over time, and the names of what it measures, sets and notes.
type ControllerArguments<'py> =
    (Making<'py>, Vec<Setting>, Vec<(String, Courses<'py>)>, Vec<String>, Vec<String>, Vec<String>);

/// A loop without its controller.
struct Plan<'py> {
    plant: Setup,
    runs: Vec<Vec<Setting>>,
    inputs: Vec<(String, Courses<'py>)>,
    own: Vec<(String, Courses<'py>)>,
    grid: Grid,
    sampling: (f64, usize, usize),
    names: [Vec<String>; 3],
    outputs: Vec<Place>,
    workers: usize,
    progress: Option<Py<PyAny>>,
    keeps: bool,
    counters: Option<Vec<String>>,
}

/// Runs a model in a closed loop as often as there are lists in `runs`, whose settings come on top of `settings`; `keeps` and
/// `counters` of the solver are for a single run.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python package calls it, and names them")]
pub fn simulate_closed<'py>(
    py: Python<'py>,
    model: &Model,
    settings: Vec<Setting>,
    runs: Vec<Vec<Setting>>,
    inputs: Vec<(String, Courses<'py>)>,
    controller: ControllerArguments<'py>,
    sampling: (f64, usize, usize),
    grid: (f64, f64, usize, usize),
    outputs: Vec<String>,
    workers: usize,
    progress: Option<Py<PyAny>>,
    keeps: bool,
    counters: Option<Vec<String>>,
) -> PyResult<Outcome<'py>> {
    let (making, own_settings, own, measured, driven, noted) = controller;
    let plant = setup(model.model, &settings)?;
    let (grid, names) = (Grid::from(grid), [measured, driven, noted]);
    let outputs = places(plant.table(), &outputs)?;
    let plan = Plan { plant, runs, inputs, own, grid, sampling, names, outputs, workers, progress, keeps, counters };
    match making {
        Making::Own(model) => plan.run(py, setup(model.model, &own_settings)?),
        Making::Fmu(fmu) => plan.run(py, (fmu.clone(), own_settings)),
    }
}

impl Plan<'_> {
    /// Makes the runs with a controller.
    fn run<C: Controller>(self, py: Python<'_>, controller: C) -> PyResult<Outcome<'_>> {
        let Self { plant, runs, grid, sampling, names: [measured, driven, noted], outputs, keeps, counters, .. } = self;
        let own = signals(&self.own)?.into_iter().map(|(name, signals)| Ok((controller.spot(&name)?, name, signals)));
        let measured = measured.into_iter().map(|name| {
            let from = place(plant.table(), &name)?;
            Ok((from, controller.spot(&name)?, name))
        });
        let driven = driven.into_iter().map(|name| match place(plant.table(), &name)? {
            Place::Input(to) => Ok((controller.spot(&name)?, to, name)),
            _ => Err(refused(format!("{name} is not an input"))),
        });
        let of_loop = Loop {
            inputs: signals(&self.inputs)?,
            own: own.collect::<PyResult<_>>()?,
            measured: measured.collect::<PyResult<_>>()?,
            driven: driven.collect::<PyResult<_>>()?,
            noted: noted.iter().map(|name| controller.spot(name)).collect::<PyResult<_>>()?,
            plant,
            runs,
            grid,
            sampling,
            outputs,
            controller,
            counters,
        };
        let (number, rows) = (of_loop.runs.len(), of_loop.grid.rows());
        let width = of_loop.outputs.len() + of_loop.noted.len();
        let mut slots = room(width, rows, number)?;
        let (pool, stage, watch) = (pool(self.workers)?, Stage::default(), Watch::new(self.progress));
        let (mut done, ended) =
            py.detach(|| watched(&stage, watch, || of_loop.run_all(&pool, &mut slots, &stage, keeps)));
        let mut extremes = vec![(f64::INFINITY, f64::NEG_INFINITY); of_loop.plant.inputs().len()];
        for of_run in &done {
            for ((low, high), (least, most)) in extremes.iter_mut().zip(&of_run.extremes) {
                (*low, *high) = (low.min(*least), high.max(*most));
            }
        }
        let mut warnings: Vec<String> = Vec::new();
        for warning in done.iter_mut().flat_map(|of_run| std::mem::take(&mut of_run.warnings)) {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        fmu::tell(py, warnings)?;
        let (mut refused, mut kept) = (None, None);
        if let ([only], true) = (&mut done[..], keeps) {
            let (inputs, history) = (extremes.len(), std::mem::take(&mut only.history));
            let steps = history.len() / inputs.max(1);
            let history = Array2::from_shape_vec((steps, inputs), history).expect("a value per step and input");
            let history = history.reversed_axes().as_standard_layout().into_owned();
            let log = only.reached.log.take().map(|log| log.tell(py));
            let controller = only.controller.take().map(|controller| C::given_back(py, controller)).transpose()?;
            kept = Some((history.into_pyarray(py), controller, log));
            refused = only.refused.take();
        }
        let reached: Vec<Reached> = done.into_iter().map(|of_run| of_run.reached).collect();
        let (reached, noticed) = told(reached);
        let values = Array3::from_shape_vec((number, width, rows), slots).expect("one slot per run, output and row");
        Ok((values.into_pyarray(py), reached, refused.or(ended.err()), noticed, extremes, kept))
    }
}
