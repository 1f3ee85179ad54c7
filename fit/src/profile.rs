//! Intervals by profile: how far a parameter can be moved if everything else is fitted anew.

use crate::intervals::{Certainty, Ends, blind, certainty, covariance, linearised, white};
use crate::parameter::Parameter;
use crate::problem::Interrupted;
use crate::search::{FINE, Loss, Unwatched, refine};
use crate::simulation::Workers;
use crate::study::Study;

/// Doublings of the distance in the search for an end, and halvings between two distances that enclose it.
const DOUBLINGS: usize = 6;
const HALVINGS: usize = 6;

/// Profile intervals: the cost at their ends has risen by as much as the cost of a linear problem rises at the ends of the intervals
/// from the Jacobian.
///
/// # Errors
/// [`Interrupted`].
pub fn profile(study: &Study, x: &[f64], workers: &dyn Workers) -> Result<Certainty, Interrupted> {
    let linear = study.with(workers, |problem| linearised(problem, x))?;
    let (spread, factors) = covariance(&linear);
    let (white, blind) = (white(&linear), blind(&linear.derivatives));
    let of_parameter = |place: usize| {
        let half = factors[place] * spread[(place, place)].max(0.0).sqrt();
        let half = if blind[place] { f64::INFINITY } else { half };
        let rise = half * half / white[(place, place)];
        let [low, high] = study.parameters[place].inner_bounds();
        Ok([end(study, x, place, -half, rise, workers)?, end(study, x, place, half, rise, workers)?]
            .map(|end| end.max(low).min(high)))
    };
    let ends = (0..study.parameters.len()).map(of_parameter).collect::<Result<_, _>>()?;
    study.with(workers, |problem| certainty(problem, x, Ends::Given(ends)))
}

/// Where the cost has risen by so much, from a first distance on.
fn end(
    study: &Study,
    x: &[f64],
    place: usize,
    first: f64,
    rise: f64,
    workers: &dyn Workers,
) -> Result<f64, Interrupted> {
    let beyond = first.signum() * f64::INFINITY;
    if !first.is_finite() || first == 0.0 {
        return Ok(beyond);
    }
    let residuals = study.residuals(workers, x)?;
    let mut prior = study.with(workers, |problem| problem.prior(x));
    prior.remove(place);
    let limit = residuals.iter().chain(&prior).map(|value| value * value).sum::<f64>() + rise;
    let has_risen = |by: f64| Ok(cost(study, x, place, x[place] + by, workers)? >= limit);
    let (mut near, mut far) = (0.0, first);
    for doubling in 0.. {
        if doubling == DOUBLINGS {
            return Ok(beyond);
        }
        if has_risen(far)? {
            break;
        }
        (near, far) = (far, 2.0 * far);
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (near + far);
        if has_risen(middle)? { far = middle } else { near = middle }
    }
    Ok(x[place] + far)
}

/// The cost with one parameter fixed and everything else fitted.
fn cost(study: &Study, x: &[f64], place: usize, inner: f64, workers: &dyn Workers) -> Result<f64, Interrupted> {
    let mut rest = study.clone();
    let fixed: Parameter = rest.parameters.remove(place);
    let [low, high] = fixed.inner_bounds();
    if !(low..=high).contains(&inner) {
        return Ok(f64::INFINITY);
    }
    rest.fixed.insert(fixed.name.clone(), fixed.outer(inner));
    let mut start = x.to_vec();
    start.remove(place);
    if start.is_empty() {
        return Ok(rest.residuals(workers, &start)?.iter().map(|residual| residual * residual).sum());
    }
    Ok(2.0 * rest.with(workers, |problem| refine(problem, &start, Loss::Linear, FINE, &Unwatched))?.cost)
}
