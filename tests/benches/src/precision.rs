//! Cost against error, and the ratio of two costs at equal error.

use std::convert::Infallible;

use anyhow::{Context, Result};

use crate::case::{Case, DURATION, STEP};
use crate::error::{Deviation, Trajectory, trajectory};
use crate::latency::{self, least};
use crate::plant::Coupling;
use crate::rival::{Method, Rival};

/// Tolerance of the reference.
const REFERENCE_TOLERANCE: f64 = 1e-11;
/// The error of a rival with a smooth input, against its own run.
const SMOOTH_REFERENCE: f64 = 1e-10;
/// Tolerances of our solver.
const TOLERANCES: [f64; 15] =
    [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 1e-9, 1e-10];
/// Tolerances of the rivals.
const RIVAL_TOLERANCES: [f64; 8] = [1e-3, 1e-4, 3e-5, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];

/// Solver, ours or a rival.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// This library, through its C interface.
    Ours,
    /// A general solver.
    Rival(Rival),
}

impl Solver {
    /// All that are compared.
    pub const ALL: &[Self] = &[
        Self::Ours,
        #[cfg(feature = "cvode")]
        Self::rival(Method::Cvode, Coupling::Restarted),
        #[cfg(feature = "cvode")]
        Self::rival(Method::Cvode, Coupling::Stopped),
        #[cfg(feature = "cvode")]
        Self::rival(Method::Cvode, Coupling::Free),
        #[cfg(feature = "cvode")]
        Self::rival(Method::Cvode, Coupling::Smooth),
        Self::rival(Method::Bdf, Coupling::Restarted),
        Self::rival(Method::Bdf, Coupling::Stopped),
        Self::rival(Method::Bdf, Coupling::Free),
        Self::rival(Method::Bdf, Coupling::Smooth),
        Self::rival(Method::Esdirk34, Coupling::Stopped),
        Self::rival(Method::Esdirk34, Coupling::Free),
    ];

    const fn rival(method: Method, coupling: Coupling) -> Self {
        Self::Rival(Rival { method, coupling })
    }

    /// Its name in reports.
    pub fn name(self) -> String {
        match self {
            Self::Ours => "ours".to_owned(),
            Self::Rival(Rival { method, coupling }) => format!("{method:?} {coupling:?}").to_lowercase(),
        }
    }
}

/// A run of the experiment.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Relative tolerance.
    pub tolerance: f64,
    /// Mean cost of a communication step in ns.
    pub cost: f64,
    /// Deviation from the reference.
    pub deviation: Deviation,
}

/// The points of a solver for a case, by falling tolerance.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Solver, ours or a rival.
    pub solver: Solver,
    /// The runs.
    pub points: Vec<Point>,
}

/// The reference of a case: our solver at a tight tolerance, which the rivals approach.
pub fn reference(case: &Case) -> Trajectory {
    trajectory(case, REFERENCE_TOLERANCE)
}

/// Measures all solvers in turn, the rivals `repeats` times; of each communication step the least cost counts.
///
/// # Errors
/// When a rival cannot even start; a tolerance at which it gives up is left out.
pub fn measure(case: &Case, reference: &Trajectory, repeats: usize) -> Result<Vec<Curve>> {
    let curve = |solver| {
        let points = match solver {
            Solver::Ours => {
                TOLERANCES.iter().map(|tolerance| Some(our_point(case, reference, *tolerance, repeats))).collect()
            }
            Solver::Rival(rival) => {
                // Without jumps the input is another one, and so is what is approached.
                let of_its_own = match rival.coupling {
                    Coupling::Smooth => Some(rival.run(case, SMOOTH_REFERENCE)?.trajectory),
                    _ => None,
                };
                let reference = of_its_own.as_ref().unwrap_or(reference);
                let tolerances = RIVAL_TOLERANCES.iter();
                tolerances.map(|tolerance| rival_point(rival, case, reference, *tolerance, repeats)).collect::<Vec<_>>()
            }
        };
        let points: Vec<Point> = points.into_iter().flatten().collect();
        points.first().with_context(|| format!("{} fails at every tolerance", solver.name()))?;
        Ok(Curve { solver, points })
    };
    Solver::ALL.iter().copied().map(curve).collect()
}

fn our_point(case: &Case, reference: &Trajectory, tolerance: f64, repeats: usize) -> Point {
    let Ok(costs) = least(3 * repeats, || Ok::<_, Infallible>(latency::run(case, tolerance, STEP, DURATION).0));
    let deviation = Deviation::between(&trajectory(case, tolerance), reference);
    Point { tolerance, cost: mean(&costs), deviation }
}

fn rival_point(rival: Rival, case: &Case, reference: &Trajectory, tolerance: f64, repeats: usize) -> Option<Point> {
    let mut found = Trajectory::new();
    let costs = least(repeats, || {
        let run = rival.run(case, tolerance)?;
        found = run.trajectory;
        Ok(run.costs)
    });
    match costs {
        Ok(costs) => Some(Point { tolerance, cost: mean(&costs), deviation: Deviation::between(&found, reference) }),
        Err::<_, anyhow::Error>(error) => {
            eprintln!("{}: {rival:?} at {tolerance:e}: {error:#}", case.name);
            None
        }
    }
}

fn mean(costs: &[f64]) -> f64 {
    costs.iter().sum::<f64>() / costs.len() as f64
}

impl Curve {
    /// The cost at which an error is reached, between the measured points in logarithms of both: the least of the
    /// points that reach it, and of the ways from these to the nearest cheaper point that does not. `None` where no
    /// point reaches it.
    pub fn cost_at(&self, limit: f64, error: impl Fn(&Deviation) -> f64) -> Option<f64> {
        let reaches = |point: &&Point| error(&point.deviation) <= limit;
        let enough = self.points.iter().filter(reaches).min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let cheaper = self.points.iter().filter(|point| point.cost < enough.cost);
        let Some(short) = cheaper.max_by(|a, b| a.cost.total_cmp(&b.cost)) else { return Some(enough.cost) };
        let (coarse, fine) = (error(&short.deviation).ln(), error(&enough.deviation).ln());
        let part = (coarse - limit.ln()) / (coarse - fine);
        Some((short.cost.ln() + part * (enough.cost / short.cost).ln()).exp())
    }

    /// The point nearest to a tolerance.
    ///
    /// # Panics
    /// When there is no point.
    pub fn near(&self, tolerance: f64) -> &Point {
        let distance = |point: &Point| (point.tolerance / tolerance).ln().abs();
        self.points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a point")
    }
}

/// Ratio of a rival's cost to ours at the rival's errors at a tolerance: by position and by friction force, of which the
/// smaller counts.
pub fn ratio(ours: &Curve, rival: &Curve, tolerance: f64) -> Option<[f64; 2]> {
    let at = rival.near(tolerance).deviation;
    let by = |error: fn(&Deviation) -> f64| Some(rival.cost_at(error(&at), error)? / ours.cost_at(error(&at), error)?);
    Some([by(|it| it.position)?, by(|it| it.friction)?])
}
