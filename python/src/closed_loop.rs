//! Closed loops of a plant and a controller of the library, which run side by side without a step through Python.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;

use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray2, PyArray3};
use pneumatic_servo::model::{Plant, Setup};
use pneumatic_servo::variables::{Place, SettingError};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::{refused_at, refused_setting, refused_value, room};
use crate::many::{Courses, Signals, Stage, signals, told, watched};
use crate::model::Model;
use crate::recording::{Driven, Grid, Log, Logged, Noticed, Reached, places, started};
use crate::simulation::Simulation;
use crate::threads::pool;
use crate::value::{Setting, apply, setup};
use crate::watch::{STEPS_PER_LOOK, Watch};

/// A connection: a place that is read in one model, and an input that is set in the other.
struct Wire {
    from: Place,
    name: String,
    to: usize,
}

/// What all runs share.
struct Loop<'a> {
    plant: Setup,
    runs: Vec<Vec<Setting>>,
    controller: Setup,
    /// Inputs of the plant, and of the controller, over time.
    inputs: Vec<(String, Signals<'a>)>,
    own: Vec<(String, Signals<'a>)>,
    grid: Grid,
    /// Period of the controller in s and in steps, and steps from a sample until it acts.
    sampling: (f64, usize, usize),
    measured: Vec<Wire>,
    driven: Vec<Wire>,
    outputs: Vec<Place>,
    /// Recorded variables of the controller.
    noted: Vec<Place>,
    /// Counters of the solver that a single run logs.
    counters: Option<Vec<String>>,
}

/// A run, and what only a single one keeps.
#[derive(Default)]
struct Done {
    reached: Reached,
    /// Smallest and largest value of each input of the plant.
    extremes: Vec<(f64, f64)>,
    /// Inputs of the plant over each step, step by step.
    history: Vec<f64>,
    controller: Option<Plant>,
    refused: Option<PyErr>,
}

impl Wire {
    /// Connects the variables of one model with the inputs of the same names of another.
    fn all(names: &[String], from: &Setup, to: &Setup) -> PyResult<Vec<Self>> {
        let (from, inputs) = (places(from.table(), names)?, places(to.table(), names)?);
        let wires = names.iter().zip(from.into_iter().zip(inputs));
        let input = |(name, (from, to)): (&String, (Place, Place))| match to {
            Place::Input(to) => Some(Self { from, name: name.clone(), to }),
            _ => None,
        };
        Ok(wires.filter_map(input).collect())
    }

    /// Reads the variable in one model and sets the input in the other, at a time in s.
    fn carry(&self, from: &Plant, to: &mut Plant, time: f64) -> PyResult<()> {
        to.set_input(self.to, from.value(self.from)).map_err(|error| refused_at(error, time))
    }
}

/// The courses of inputs for one of many runs.
fn driven<'a>(setup: &Setup, inputs: &'a [(String, Signals<'a>)], run: usize) -> PyResult<Vec<Driven<'a>>> {
    Driven::all(setup.table(), inputs.iter().map(|(name, signals)| Ok((name, signals.of(run)))))
}

impl Loop<'_> {
    /// Makes a run and writes its rows; an error is a value that is refused.
    fn run(&self, index: usize, slots: &mut [f64], stage: &Stage, keeps: bool, done: &mut Done) -> PyResult<()> {
        let mut setup = self.plant.clone();
        apply(&mut setup, &self.runs[index]).map_err(refused_setting)?;
        let mut inputs = driven(&setup, &self.inputs, index)?;
        let mut own = driven(&self.controller, &self.own, index)?;
        done.extremes = vec![(f64::INFINITY, f64::NEG_INFINITY); setup.inputs().len()];
        // Until the first sample is taken, which the plant then starts with, as in a replay of the record.
        let mut plant = started(setup.clone(), &mut inputs, self.grid)?;
        done.reached.notice(&plant);
        let mut rows = Rows { outputs: &self.outputs, slots, rows: self.grid.rows() };
        let outcome = self.go((&mut plant, &setup), (&mut inputs, &mut own), &mut rows, stage, keeps, done);
        done.reached.end_log(&plant);
        outcome
    }

    /// Takes a plant of a setup over the grid.
    fn go(
        &self,
        (plant, setup): (&mut Plant, &Setup),
        (inputs, own): (&mut [Driven<'_>], &mut [Driven<'_>]),
        rows: &mut Rows<'_>,
        stage: &Stage,
        keeps: bool,
        done: &mut Done,
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
                for wire in &self.measured {
                    wire.carry(plant, controller, point)?;
                }
                for input in &mut *own {
                    let value = input.at(point)?;
                    controller.set_input(input.place, value).map_err(|error| refused_at(error, point))?;
                }
                if let Err(error) = controller.step(period) {
                    done.reached.failure = Some(error.to_string());
                    return Ok(());
                }
                pending.extend(self.driven.iter().map(|wire| controller.value(wire.from)));
                noted.iter_mut().zip(&self.noted).for_each(|(slot, place)| *slot = controller.value(*place));
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
                for (wire, value) in self.driven.iter().zip(&pending).filter(|_| acts) {
                    first.change(&wire.name, *value).map_err(|error| match error {
                        SettingError::Refused(error) => refused_at(error, point),
                        other => refused_setting(other),
                    })?;
                }
                *plant = first.start(grid.start).map_err(refused_value)?;
                rows.read(plant, &noted, 0);
                done.reached.begin_log(plant);
                done.reached.count(plant);
            }
            if acts {
                for wire in &self.driven {
                    let value = pending.pop_front().expect("a value for each input that the controller sets");
                    plant.set_input(wire.to, value).map_err(|error| refused_at(error, point))?;
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

    /// A controller that starts with the inputs of its first sample.
    fn begin(&self, plant: &Plant, own: &mut [Driven<'_>], time: f64) -> PyResult<Plant> {
        let mut setup = self.controller.clone();
        for wire in &self.measured {
            setup.change(&wire.name, plant.value(wire.from)).map_err(refused_setting)?;
        }
        for input in own {
            setup.change(input.name(), input.at(time)?).map_err(refused_setting)?;
        }
        setup.start(0.0).map_err(refused_value)
    }

    /// Makes all runs on a number of threads; a single one may keep more.
    fn run_all(&self, pool: &rayon::ThreadPool, slots: &mut [f64], stage: &Stage, keeps: bool) -> Vec<Done> {
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
type Kept<'py> = (Bound<'py, PyArray2<f64>>, Option<Simulation>, Option<Logged<'py>>);

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

/// The model of a controller, its settings, its inputs over time, and the names of what it measures, sets and notes.
type Controller<'py> =
    (PyRef<'py, Model>, Vec<Setting>, Vec<(String, Courses<'py>)>, Vec<String>, Vec<String>, Vec<String>);

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
    controller: Controller<'py>,
    sampling: (f64, usize, usize),
    grid: (f64, f64, usize, usize),
    outputs: Vec<String>,
    workers: usize,
    progress: Option<Py<PyAny>>,
    keeps: bool,
    counters: Option<Vec<String>>,
) -> PyResult<Outcome<'py>> {
    let (of_controller, own_settings, own, measured, driven, noted) = controller;
    let (plant, controller) = (setup(model.model, &settings)?, setup(of_controller.model, &own_settings)?);
    let of_loop = Loop {
        inputs: signals(&inputs)?,
        own: signals(&own)?,
        grid: Grid::from(grid),
        sampling,
        measured: Wire::all(&measured, &plant, &controller)?,
        driven: Wire::all(&driven, &controller, &plant)?,
        outputs: places(plant.table(), &outputs)?,
        noted: places(controller.table(), &noted)?,
        plant,
        runs,
        controller,
        counters,
    };
    let (number, rows) = (of_loop.runs.len(), of_loop.grid.rows());
    let width = of_loop.outputs.len() + of_loop.noted.len();
    let mut slots = room(width, rows, number)?;
    let (pool, stage, watch) = (pool(workers)?, Stage::default(), Watch::new(progress));
    let (mut done, ended) = py.detach(|| watched(&stage, watch, || of_loop.run_all(&pool, &mut slots, &stage, keeps)));
    let mut extremes = vec![(f64::INFINITY, f64::NEG_INFINITY); of_loop.plant.inputs().len()];
    for of_run in &done {
        for ((low, high), (least, most)) in extremes.iter_mut().zip(&of_run.extremes) {
            (*low, *high) = (low.min(*least), high.max(*most));
        }
    }
    let (mut refused, mut kept) = (None, None);
    if let ([only], true) = (&mut done[..], keeps) {
        let (inputs, history) = (extremes.len(), std::mem::take(&mut only.history));
        let steps = history.len() / inputs.max(1);
        let history = Array2::from_shape_vec((steps, inputs), history).expect("a value per step and input");
        let history = history.reversed_axes().as_standard_layout().into_owned();
        let log = only.reached.log.take().map(|log| log.tell(py));
        kept = Some((history.into_pyarray(py), only.controller.take().map(Simulation::new), log));
        refused = only.refused.take();
    }
    let reached: Vec<Reached> = done.into_iter().map(|of_run| of_run.reached).collect();
    let (reached, noticed) = told(reached);
    let values = Array3::from_shape_vec((number, width, rows), slots).expect("one slot per run, output and row");
    Ok((values.into_pyarray(py), reached, refused.or(ended.err()), noticed, extremes, kept))
}
