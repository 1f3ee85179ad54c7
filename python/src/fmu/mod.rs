//! FMUs 2.0 for co-simulation as models: what the Python package reads of an FMU's description, with its library.

mod library;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};

use library::{Answer, Instance, Kind, Library};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyBytes;

use crate::failure::{refused, stopped};
use crate::value::{Given, Setting, seconds};

/// What the interface lacks is in a module of the crate behind the FMU.
pub const OWN: &str = "a module of the crate behind the FMU has them: python_module! in docs/own-packing.md";

/// Value reference and kind of a variable, and numbers by the names of an enumeration's items.
type Described = (u32, String, HashMap<String, f64>);

/// A variable, as its library reads and sets it.
#[derive(Clone, Copy)]
pub struct Spot {
    reference: u32,
    kind: Kind,
}

struct Variable {
    spot: Spot,
    items: HashMap<String, f64>,
}

/// What all instances of an FMU share.
struct Shared {
    library: &'static Library,
    identifier: String,
    guid: String,
    resources: String,
    variables: HashMap<String, Variable>,
    states: Vec<String>,
}

/// An FMU with the library for this machine.
#[pyclass(frozen, skip_from_py_object)]
#[derive(Clone)]
pub struct Fmu {
    shared: Arc<Shared>,
}

#[pymethods]
impl Fmu {
    /// Loads a shared library; the resources are the URI of a folder.
    #[new]
    fn new(
        file: PathBuf,
        identity: (String, String, String),
        variables: HashMap<String, Described>,
        states: Vec<String>,
    ) -> PyResult<Self> {
        let library = Library::load(&file).map_err(refused)?;
        let (identifier, guid, resources) = identity;
        let variable = |(reference, kind, items): Described| {
            let kind = match kind.as_str() {
                "real" => Kind::Real,
                "boolean" => Kind::Boolean,
                _ => Kind::Integer,
            };
            Variable { spot: Spot { reference, kind }, items }
        };
        let variables = variables.into_iter().map(|(name, it)| (name, variable(it))).collect();
        Ok(Self { shared: Arc::new(Shared { library, identifier, guid, resources, variables, states }) })
    }

    /// Starts a run at a time in s.
    fn start(&self, py: Python<'_>, settings: Vec<Setting>, time: f64) -> PyResult<FmuSimulation> {
        let mut running = self.begin(&settings, time)?;
        tell(py, running.take_warnings())?;
        Ok(FmuSimulation::new(running))
    }
}

impl Fmu {
    /// An instance that is initialized with settings, at a time in s.
    ///
    /// # Errors
    /// `ValueError` with the FMU's own words.
    pub fn begin(&self, settings: &[Setting], time: f64) -> PyResult<Running> {
        let Shared { library, identifier, guid, resources, .. } = &*self.shared;
        let instance = Instance::new(library, identifier, guid, resources).map_err(refused)?;
        let mut running = Running { shared: self.shared.clone(), instance, time };
        settings.iter().try_for_each(|setting| running.set(setting))?;
        running.instance.initialize(time).map_err(refused)?;
        Ok(running)
    }

    /// A variable by its name.
    ///
    /// # Errors
    /// `ValueError` if there is none.
    pub fn spot(&self, name: &str) -> PyResult<Spot> {
        Ok(self.shared.find(name)?.spot)
    }
}

impl Shared {
    fn find(&self, name: &str) -> PyResult<&Variable> {
        self.variables.get(name).ok_or_else(|| {
            let names: Vec<&String> = self.variables.keys().collect();
            let similar = Python::attach(|py| {
                py.import("pneumatic_servo.names")?.call_method1("did_you_mean", (name, names))?.extract::<String>()
            });
            refused(format!("there is no variable {name}{}", similar.unwrap_or_default()))
        })
    }
}

/// An instance with its time.
pub struct Running {
    shared: Arc<Shared>,
    instance: Instance,
    /// Present time in s.
    time: f64,
}

impl Running {
    fn set(&mut self, Setting { name, given }: &Setting) -> PyResult<()> {
        let Variable { spot, items } = self.shared.find(name)?;
        let value = match given {
            Given::Number(value) => *value,
            Given::Flag(flag) => f64::from(*flag),
            Given::Item(item) => *items.get(item).ok_or_else(|| {
                let mut names: Vec<_> = items.iter().collect();
                names.sort_by(|one, other| one.1.total_cmp(other.1));
                let names: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
                let names = if names.is_empty() { "no words".into() } else { names.join(", ") };
                refused(format!("{name} = {item} is refused: it must be one of {names}"))
            })?,
        };
        let spot = *spot;
        self.put(name, spot, value)
    }

    /// Sets an input or a tunable parameter, which is named in what is refused.
    ///
    /// # Errors
    /// `ValueError`, with the FMU's own words where they are.
    pub fn put(&mut self, name: &str, spot: Spot, value: f64) -> PyResult<()> {
        if spot.kind != Kind::Real && f64::from(value as i32) != value {
            return Err(refused(format!("{name} = {value} is refused: it must be a whole number")));
        }
        self.instance.set(spot.kind, spot.reference, value).map_err(refused)
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// `ValueError` with the FMU's own words.
    pub fn value(&mut self, spot: Spot) -> PyResult<f64> {
        self.instance.get(spot.kind, spot.reference).map_err(refused)
    }

    /// Integrates over a step of a size in s.
    ///
    /// # Errors
    /// Why the FMU cannot go on.
    pub fn step(&mut self, size: f64) -> Answer<()> {
        self.instance.step(self.time, size)?;
        self.time += size;
        Ok(())
    }

    /// The warnings told since they were last taken.
    pub fn take_warnings(&mut self) -> Vec<String> {
        self.instance.take_warnings()
    }
}

/// Tells warnings of an FMU, whose texts begin with the function of the standard.
///
/// # Errors
/// The warning, where the user has made it an error.
pub fn tell(py: Python<'_>, warnings: Vec<String>) -> PyResult<()> {
    for text in warnings {
        let warning = text.split_once(": ").map_or(text.as_str(), |(_, warning)| warning);
        py.import("pneumatic_servo.errors")?.call_method1("warn", (warning,))?;
    }
    Ok(())
}

/// A saved state as the FMU serializes it.
#[pyclass(frozen)]
pub struct FmuState {
    bytes: Vec<u8>,
    time: f64,
}

#[pymethods]
impl FmuState {
    /// The state as bytes, which are of use to the FMU that has made them alone.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.bytes)
    }
}

