//! An observer of a plant.

use std::sync::{Mutex, MutexGuard};

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pneumatic_servo::model::{self, Method, Observed, ObserverError};
use pneumatic_servo::variables::Place;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use crate::failure::{refused_setting, refused_value, stopped};
use crate::model::Model;
use crate::recording::places;
use crate::value::{Setting, setup};

/// An observer, and the variables that it tells.
#[pyclass(frozen)]
pub struct Observer {
    observer: Mutex<model::Observer>,
    told: Vec<Place>,
}

impl Observer {
    fn observer<'a>(&'a self, py: Python<'a>) -> MutexGuard<'a, model::Observer> {
        self.observer.lock_py_attached(py).unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// Names and numbers.
type Named = Vec<(String, f64)>;

#[pymethods]
impl Observer {
    /// An observer of the variables that are measured; it tells its estimated quantities and others.
    #[new]
    fn new(
        model: &Model,
        settings: Vec<Setting>,
        measured: Named,
        period: f64,
        noise: (Named, Named),
        others: Vec<String>,
        is_unscented: bool,
    ) -> PyResult<Self> {
        let (process, initial) = noise;
        let [measured, process, initial] = [&measured, &process, &initial]
            .map(|list| list.iter().map(|(name, value)| (name.as_str(), *value)).collect::<Vec<_>>());
        let method = if is_unscented { Method::Unscented } else { Method::Extended };
        let observed = Observed { measured: &measured, period, process: &process, initial: &initial, method };
        let setup = setup(model.model, &settings)?;
        let observer = model::Observer::new(&setup, observed).map_err(|error| match error {
            ObserverError::Setting(error) => refused_setting(error),
            ObserverError::Parameter(error) => refused_value(error),
            other => crate::failure::refused(other),
        })?;
        let names: Vec<String> = observer.names().map(str::to_owned).chain(others).collect();
        let told = places(setup.table(), &names)?;
        Ok(Self { observer: Mutex::new(observer), told })
    }

    /// Names of the estimated states and inputs.
    fn names(&self, py: Python<'_>) -> Vec<&'static str> {
        self.observer(py).names().collect()
    }

    /// Goes a period on, and takes measurements in.
    fn update(&self, py: Python<'_>, inputs: Vec<f64>, measured: Vec<Option<f64>>) -> PyResult<()> {
        self.observer(py).update(&inputs, &measured).map_err(stopped)
    }

    /// The estimates of the variables that it tells.
    fn estimates(&self, py: Python<'_>) -> Vec<f64> {
        let observer = self.observer(py);
        self.told.iter().map(|place| observer.value(*place)).collect()
    }

    /// The standard deviations of these.
    fn deviations(&self, py: Python<'_>) -> Vec<f64> {
        let observer = self.observer(py);
        self.told.iter().map(|place| observer.deviation(*place)).collect()
    }

    /// The innovations, and the same in units of their deviations.
    fn innovation(&self, py: Python<'_>) -> (Vec<f64>, Vec<f64>) {
        let observer = self.observer(py);
        (observer.innovation().to_vec(), observer.whitened().to_vec())
    }

    /// The covariance of the estimated quantities.
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let observer = self.observer(py);
        let number = observer.names().count();
        Array2::from_shape_vec((number, number), observer.covariance()).expect("a square matrix").into_pyarray(py)
    }
}
