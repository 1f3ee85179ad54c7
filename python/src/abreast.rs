//! Steps of many simulations side by side.

use pneumatic_servo::sensitivity::{Transition, TransitionError};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::refused;
use crate::simulation::{Simulation, check_step};
use crate::threads::pool;
use crate::transition::{Asked, TransitionParts, transition_error_of};

/// Steps of a size in s of many simulations, each of which is another one, on a number of threads: what each does to small changes.
#[pyfunction]
pub fn transitions<'py>(
    py: Python<'py>,
    simulations: Vec<Py<Simulation>>,
    size: f64,
    parameters: Vec<String>,
    outputs: Vec<String>,
    workers: usize,
) -> PyResult<Vec<TransitionParts<'py>>> {
    simulations.iter().try_for_each(|it| check_step(&it.get().plant(py), size))?;
    let work: Vec<&Simulation> = simulations.iter().map(Py::get).collect();
    if let Some(index) = (0..work.len()).find(|it| work[..*it].iter().any(|other| std::ptr::eq(*other, work[*it]))) {
        return Err(refused(format!("simulation {index} is given twice")));
    }
    let (asked, pool) = (Asked { parameters, outputs }, pool(workers)?);
    let made = |simulation: &&Simulation| {
        let mut plant = simulation.locked();
        (asked.of(&mut plant, size), plant.table().inputs().count())
    };
    let made: Vec<_> = py.detach(|| pool.install(|| work.par_iter().map(made).collect()));
    let tell = |(index, (outcome, inputs)): (usize, (Result<Transition, TransitionError>, usize))| {
        Ok(asked.tell(py, outcome.map_err(|error| transition_error_of("simulation", index, error))?, inputs))
    };
    made.into_iter().enumerate().map(tell).collect()
}
