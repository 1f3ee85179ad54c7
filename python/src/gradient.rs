//! Gradients and tangents of whole runs.

use numpy::ndarray::{Array2, ArrayView2};
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pneumatic_servo::model::{Plant, Steps};
use pneumatic_servo::sensitivity::TransitionError;
use pneumatic_servo::variables::Place;
use pyo3::prelude::*;

use crate::failure::{refused, transition_error};
use crate::model::Model;
use crate::recording::{Driven, Grid, started};
use crate::single::Course;
use crate::value::{Setting, setup};
use crate::watch::Watch;

/// By inputs `[input, step]` in the order of the table, by states with their names, and by parameters.
type GradientParts<'py> = (Bound<'py, PyArray2<f64>>, Vec<(String, f64)>, Vec<f64>);

/// A run that can be made again and again.
struct Again {
    plant: Plant,
    grid: Grid,
    ends: Vec<f64>,
    inputs: Vec<Vec<f64>>,
}

/// How the sum of outputs times cotangents `[output, row]` changes; the arguments before are the same as of `simulate`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the arguments of `simulate` and two more")]
pub fn gradient<'py>(
    py: Python<'py>,
    model: &Model,
    settings: Vec<Setting>,
    inputs: Vec<(String, Course<'py>)>,
    grid: (f64, f64, usize, usize),
    outputs: Vec<String>,
    cotangents: PyReadonlyArray2<'py, f64>,
    parameters: Vec<String>,
) -> PyResult<GradientParts<'py>> {
    let mut again = Again::new(model, &settings, &inputs, grid.into())?;
    let (rows, every, last) = (again.grid.rows(), again.grid.every, again.grid.count);
    let weights = shaped("cotangents", cotangents.as_array(), [outputs.len(), rows])?;
    let [by, of] = [&parameters, &outputs].map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
    let weight = |index: usize, output: usize| match index % every {
        0 => weights[[output, index / every]],
        _ if index == last => weights[[output, rows - 1]],
        _ => 0.0,
    };
    let found = again.watched(|plant, steps, go_on| plant.gradient(steps, &by, &of, weight, go_on))?;
    let shape = (again.plant.table().inputs().count(), again.grid.count);
    let of_inputs = Array2::from_shape_fn(shape, |(input, step)| found.inputs[step][input]);
    Ok((of_inputs.into_pyarray(py), found.states, found.parameters))
}

/// How outputs `[output, row]` change along a direction: of all inputs `[input, step]`, in the order of the table, and of
/// parameters.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the arguments of `simulate` and two more")]
pub fn tangent<'py>(
    py: Python<'py>,
    model: &Model,
    settings: Vec<Setting>,
    inputs: Vec<(String, Course<'py>)>,
    grid: (f64, f64, usize, usize),
    outputs: Vec<String>,
    of_inputs: PyReadonlyArray2<'py, f64>,
    of_parameters: Vec<(String, f64)>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let mut again = Again::new(model, &settings, &inputs, grid.into())?;
    let count = again.plant.table().inputs().count();
    let (rows, every, last) = (again.grid.rows(), again.grid.every, again.grid.count);
    let added = shaped("tangents of the inputs", of_inputs.as_array(), [count, again.grid.count])?;
    let (by, seeds): (Vec<&str>, Vec<f64>) = of_parameters.iter().map(|(name, seed)| (name.as_str(), *seed)).unzip();
    let of: Vec<&str> = outputs.iter().map(String::as_str).collect();
    let seed = |step: usize, input: usize| added[[input, step]];
    let found = again.watched(|plant, steps, go_on| plant.tangent(steps, (&by, &seeds), &of, seed, go_on))?;
    Ok(Array2::from_shape_fn((of.len(), rows), |(output, row)| found[(row * every).min(last)][output]).into_pyarray(py))
}

fn shaped<'a>(what: &str, given: ArrayView2<'a, f64>, expected: [usize; 2]) -> PyResult<ArrayView2<'a, f64>> {
    if given.shape() == expected {
        return Ok(given);
    }
    Err(refused(format!("the {what} have the shape {:?}, not {expected:?}", given.shape())))
}

impl Again {
    /// A run with the arguments of `simulate`.
    fn new(model: &Model, settings: &[Setting], inputs: &[(String, Course)], grid: Grid) -> PyResult<Self> {
        let setup = setup(model.model, settings)?;
        let signals = inputs.iter().map(|(name, course)| Ok((name, course.signal()?)));
        let mut driven = Driven::all(setup.table(), signals)?;
        let plant = started(setup, &mut driven, grid)?;
        let number = plant.table().inputs().count();
        let mut values: Vec<f64> = (0..number).map(|place| plant.value(Place::Input(place))).collect();
        let mut all = Vec::with_capacity(grid.count);
        for index in 0..grid.count {
            for input in &mut driven {
                values[input.place] = input.at(grid.point(index))?;
            }
            all.push(values.clone());
        }
        let ends = (0..grid.count).map(|index| grid.point(index) + grid.step).collect();
        Ok(Self { plant, grid, ends, inputs: all })
    }

    /// Does something that takes long, and ends on an interrupt.
    fn watched<T>(
        &mut self,
        work: impl FnOnce(&mut Plant, Steps, &mut dyn FnMut() -> bool) -> Result<Option<T>, TransitionError>,
    ) -> PyResult<T> {
        let (mut watch, mut ended) = (Watch::new(None), None);
        let mut go_on = || {
            ended = watch.look(0).err();
            ended.is_none()
        };
        let steps = Steps { ends: &self.ends, inputs: &self.inputs };
        let found = work(&mut self.plant, steps, &mut go_on).map_err(transition_error)?;
        found.ok_or_else(|| ended.unwrap_or_else(|| refused("interrupted")))
    }
}
