//! Steps of many simulations side by side.

use pneumatic_servo::sensitivity::{Transition, TransitionError};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::refused;
use crate::simulation::{Simulation, end_of};
use crate::threads::pool;
use crate::transition::{Asked, Told, untold_of};

/// Steps of a size in s of many simulations, each of which is another one, on a number of threads: what each does to small changes.
#[pyfunction]
pub fn transitions<'py>(
    py: Python<'py>,
    simulations: Vec<Py<Simulation>>,
    size: f64,
    parameters: Vec<String>,
    outputs: Vec<String>,
    workers: usize,
) -> PyResult<Vec<Told<'py>>> {
    let ends: PyResult<Vec<f64>> = simulations.iter().map(|it| end_of(&it.get().plant(py), size)).collect();
    let work: Vec<(&Simulation, f64)> = simulations.iter().map(Py::get).zip(ends?).collect();
    if let Some(index) =
        (0..work.len()).find(|it| work[..*it].iter().any(|(other, _)| std::ptr::eq(*other, work[*it].0)))
    {
        return Err(refused(format!("simulation {index} is given twice")));
    }
    let (asked, pool) = (Asked { parameters, outputs }, pool(workers)?);
    let made = |(simulation, end): &(&Simulation, f64)| {
        let mut plant = simulation.locked();
        (asked.of(&mut plant, *end), plant.table().inputs().count())
    };
    let made: Vec<_> = py.detach(|| pool.install(|| work.par_iter().map(made).collect()));
    let tell = |(index, (outcome, inputs)): (usize, (Result<Transition, TransitionError>, usize))| {
        Ok(asked.tell(py, outcome.map_err(|error| untold_of("simulation", index, error))?, inputs))
    };
    made.into_iter().enumerate().map(tell).collect()
}
