//! A running plant, step by step.

use crc::{CRC_32_ISO_HDLC, Crc};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pneumatic_servo::co_simulation::Direction;
use pneumatic_servo::model::{self, Plant, Saved, TrimError};
use pneumatic_servo::variables::{Kind, Place};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyBytes;
use std::sync::{Mutex, MutexGuard};

use crate::failure::{refused, refused_setting, stopped, transition_error};
use crate::recording::Noticed;
use crate::recording::places;
use crate::transition::{Asked, TransitionParts};
use crate::value::{Given, Setting, seconds};

/// A running plant.
#[pyclass(frozen, subclass)]
pub struct Simulation {
    plant: Mutex<Plant>,
}

/// A saved state.
#[pyclass(frozen)]
pub struct SavedState(pub Saved);

/// Finds bytes that were changed or cut off.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

#[pymethods]
impl SavedState {
    /// The state as bytes, for a file or another process.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &postcard::to_allocvec_crc32(&self.0, CRC.digest()).expect("a state holds plain data"))
    }

    /// The state of such bytes.
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        let state = postcard::from_bytes_crc32(bytes, CRC.digest()).map_err(|_| {
            refused(format!("these {} bytes are no state saved by this version of pneumatic-servo", bytes.len()))
        })?;
        Ok(Self(state))
    }
}

impl Simulation {
    /// A plant that has been started.
    pub fn new(plant: Plant) -> Self {
        Self { plant: Mutex::new(plant) }
    }

