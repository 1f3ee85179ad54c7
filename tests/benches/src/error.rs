//! Trajectories and their deviation from a reference.

use crate::case::{Case, DURATION, STEP, variable, voltage};
use crate::host::Host;

/// Position in m and friction force in N at the end of each communication step.
pub type Trajectory = Vec<[f64; 2]>;

/// Distance of a trajectory from another.
#[derive(Clone, Copy, Debug)]
pub struct Deviation {
    /// Largest deviation of the position in m.
    pub position: f64,
    /// Rms deviation of the friction force in N, which jumps when sliding ends.
    pub friction: f64,
}

impl Deviation {
    /// Between two trajectories.
    pub fn between(one: &Trajectory, other: &Trajectory) -> Self {
        let apart = |index: usize| one.iter().zip(other).map(move |(a, b)| (a[index] - b[index]).abs());
        let squares: f64 = apart(1).map(|deviation| deviation * deviation).sum();
        Self { position: apart(0).fold(0.0, f64::max), friction: (squares / one.len() as f64).sqrt() }
    }
}

/// The trajectory of an instance in the experiment of the comparison.
pub fn trajectory(case: &Case, tolerance: f64) -> Trajectory {
    let mut host = Host::start(case, tolerance);
    let references = ["position", "frictionForce"].map(|name| variable(name).reference);
    let steps = 0..(DURATION / STEP).round() as usize;
    let ends = steps.map(|index| {
        host.step(voltage(index as f64 * STEP), STEP);
        host.reals(&references)
    });
    ends.collect()
}
