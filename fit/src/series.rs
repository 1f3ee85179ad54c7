//! One machine over months: parameters that are shared by all records, and those that each record has of its own.
//!
//! From fits of single records all are fitted together, by Gauss-Newton steps in which shared parameters have one value.

use nalgebra::DMatrix;

use crate::distributions::{NORMAL_95, chi_squared_tail};
use crate::intervals::{Linear, covariance, linearised};
use crate::jacobian::jacobian;
use crate::matrix::pseudo_inverse;
use crate::problem::{Interrupted, Problem, TOLERANCE};

/// Steps of the joint fit at most.
const ROUNDS: usize = 20;
/// Relative change of the cost at which it ends.
const ENDED: f64 = 1e-7;
/// Halvings of a step that does not lower the cost.
const HALVINGS: usize = 8;
/// Singular values below this share of the largest are no information.
const RANK: f64 = 1e-15;

/// A joint fit of several records.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Vector of each record; the shared parameters come first in each.
    pub vectors: Vec<Vec<f64>>,
    /// Whether no step is left.
    pub converged: bool,
    /// Half 95 % intervals of inner values: of the shared parameters, then of each record's own.
    pub halves: Vec<f64>,
    /// Of each own parameter the probability of differences at least as large, if it is the same in all records.
    pub p: Vec<f64>,
}

