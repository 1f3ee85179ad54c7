//! Many plants of one model that are stepped together, for learning and for predictive control.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1};
use pneumatic_servo::model::Plant;
use pneumatic_servo::model::Setup;
use pneumatic_servo::sensitivity::{Transition, TransitionError};
use pneumatic_servo::variables::{Place, Variable};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use rayon::prelude::*;

use crate::failure::{refused, refused_setting, refused_value, stopped};
use crate::model::Model;
use crate::recording::places;
use crate::simulation::SavedState;
use crate::threads::pool;
use crate::transition::{Asked, TransitionParts, transition_error_of};
use crate::value::{Setting, apply, setup};

/// Plants of one model with one driven input, stepped together.
#[pyclass(frozen)]
pub struct Fleet {
    setup: Setup,
    input: (usize, &'static Variable),
    observed: Vec<Place>,
    /// The places among the computed variables of those that are observed, if all of them are computed.
    computed: Option<Vec<usize>>,
    /// The threads that step them; the one that asks does if they are not to be several.
    pool: Option<rayon::ThreadPool>,
    plants: Mutex<Vec<Plant>>,
    /// Whether the next steps begin with the last plant. Plants that do not fit into a cache together are stepped there and
    /// back, so that those come first that are still in it.
    backwards: AtomicBool,
}

#[pymethods]
impl Fleet {
    /// A number of plants, all started alike.
    #[new]
    fn new(
        model: &Model,
        number: usize,
        settings: Vec<Setting>,
        input: &str,
        observed: Vec<String>,
        workers: usize,
    ) -> PyResult<Self> {
        let setup = setup(model.model, &settings)?;
        let table = setup.table();
        let entry = table.find(input).ok_or_else(|| refused(format!("there is no variable {input}")))?;
        let Place::Input(place) = entry.place else { return Err(refused(format!("{input} is not an input"))) };
        let observed = places(table, &observed)?;
        if observed.is_empty() {
            return Err(refused("no variable is to be observed"));
        }
        let computed = |place: &Place| if let Place::Computed(place) = place { Some(*place) } else { None };
        let computed = observed.iter().map(computed).collect();
        let plants: Result<Vec<_>, _> = (0..number).map(|_| setup.start(0.0)).collect();
        let plants = Mutex::new(plants.map_err(refused_value)?);
        let pool = (workers != 1).then(|| pool(workers)).transpose()?;
        let (input, backwards) = ((place, entry.variable), AtomicBool::new(false));
        Ok(Self { setup, input, observed, computed, pool, plants, backwards })
    }

    /// Starts some plants anew at time 0, each with settings of its own on top of the common ones.
    fn restart(&self, py: Python<'_>, fresh: Vec<(usize, Vec<Setting>)>) -> PyResult<()> {
        let mut plants = self.plants(py);
        for (index, settings) in fresh {
            let mut setup = self.setup.clone();
            apply(&mut setup, &settings).map_err(refused_setting)?;
            plants[index] = setup.start(0.0).map_err(refused_value)?;
        }
        Ok(())
    }

    /// Everything that affects the further run of each plant.
    fn save(&self, py: Python<'_>) -> Vec<SavedState> {
        self.plants(py).iter_mut().map(|plant| SavedState(plant.save())).collect()
    }

    /// Goes back to a saved state of each plant, which was restarted with the same settings.
    fn restore(&self, py: Python<'_>, states: Vec<PyRef<'_, SavedState>>) -> PyResult<()> {
        let mut plants = self.plants(py);
        if states.len() != plants.len() {
            return Err(refused(format!("{} states for {} plants", states.len(), plants.len())));
        }
        plants.iter_mut().zip(&states).try_for_each(|(plant, state)| plant.restore(&state.0).map_err(refused))
    }

    /// Sets another input of each plant, until it is set anew.
    fn set(&self, py: Python<'_>, input: &str, values: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let values = values.as_slice()?;
        let entry = self.setup.table().find(input).ok_or_else(|| refused(format!("there is no variable {input}")))?;
        let Place::Input(place) = entry.place else { return Err(refused(format!("{input} is not an input"))) };
        let mut plants = self.plants(py);
        if values.len() != plants.len() {
            return Err(refused(format!("{} values for {} plants", values.len(), plants.len())));
        }
        plants.iter_mut().zip(values).try_for_each(|(plant, value)| plant.set_input(place, *value)).map_err(refused)
    }

    /// The observed variables of all plants, `[plant, variable]`.
    fn observe<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let mut plants = self.plants(py);
        let width = self.observed.len();
        let (mut seen, mut room) = (vec![0.0; plants.len() * width], self.room());
        for (plant, row) in plants.iter_mut().zip(seen.chunks_mut(width)) {
            self.look(plant, &mut room, row);
        }
        self.array(py, plants.len(), seen)
    }