/// A running FMU, step by step.
#[pyclass(frozen)]
pub struct FmuSimulation {
    running: Mutex<Running>,
}

impl FmuSimulation {
    /// A run that goes on.
    pub fn new(running: Running) -> Self {
        Self { running: Mutex::new(running) }
    }

    fn running<'a>(&'a self, py: Python<'a>) -> MutexGuard<'a, Running> {
        self.running.lock_py_attached(py).unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Does something with the run, and tells what it has warned of.
    fn with<R>(&self, py: Python<'_>, act: impl FnOnce(&mut Running) -> PyResult<R>) -> PyResult<R> {
        let mut running = self.running(py);
        let outcome = act(&mut running)?;
        let warnings = running.take_warnings();
        // What is told may run any code of the user's.
        drop(running);
        tell(py, warnings)?;
        Ok(outcome)
    }
}

#[pymethods]
impl FmuSimulation {
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.running(py).time
    }

    /// Sets inputs and tunable parameters one after the other; on an error none of them is.
    fn set(&self, py: Python<'_>, settings: Vec<Setting>) -> PyResult<()> {
        self.with(py, |running| {
            // What is refused alone has changed nothing.
            let saved = (settings.len() > 1).then(|| running.instance.save()).transpose().map_err(refused)?;
            let outcome = settings.iter().try_for_each(|setting| running.set(setting));
            if let (Err(_), Some(saved)) = (&outcome, saved) {
                running.instance.restore(&saved).map_err(refused)?;
            }
            outcome
        })
    }

    /// Sets one input or tunable parameter.
    fn set_one(&self, py: Python<'_>, name: String, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let given = Given::of(&name, value)?;
        self.with(py, |running| running.set(&Setting { name, given }))
    }

    /// The value of one variable.
    fn get(&self, py: Python<'_>, name: &str) -> PyResult<f64> {
        self.with(py, |running| match name {
            "time" => Ok(running.time),
            _ => {
                let spot = running.shared.find(name)?.spot;
                running.value(spot)
            }
        })
    }

    /// Integrates over a step of a size in s, or with its unit.
    fn step(&self, py: Python<'_>, size: &Bound<'_, PyAny>) -> PyResult<()> {
        let size = seconds(size)?;
        self.with(py, |running| {
            let time = running.time;
            if !(size.is_finite() && time + size > time) {
                return Err(refused(format!("a step of {size} s leads nowhere from {time} s")));
            }
            py.detach(|| running.step(size)).map_err(stopped)
        })
    }

    /// Nothing: an FMU warns through its logger.
    fn notices(&self) -> Vec<(String, f64, String)> {
        Vec::new()
    }

    /// Everything that affects the further run.
    fn save(&self, py: Python<'_>) -> PyResult<FmuState> {
        self.with(py, |running| Ok(FmuState { bytes: running.instance.save().map_err(refused)?, time: running.time }))
    }

    /// Goes back to a saved state.
    fn restore(&self, py: Python<'_>, saved: &Bound<'_, PyAny>) -> PyResult<()> {
        let saved = saved
            .cast::<FmuState>()
            .map_err(|_| PyTypeError::new_err("the state is none that a run of an FMU has saved"))?
            .get();
        self.with(py, |running| {
            running.instance.restore(&saved.bytes).map_err(refused)?;
            running.time = saved.time;
            Ok(())
        })
    }

    /// The names of all continuous states that the description lists.
    fn states(&self, py: Python<'_>) -> Vec<String> {
        self.running(py).shared.states.clone()
    }

    /// Partial derivatives of computed variables (rows) with respect to states and inputs (columns).
    fn jacobian<'py>(&self, py: Python<'py>, of: Vec<String>, to: Vec<String>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.with(py, |running| {
            let find = |name: &String| Ok(running.shared.find(name)?.spot.reference);
            let rows = of.iter().map(find).collect::<PyResult<Vec<_>>>()?;
            let columns = to.iter().map(find).collect::<PyResult<Vec<_>>>()?;
            let mut matrix = Array2::zeros((rows.len(), columns.len()));
            for (mut column, to) in matrix.columns_mut().into_iter().zip(columns) {
                let found = running.instance.derivatives(&rows, to).map_err(refused)?;
                column.iter_mut().zip(found).for_each(|(slot, value)| *slot = value);
            }
            Ok(matrix.into_pyarray(py))
        })
    }

    /// Refuses: an FMU for co-simulation integrates its states itself.
    fn move_states(&self, _states: Vec<Setting>) -> PyResult<()> {
        Err(refused(format!("states of an FMU for co-simulation cannot be moved; {OWN}")))
    }

    /// Refuses: the interface has none.
    fn transition(&self, _size: f64, _parameters: Vec<String>, _outputs: Vec<String>) -> PyResult<()> {
        Err(refused(format!("an FMU has no transitions; {OWN}")))
    }
}