/// Fits records together, of which the first `common` parameters are shared, from vectors of fits of each alone.
///
/// # Errors
/// [`Interrupted`].
pub fn joint(problems: &[Problem<'_>], alone: &[Vec<f64>], common: usize) -> Result<Joint, Interrupted> {
    let (vectors, converged) = together(problems, alone, common, ROUNDS)?;
    let linear = joined(problems, &vectors, common)?;
    let (spread, factors) = covariance(&linear);
    let halves = (0..factors.len()).map(|place| factors[place] * spread[(place, place)].sqrt()).collect();
    let own = problems[0].parameters.len() - common;
    let differs = |place: usize| {
        let index: Vec<usize> = (0..problems.len()).map(|record| common + place + own * record).collect();
        let values: Vec<f64> = vectors.iter().map(|x| x[common + place]).collect();
        // The covariance of normal errors with the same intervals.
        let wide = |place: usize| factors[place] / NORMAL_95;
        let spread = DMatrix::from_fn(index.len(), index.len(), |a, b| {
            spread[(index[a], index[b])] * wide(index[a]) * wide(index[b])
        });
        constant(&values, &spread)
    };
    Ok(Joint { converged, halves, p: (0..own).map(differs).collect(), vectors })
}

/// Vectors of all records, and whether they are the best, after a number of steps at most.
fn together(
    problems: &[Problem<'_>],
    alone: &[Vec<f64>],
    common: usize,
    rounds: usize,
) -> Result<(Vec<Vec<f64>>, bool), Interrupted> {
    let records = problems.len() as f64;
    let middle: Vec<f64> = (0..common).map(|place| alone.iter().map(|x| x[place]).sum::<f64>() / records).collect();
    let begun = |(problem, x): (&Problem<'_>, &Vec<f64>)| {
        let mut x = [&middle, &x[common..]].concat();
        x.resize(problem.dimension(), 0.0);
        x
    };
    let mut vectors: Vec<Vec<f64>> = problems.iter().zip(alone).map(begun).collect();
    let mut before = cost(problems, &vectors, common)?;
    for _ in 0..rounds {
        let moves = moves(problems, &vectors, common)?;
        let mut share = 1.0;
        let mut lower = None;
        for _ in 0..HALVINGS {
            let places = problems.iter().zip(&vectors).zip(&moves);
            let trial: Vec<Vec<f64>> = places.map(|((problem, x), by)| within(problem, x, by, share)).collect();
            let after = cost(problems, &trial, common)?;
            if after < before {
                lower = Some((trial, after));
                break;
            }
            share *= 0.5;
        }
        let Some((trial, after)) = lower else { return Ok((vectors, true)) };
        let has_ended = before - after < ENDED * before;
        (vectors, before) = (trial, after);
        if has_ended {
            return Ok((vectors, true));
        }
    }
    Ok((vectors, false))
}

/// Factors of the priors: the prior of a shared parameter counts once, not once in each record.
fn prior_weights(problem: &Problem<'_>, common: usize, records: usize) -> Vec<f64> {
    let shared = 1.0 / (records as f64).sqrt();
    (0..problem.dimension()).map(|place| if place < common { shared } else { 1.0 }).collect()
}

/// Residuals of a record and of its priors.
fn residuals(problem: &Problem<'_>, x: &[f64], base: &[f64], common: usize, records: usize) -> Vec<f64> {
    let weights = prior_weights(problem, common, records);
    let prior = problem.prior(x).into_iter().zip(weights).map(|(prior, weight)| weight * prior);
    problem.residuals(base).into_iter().chain(prior).collect()
}

fn differences(problem: &Problem<'_>, x: &[f64]) -> Result<Vec<f64>, Interrupted> {
    Ok(problem.simulated.differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0))
}

fn cost(problems: &[Problem<'_>], vectors: &[Vec<f64>], common: usize) -> Result<f64, Interrupted> {
    let of = |(problem, x): (&Problem<'_>, &Vec<f64>)| {
        let residuals = residuals(problem, x, &differences(problem, x)?, common, problems.len());
        Ok(residuals.iter().map(|residual| residual * residual).sum::<f64>())
    };
    problems.iter().zip(vectors).map(of).sum()
}

/// A Gauss-Newton step: the shared parameters first, then each record's own in response.
fn moves(problems: &[Problem<'_>], vectors: &[Vec<f64>], common: usize) -> Result<Vec<Vec<f64>>, Interrupted> {
    let (mut information, mut slope) = (DMatrix::zeros(common, common), DMatrix::zeros(common, 1));
    let mut parts = vec![];
    for (problem, x) in problems.iter().zip(vectors) {
        let base = differences(problem, x)?;
        let residuals = residuals(problem, x, &base, common, problems.len());
        let residuals = DMatrix::from_vec(residuals.len(), 1, residuals);
        let data = jacobian(problem, x, &base, TOLERANCE, true)?;
        let weights = prior_weights(problem, common, problems.len());
        let prior: Vec<f64> =
            problem.prior_slopes().iter().zip(weights).map(|(slope, weight)| slope * weight).collect();
        let rows = data.nrows();
        let mut slopes = data.resize_vertically(rows + prior.len(), 0.0);
        prior.iter().enumerate().for_each(|(place, slope)| slopes[(rows + place, place)] = *slope);
        let (shared, own) = (slopes.columns(0, common).into_owned(), slopes.columns(common, x.len() - common));
        let (basis, triangle) = own.into_owned().qr().unpack();
        let rest = &shared - &basis * basis.tr_mul(&shared);
        information += rest.tr_mul(&rest);
        slope += rest.tr_mul(&residuals);
        parts.push((residuals, shared, basis, triangle));
    }
    let step = if common == 0 { slope } else { -pseudo_inverse(&information, RANK) * slope };
    let of = |(residuals, shared, basis, triangle): (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>, DMatrix<f64>)| {
        let right = basis.tr_mul(&(residuals + shared * &step));
        let own = if triangle.is_empty() { right } else { -pseudo_inverse(&triangle, RANK) * right };
        step.iter().chain(own.iter()).copied().collect()
    };
    Ok(parts.into_iter().map(of).collect())
}

/// A vector after a share of a step, within the bounds.
fn within(problem: &Problem<'_>, x: &[f64], by: &[f64], share: f64) -> Vec<f64> {
    let (low, high) = problem.bounds();
    let of = |place: usize| (x[place] + share * by[place]).max(low[place]).min(high[place]);
    (0..x.len()).map(of).collect()
}

/// All records about the solution: columns of shared parameters, then of each record's own.
fn joined(problems: &[Problem<'_>], vectors: &[Vec<f64>], common: usize) -> Result<Linear, Interrupted> {
    let parts = problems.iter().zip(vectors).map(|(problem, x)| linearised(problem, x));
    let parts: Vec<Linear> = parts.collect::<Result<_, _>>()?;
    let own = problems[0].parameters.len() - common;
    let rows = parts.iter().map(|part| part.derivatives.nrows()).sum();
    let mut derivatives = DMatrix::zeros(rows, common + own * parts.len());
    let (mut scores, mut blocks, mut first, mut before) = (vec![], vec![], 0, 0);
    for (record, part) in parts.iter().enumerate() {
        let count = part.derivatives.nrows();
        derivatives.view_mut((first, 0), (count, common)).copy_from(&part.derivatives.columns(0, common));
        let theirs = part.derivatives.columns(common, own);
        derivatives.view_mut((first, common + own * record), (count, own)).copy_from(&theirs);
        scores.extend(&part.scores);
        blocks.extend(part.blocks.iter().map(|block| block + before));
        (first, before) = (first + count, blocks.iter().max().map_or(0, |last| last + 1));
    }
    // No record can be left out, since each has parameters of its own.
    Ok(Linear { derivatives, scores, blocks, records: vec![0; rows] })
}

/// Probability of differences among values that are at least as large, given the covariance of their errors.
fn constant(values: &[f64], spread: &DMatrix<f64>) -> f64 {
    let count = values.len();
    let differences = DMatrix::from_fn(count - 1, count, |row, column| match column {
        0 => -1.0,
        column if column == row + 1 => 1.0,
        _ => 0.0,
    });
    let moved = &differences * DMatrix::from_column_slice(count, 1, values);
    let inverse = pseudo_inverse(&(&differences * spread * differences.transpose()), RANK);
    chi_squared_tail(moved.dot(&(inverse * &moved)), count - 1)
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::numbers::random;

    use super::*;
    use crate::parameter::Parameter;
    use crate::problem::{STEP, Segment, Simulated};
    use crate::sensor::Sensor;

    /// A record whose residuals are `matrix * x^power - data`.
    struct Record {
        matrix: DMatrix<f64>,
        data: DMatrix<f64>,
        power: i32,
    }

    impl Simulated for Record {
        fn differences(&self, vectors: &[Vec<f64>], _: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
            let of = |x: &Vec<f64>| {
                let powers = x.iter().map(|x| (0..self.power).fold(1.0, |product, _| product * x));
                let found = &self.matrix * DMatrix::from_iterator(x.len(), 1, powers) - &self.data;
                found.iter().copied().collect()
            };
            Ok(vectors.iter().map(of).collect())
        }
    }

    fn noisy(rows: usize, columns: usize, state: &mut u64) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| random::normal(state))
    }

    /// Problems of two parameters and some start values each; the first parameter has a prior about 0, unless the user gave bounds.
    fn problems(records: &[Record], most: f64, is_bounded: bool) -> Vec<Problem<'_>> {
        let any = [f64::NEG_INFINITY, f64::INFINITY];
        let of = |name: &str, scale: f64| {
            let bounds = [if scale == 0.0 { 0.0 } else { any[0] }, if scale == 0.0 { libm::exp(most) } else { most }];
            let (name, unit) = (name.to_owned(), "1".to_owned());
            Parameter { name, unit, start: 1.0, bounds, scale, is_given: false, is_bounded, legal: any }
        };
        let one = |record: &'_ Record| (record.matrix.ncols() - 2, record.matrix.nrows());
        let problem = |record| {
            let (begins, samples) = one(record);
            Problem {
                parameters: vec![of("shared", 0.0), of("own", 1.0)],
                segments: vec![Segment { samples, begins, record: 0 }],
                sensors: vec![Sensor { noise: 1.0, step: 0.0, is_coarse: false }],
                simulated: record,
                step: STEP,
            }
        };
        records.iter().map(problem).collect()
    }

    #[test]
    fn the_joint_fit_is_that_of_all_residuals_at_once() {
        let mut state = 1;
        let mut record = || Record { matrix: noisy(20, 3, &mut state), data: noisy(20, 1, &mut state), power: 1 };
        let records = [record(), record(), record()];
        let free = problems(&records, f64::INFINITY, false);
        // One regression: the shared column, then two of each record; a row draws the shared one to 0.
        let (mut matrix, mut data) = (DMatrix::zeros(61, 7), DMatrix::zeros(61, 1));
        for (place, record) in records.iter().enumerate() {
            matrix.view_mut((20 * place, 0), (20, 1)).copy_from(&record.matrix.columns(0, 1));
            matrix.view_mut((20 * place, 1 + 2 * place), (20, 2)).copy_from(&record.matrix.columns(1, 2));
            data.view_mut((20 * place, 0), (20, 1)).copy_from(&record.data);
        }
        matrix[(60, 0)] = free[0].prior_slopes()[0];
        assert!(matrix[(60, 0)] > 0.0);
        let best = pseudo_inverse(&matrix, 1e-14) * data;
        let alone: Vec<Vec<f64>> = (0..3).map(|k| vec![0.3 * f64::from(k), -0.2]).collect();
        let (vectors, converged) = together(&free, &alone, 1, ROUNDS).expect("nobody interrupts");
        assert!(converged && vectors.iter().all(|x| x[0] == vectors[0][0]));
        let found: Vec<f64> =
            std::iter::once(vectors[0][0]).chain(vectors.iter().flat_map(|x| x[1..].to_vec())).collect();
        for (found, best) in found.iter().zip(best.iter()) {
            assert!((found - best).abs() < 1e-8, "{found}, not {best}");
        }
        // A value that a step leads beyond a bound stays there.
        let (vectors, _) = together(&problems(&records, 0.01, false), &alone, 1, ROUNDS).expect("nobody interrupts");
        let most = vectors.iter().flat_map(|x| &x[..2]).copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((most - 0.01).abs() < 1e-12 && best.iter().any(|value| *value > 0.01), "{vectors:?}");
    }

    /// Of cubes, from where whole steps lead too far, to where each is the third root of its line's.
    #[test]
    fn the_joint_fit_has_ended_where_no_step_is_left() {
        let mut state = 1;
        let mut record = |k: f64| {
            let matrix = noisy(20, 2, &mut state);
            let data = &matrix * DMatrix::from_column_slice(2, 1, &[0.5, k + 1.0]);
            Record { matrix, data, power: 3 }
        };
        let records = [record(0.0), record(1.0), record(2.0)];
        let (problems, begun) = (problems(&records, f64::INFINITY, true), vec![vec![0.1, 0.3]; 3]);
        let (vectors, converged) = together(&problems, &begun, 1, ROUNDS).expect("nobody interrupts");
        assert!(converged);
        for (k, x) in vectors.iter().enumerate() {
            for (found, cube) in x.iter().zip([0.5, k as f64 + 1.0]) {
                assert!((found / libm::cbrt(cube) - 1.0).abs() < 1e-6, "{x:?}");
            }
        }
        assert!(!together(&problems, &begun, 1, 2).expect("nobody interrupts").1);
    }

    /// By the chi square of their weighted mean, which an error that they have in common does not change.
    #[test]
    fn values_differ_by_the_chi_square_of_their_weighted_mean() {
        let (values, variances) = ([1.0, 1.5, 0.4, 2.0], [0.1, 0.2, 0.3, 0.4]);
        let weights: f64 = variances.iter().map(|variance| 1.0 / variance).sum();
        let mean = values.iter().zip(variances).map(|(value, variance)| value / variance).sum::<f64>() / weights;
        let square = values.iter().zip(variances).map(|(value, variance)| (value - mean) * (value - mean) / variance);
        let expected = chi_squared_tail(square.sum(), 3);
        assert!((0.01..0.99).contains(&expected));
        for common in [0.0, 0.7] {
            let spread = DMatrix::from_fn(4, 4, |a, b| common + if a == b { variances[a] } else { 0.0 });
            assert!((constant(&values, &spread) / expected - 1.0).abs() < 1e-12);
        }
    }
}
