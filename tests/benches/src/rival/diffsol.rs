//! The crate diffsol.

use std::marker::PhantomData;

use anyhow::Result;
use diffsol::{NalgebraContext, NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations, OdeSolverMethod};

use super::{Method, Rival, Tolerances};
use crate::case::STEP;
use crate::plant::{Plant, Run, Solver};

type Matrix = NalgebraMat<f64>;
type Vector = NalgebraVec<f64>;
type Lu = NalgebraLU<f64>;

/// Runs the experiment.
pub fn run<const N: usize>(plant: &Plant, x: &[f64; N], tolerances: &Tolerances<N>, rival: Rival) -> Result<Run> {
    let mut problem = OdeBuilder::<Matrix>::new()
        .rtol(tolerances.relative)
        .atol(tolerances.absolute)
        .rhs_implicit(
            |x, _, time, rates| rates.copy_from_slice(&plant.rates::<N>(time, x.try_into().expect("all states"))),
            |x, _, time, seed, rates| rates.copy_from_slice(&plant.directional_rates::<N>(time, x, seed)),
        )
        .init(|_, _, states| states.copy_from_slice(x), N)
        .build()?;
    problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
    problem.ode_options.max_error_test_failures = usize::MAX;
    problem.ode_options.min_timestep = 1e-15;
    match rival.method {
        Method::Esdirk34 => plant.integrate(Diffsol::<_, _, N>::new(plant, problem.esdirk34::<Lu>()?), rival.coupling),
        _ => plant.integrate(Diffsol::<_, _, N>::new(plant, problem.bdf::<Lu>()?), rival.coupling),
    }
}

/// One of its methods at work.
struct Diffsol<'p, 'a, E, S, const N: usize> {
    plant: &'p Plant,
    solver: S,
    equations: PhantomData<&'a E>,
}

impl<'p, 'a, E, S, const N: usize> Diffsol<'p, 'a, E, S, N>
where
    E: OdeEquations<T = f64, V = Vector, C = NalgebraContext> + 'a,
    S: OdeSolverMethod<'a, E>,
{
    fn new(plant: &'p Plant, solver: S) -> Self {
        Self { plant, solver, equations: PhantomData }
    }
}

impl<'a, E, S, const N: usize> Solver<N> for Diffsol<'_, 'a, E, S, N>
where
    E: OdeEquations<T = f64, V = Vector, C = NalgebraContext> + 'a,
    S: OdeSolverMethod<'a, E>,
{
    fn time(&self) -> f64 {
        self.solver.state().t
    }

    fn states(&self) -> [f64; N] {
        array(self.solver.state().y)
    }

    fn step(&mut self) -> Result<()> {
        self.solver.step()?;
        Ok(())
    }

    fn interpolate(&self, time: f64) -> Result<[f64; N]> {
        Ok(array(&self.solver.interpolate(time)?))
    }

    fn restart(&mut self, time: f64, states: &[f64; N]) -> Result<()> {
        if time < self.time() {
            self.solver.state_mut_back(time)?;
        }
        let rates = self.plant.rates(time, states);
        let problem = self.solver.problem();
        let mut state = self.solver.state_mut();
        for (index, (value, rate)) in states.iter().zip(rates).enumerate() {
            (state.y[index], state.dy[index]) = (*value, rate);
        }
        // The first step is of its own choice.
        state.set_step_size(STEP, &problem.atol, problem.rtol, &problem.eqn, 1);
        Ok(())
    }

    fn stop_at(&mut self, time: f64) -> Result<()> {
        self.solver.set_stop_time(time)?;
        Ok(())
    }
}

fn array<const N: usize>(vector: &Vector) -> [f64; N] {
    std::array::from_fn(|index| vector[index])
}
