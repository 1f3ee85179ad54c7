//! The distribution of the cost of a communication step.

use std::convert::Infallible;
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

/// The cost in ns of `fmi2SetReal` and `fmi2DoStep` with a fresh voltage, for each communication step of a run, and the
/// instance at its end.
///
/// # Panics
/// When a call fails.
pub fn run(case: &Case, tolerance: f64, size: f64, duration: f64) -> (Vec<f64>, Host) {
    let mut host = Host::start(case, tolerance);
    let calls = 0..(duration / size).round() as usize;
    let costs = calls.map(|index| {
        let input = voltage(index as f64 * size);
        let clock = Instant::now();
        host.step(input, size);
        clock.elapsed().as_nanos() as f64
    });
    (costs.collect(), host)
}

/// The least cost of each communication step over several runs, which do the same bit for bit: what the operating
/// system does in between does not count.
///
/// # Errors
/// When a run fails.
pub fn least<E>(repeats: usize, mut run: impl FnMut() -> Result<Vec<f64>, E>) -> Result<Vec<f64>, E> {
    let mut least = run()?;
    for _ in 1..repeats {
        for (slot, cost) in least.iter_mut().zip(run()?) {
            *slot = slot.min(cost);
        }
    }
    Ok(least)
}

/// Measures a case with communication steps of a size.
pub fn measure(case: &Case, tolerance: f64, size: f64, duration: f64, repeats: usize) -> Latency {
    let mut counters = [0; 4];
    let Ok(mut costs) = least(repeats, || {
        let (costs, host) = run(case, tolerance, size, duration);
        counters = host.integers(["solver.steps", "solver.rejectedSteps", "solver.jacobians", "solver.events"]);
        Ok::<_, Infallible>(costs)
    });
    let calls = costs.len();
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
