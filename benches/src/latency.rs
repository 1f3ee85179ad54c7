//! The distribution of the cost of a communication step.

use std::time::Instant;

use crate::case::{Case, voltage};
use crate::host::Host;

/// Costs of the communication steps of one run in ns, and what the solver did.
#[derive(Clone, Debug)]
pub struct Latency {
    /// Mean in ns.
    pub mean: f64,
    /// Median in ns.
    pub median: f64,
    /// The cost in ns that one step in a thousand exceeds.
    pub rare: f64,
    /// Maximum in ns.
    pub worst: f64,
    /// Accepted steps, rejected steps, Jacobians and events.
    pub counters: [i32; 4],
    /// Communication steps.
    pub calls: usize,
}

/// Times `fmi2SetReal` and `fmi2DoStep` with a fresh voltage at each of the communication steps of a run.
///
/// A run is repeated and does the same each time, bit for bit; of each step the least time counts, so that what the
/// operating system does in between does not.
pub fn measure(case: &Case, tolerance: f64, size: f64, duration: f64, repeats: usize) -> Latency {
    let calls = (duration / size).round() as usize;
    let mut costs = vec![f64::INFINITY; calls];
    let mut counters = [0; 4];
    for _ in 0..repeats {
        let mut host = Host::start(case, tolerance);
        for (index, cost) in costs.iter_mut().enumerate() {
            let input = voltage(index as f64 * size);
            let start = Instant::now();
            host.step(input, size);
            *cost = cost.min(start.elapsed().as_nanos() as f64);
        }
        counters = host.integers(["solver.steps", "solver.rejectedSteps", "solver.jacobians", "solver.events"]);
    }
    costs.sort_by(f64::total_cmp);
    Latency {
        mean: costs.iter().sum::<f64>() / calls as f64,
        median: costs[calls / 2],
        rare: costs[calls - 1 - calls / 1000],
        worst: costs[calls - 1],
        counters,
        calls,
    }
}