    /// The plant, by a thread that holds the interpreter.
    pub fn plant<'a>(&'a self, py: Python<'a>) -> MutexGuard<'a, Plant> {
        // A plant that has panicked would still be whole; it never does.
        self.plant.lock_py_attached(py).unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// The plant, by a thread that does not hold the interpreter.
    pub fn locked(&self) -> MutexGuard<'_, Plant> {
        self.plant.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

#[pymethods]
impl Simulation {
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.plant(py).time()
    }

    /// Sets inputs and tunable parameters one after the other; on an error none of them is.
    fn set(&self, py: Python<'_>, settings: Vec<Setting>) -> PyResult<()> {
        let mut plant = self.plant(py);
        all_or_none(&mut plant, &settings, |plant, setting| {
            plant.set(&setting.name, setting.given.value()).map_err(refused_setting)
        })
    }

    /// Sets one input or tunable parameter.
    fn set_one(&self, py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.plant(py).set(name, Given::of(name, value)?.value()).map_err(refused_setting)
    }

    /// The value of one variable.
    fn get(&self, py: Python<'_>, name: &str) -> PyResult<f64> {
        self.plant(py).get(name).map_err(refused)
    }

    /// Integrates over a step of a size in s, or with its unit.
    fn step(&self, py: Python<'_>, size: &Bound<'_, PyAny>) -> PyResult<()> {
        let size = seconds(size)?;
        let mut plant = self.plant(py);
        check_step(&plant, size)?;
        let plant = &mut *plant;
        py.detach(|| plant.step(size)).map_err(stopped)
    }

    /// The same, and what the step does to small changes.
    fn transition<'py>(
        &self,
        py: Python<'py>,
        size: f64,
        parameters: Vec<String>,
        outputs: Vec<String>,
    ) -> PyResult<TransitionParts<'py>> {
        let mut plant = self.plant(py);
        check_step(&plant, size)?;
        let asked = Asked { parameters, outputs };
        let plant = &mut *plant;
        let transition = py.detach(|| asked.of(plant, size)).map_err(transition_error)?;
        Ok(asked.tell(py, transition, plant.table().inputs().count()))
    }

    /// Logs the events from here on.
    fn log_events(&self, py: Python<'_>) {
        self.plant(py).log_events();
    }

    /// Times in s and names of the events that are logged.
    fn logged_events(&self, py: Python<'_>) -> Vec<(f64, &'static str)> {
        self.plant(py).logged_events()
    }

    /// What is unusual about the parameters and the present inputs: variable, value and remark.
    fn notices(&self, py: Python<'_>) -> Vec<Noticed> {
        self.plant(py).notices().map(Noticed::from).collect()
    }

    /// Everything that affects the further run.
    fn save(&self, py: Python<'_>) -> SavedState {
        SavedState(self.plant(py).save())
    }

    /// Goes back to a saved state.
    fn restore(&self, py: Python<'_>, saved: &SavedState) -> PyResult<()> {
        self.plant(py).restore(&saved.0).map_err(refused)
    }

    /// The names of the continuous states that are integrated.
    fn states(&self, py: Python<'_>) -> Vec<String> {
        self.plant(py).states().map(|variable| variable.name.clone()).collect()
    }

    /// Moves continuous states; on an error none of them is moved.
    fn move_states(&self, py: Python<'_>, states: Vec<Setting>) -> PyResult<()> {
        let mut plant = self.plant(py);
        all_or_none(&mut plant, &states, |plant, state| plant.move_state(&state.name, state.number()?).map_err(refused))
    }

    /// Moves a plant that has just been started to an operating point of given states, of which some inputs are given and others
    /// free; tells why there is none.
    fn trim(
        &self,
        py: Python<'_>,
        states: Vec<(String, f64)>,
        inputs: Vec<String>,
        free: Vec<String>,
    ) -> PyResult<Option<String>> {
        let states: Vec<(&str, f64)> = states.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        let [inputs, free] = [&inputs, &free].map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
        let mut plant = self.plant(py);
        let plant = &mut *plant;
        match py.detach(|| plant.trim(model::Given { states: &states, inputs: &inputs, free: &free })) {
            Ok(()) => Ok(None),
            Err(TrimError::Setting(error)) => Err(refused_setting(error)),
            Err(error) => Ok(Some(error.to_string())),
        }
    }

    /// Partial derivatives of computed variables (rows) with respect to states and inputs (columns).
    fn jacobian<'py>(&self, py: Python<'py>, of: Vec<String>, to: Vec<String>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let plant = self.plant(py);
        let table = plant.table();
        let rows = places(table, &of)?;
        let mut inputs = vec![0.0; table.inputs().count()];
        let mut states = vec![0.0; table.number_of_states()];
        let mut computed = vec![0.0; table.computed().count()];
        let mut matrix = Array2::zeros((of.len(), to.len()));
        for (column, name) in to.iter().enumerate() {
            let entry = table.find(name).ok_or_else(|| refused(format!("there is no variable {name}")))?;
            if entry.variable.kind == Kind::Boolean {
                return Err(refused(format!("{name} is true or false, and nothing can be differentiated by it")));
            }
            let seed = match (entry.state, entry.place) {
                (Some(state), _) => &mut states[state],
                (None, Place::Input(input)) => &mut inputs[input],
                _ => return Err(refused(format!("{name} is neither a continuous state nor an input"))),
            };
            *seed = 1.0;
            let direction = Direction { time: 0.0, inputs: &inputs, states: &states, parameters: &[] };
            plant.simulation().directional_derivative(direction, &mut computed);
            states.fill(0.0);
            inputs.fill(0.0);
            for (row, place) in rows.iter().enumerate() {
                let Place::Computed(place) = place else {
                    return Err(refused(format!("{} is not computed", of[row])));
                };
                matrix[[row, column]] = computed[*place];
            }
        }
        Ok(matrix.into_pyarray(py))
    }
}

/// Checks that a step of a size in s moves the time of a run, which counts from its start.
///
/// # Errors
/// `ValueError` if it leads nowhere.
pub fn check_step(plant: &Plant, size: f64) -> PyResult<()> {
    let moves = |time: f64| size.is_finite() && time + size > time;
    if moves(plant.time()) || moves(plant.simulation().elapsed()) {
        return Ok(());
    }
    Err(refused(format!("a step of {size} s leads nowhere from {} s", plant.time())))
}

/// Applies settings one after the other; on an error the plant is as it was.
fn all_or_none(
    plant: &mut Plant,
    settings: &[Setting],
    apply: impl Fn(&mut Plant, &Setting) -> PyResult<()>,
) -> PyResult<()> {
    // What is refused alone has changed nothing.
    let saved = (settings.len() > 1).then(|| plant.save());
    let outcome = settings.iter().try_for_each(|setting| apply(plant, setting));
    if let (Err(_), Some(saved)) = (&outcome, saved) {
        plant.restore(&saved).expect("the state is the plant's own");
    }
    outcome
}
