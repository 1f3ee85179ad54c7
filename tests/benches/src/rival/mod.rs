//! General stiff solvers on the same equations.
//!
//! Error weights, right-hand side and Jacobian are our solver's.

#[cfg(feature = "cvode")]
mod cvode;
mod diffsol;

use anyhow::{Context, Result, bail};
use pneumatic_servo::model::{Seeds, Start};
use pneumatic_servo::models::pneumatic_servo_cylinder::PneumaticServoCylinder;
use pneumatic_servo::session::build;
use pneumatic_servo::system::System;

use crate::case::{Case, inputs};
use crate::plant::{Coupling, Plant, Run};

/// The general solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// CVODE of SUNDIALS: backward differentiation formulas of order 1 to 5, dense LU.
    #[cfg(feature = "cvode")]
    Cvode,
    /// The backward differentiation formulas of diffsol, order 1 to 5, dense LU.
    Bdf,
    /// A singly diagonally implicit Runge-Kutta method of order 3, also of diffsol.
    Esdirk34,
}

/// A general solver and the way it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rival {
    /// The method.
    pub method: Method,
    /// Coupling to the communication steps.
    pub coupling: Coupling,
}

impl Rival {
    /// Runs the experiment.
    ///
    /// # Errors
    /// When the solver gives up.
    pub fn run(self, case: &Case, tolerance: f64) -> Result<Run> {
        let without_play = case.clone().with("valve.hysteresis", 0.0);
        let start = Start {
            time: 0.0,
            parameters: &without_play.parameters,
            inputs: &inputs(),
            tolerance: None,
            seeds: Seeds::NONE,
        };
        let (system, _) = build::<PneumaticServoCylinder, 3>(&start).context("legal parameters")?;
        match system.states() {
            8 => self.run_with::<8>(case, system, tolerance),
            9 => self.run_with::<9>(case, system, tolerance),
            count => bail!("{count} states are not provided for"),
        }
    }

    fn run_with<const N: usize>(self, case: &Case, system: PneumaticServoCylinder, tolerance: f64) -> Result<Run> {
        let scales: [f64; N] = system.scales();
        let (plant, x) = Plant::new::<N>(case, system, self.coupling);
        let tolerances = Tolerances { relative: tolerance, absolute: scales.map(|scale| scale * tolerance) };
        match self.method {
            #[cfg(feature = "cvode")]
            Method::Cvode => plant.integrate(cvode::Cvode::new(&plant, &x, &tolerances)?, self.coupling),
            Method::Bdf | Method::Esdirk34 => diffsol::run(&plant, &x, &tolerances, self),
        }
    }
}

/// Error tolerances of the states.
struct Tolerances<const N: usize> {
    relative: f64,
    absolute: [f64; N],
}