    /// Sets the input of each plant, makes steps of a size in s with it, and returns what is then observed.
    fn step<'py>(
        &self,
        py: Python<'py>,
        inputs: PyReadonlyArray1<'py, f64>,
        size: f64,
        steps: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let inputs = inputs.as_slice()?;
        let mut plants = self.plants(py);
        let place = self.place(inputs, plants.len())?;
        let plants = &mut *plants;
        let width = self.observed.len();
        let mut seen = vec![0.0; plants.len() * width];
        let step = |room: &mut Vec<f64>, (index, ((plant, input), row)): (usize, ((&mut Plant, &f64), &mut [f64]))| {
            plant.set_input(place, *input).map_err(|error| format!("plant {index}: {error}"))?;
            for _ in 0..steps {
                plant.step(size).map_err(|error| format!("plant {index}: {error}"))?;
            }
            self.look(plant, room, row);
            Ok(())
        };
        let backwards = self.backwards.fetch_xor(true, Ordering::Relaxed);
        let outcome: Result<(), String> = py.detach(|| match &self.pool {
            None => {
                let mut work = plants.iter_mut().zip(inputs).zip(seen.chunks_mut(width)).enumerate();
                let mut room = self.room();
                if backwards {
                    work.rev().try_for_each(|it| step(&mut room, it))
                } else {
                    work.try_for_each(|it| step(&mut room, it))
                }
            }
            Some(pool) => pool.install(|| {
                let rows = seen.par_chunks_mut(width);
                let work = plants.par_iter_mut().zip(inputs.par_iter()).zip(rows).enumerate().with_min_len(16);
                if backwards {
                    work.rev().try_for_each_init(|| self.room(), step)
                } else {
                    work.try_for_each_init(|| self.room(), step)
                }
            }),
        });
        outcome.map_err(stopped)?;
        Ok(self.array(py, plants.len(), seen))
    }

    /// What these steps would do to small changes: of each plant a transition for each step. All plants stay where they are.
    fn transitions<'py>(
        &self,
        py: Python<'py>,
        inputs: PyReadonlyArray1<'py, f64>,
        size: f64,
        steps: usize,
        parameters: Vec<String>,
        outputs: Vec<String>,
    ) -> PyResult<Vec<Vec<TransitionParts<'py>>>> {
        let inputs = inputs.as_slice()?;
        let mut plants = self.plants(py);
        let place = self.place(inputs, plants.len())?;
        let (plants, asked) = (&mut *plants, Asked { parameters, outputs });
        let made = |(plant, input): (&mut Plant, &f64)| {
            let saved = plant.save();
            plant.set_input(place, *input).expect("a legal value");
            let made: Result<Vec<_>, _> = (0..steps).map(|_| asked.of(plant, size)).collect();
            plant.restore(&saved).expect("a state of its own");
            made
        };
        let made: Vec<_> = py.detach(|| match &self.pool {
            None => plants.iter_mut().zip(inputs).map(made).collect(),
            Some(pool) => pool.install(|| plants.par_iter_mut().zip(inputs.par_iter()).map(made).collect()),
        });
        let width = self.setup.table().inputs().count();
        let tell = |(index, made): (usize, Result<Vec<Transition>, TransitionError>)| {
            let made = made.map_err(|error| transition_error_of("plant", index, error))?;
            Ok(made.into_iter().map(|transition| asked.tell(py, transition, width)).collect())
        };
        made.into_iter().enumerate().map(tell).collect()
    }
}

impl Fleet {
    /// The plants, by a thread that holds the interpreter.
    fn plants<'a>(&'a self, py: Python<'a>) -> MutexGuard<'a, Vec<Plant>> {
        self.plants.lock_py_attached(py).unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// The place of the driven input, of which there is a legal value for each of a number of plants.
    fn place(&self, inputs: &[f64], plants: usize) -> PyResult<usize> {
        if inputs.len() != plants {
            return Err(refused(format!("{} inputs for {plants} plants", inputs.len())));
        }
        let (place, variable) = self.input;
        inputs.iter().try_for_each(|value| variable.check(*value)).map_err(refused)?;
        Ok(place)
    }

    /// Room for the computed variables of a plant: one for many, since each plant's own would be fetched from memory.
    fn room(&self) -> Vec<f64> {
        vec![0.0; self.setup.table().computed().count()]
    }

    /// Writes the observed variables of a plant to a row; the room serves those that are not at hand.
    fn look(&self, plant: &mut Plant, room: &mut [f64], row: &mut [f64]) {
        if self.computed.as_ref().is_some_and(|places| plant.simulation().at_hand(places, row)) {
            return;
        }
        plant.simulation().values(room);
        for (slot, place) in row.iter_mut().zip(&self.observed) {
            *slot = if let Place::Computed(place) = place { room[*place] } else { plant.value(*place) };
        }
    }

    fn array<'py>(&self, py: Python<'py>, number: usize, seen: Vec<f64>) -> Bound<'py, PyArray2<f64>> {
        let array =
            Array2::from_shape_vec((number, self.observed.len()), seen).expect("one slot per plant and variable");
        array.into_pyarray(py)
    }
}
