//! Intervals of the parameters, and parameters that are not identifiable.

use nalgebra::DMatrix;

use crate::distributions::student;
use crate::jacobian::{scale_rows, sensitivities};
use crate::matrix::{Singular, orthogonal, pseudo_inverse, triangle};
use crate::parameter::{Parameter, Values};
use crate::problem::{Interrupted, Problem, TOLERANCE};

/// Blocks of time that count as independent.
const BLOCKS: usize = 20;
/// Records of which the differences tell something.
const FEWEST: usize = 3;
/// Singular values below this share of the largest are no information.
pub const RANK: f64 = 1e-7;
/// Share of a parameter in a direction that the residuals do not see, from which on it is not identifiable.
const TAKES_PART: f64 = 0.1;
/// Step of an inner value that tells how what is tied to it moves.
const STEP_OF_TIES: f64 = 1e-6;
/// Relative distance of inner values at which a value is at its bound.
const AT_BOUND: f64 = 1e-6;

/// A problem about a solution: linear least squares of the parameters alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// Derivatives of shape (samples, parameters), where the segments begin as suits them best, in units of the noise.
    pub derivatives: DMatrix<f64>,
    /// Residuals in the same units, of variance 1.
    pub scores: Vec<f64>,
    /// Block of time of each sample.
    pub blocks: Vec<usize>,
    /// Record of each sample.
    pub records: Vec<usize>,
}

/// Intervals and what belongs to them.
#[derive(Clone, Debug, PartialEq)]
pub struct Certainty {
    /// Lower and upper ends of the 95 % intervals, in SI units.
    pub intervals: Vec<[f64; 2]>,
    /// Correlations of the errors.
    pub correlation: DMatrix<f64>,
    /// Why the data do not determine a parameter, in the order of the parameters.
    pub reasons: Vec<Option<&'static str>>,
}

/// The problem about a solution.
///
/// # Errors
/// [`Interrupted`].
pub fn linearised(problem: &Problem<'_>, x: &[f64]) -> Result<Linear, Interrupted> {
    let differences = problem.simulated.differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0);
    let mut slopes = sensitivities(problem, x, &differences, TOLERANCE, true)?;
    scale_rows(&mut slopes, &problem.by_sensor(&differences, |sensor, difference| sensor.weight(difference)));
    let count = problem.parameters.len();
    let begins = slopes.columns(count, slopes.ncols() - count).into_owned();
    Ok(Linear {
        derivatives: orthogonal(slopes.columns(0, count).into_owned(), &begins),
        scores: problem.by_sensor(&differences, |sensor, difference| sensor.weighted_score(difference)),
        blocks: problem.blocks(BLOCKS),
        records: problem.records(),
    })
}

/// Where the ends of intervals come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Ends {
    /// The Jacobian.
    Jacobian,
    /// [`bootstrap`], with a seed and a number of draws.
    Bootstrap(u64, usize),
    /// Elsewhere; of inner values.
    Given(Vec<[f64; 2]>),
}

/// 95 % intervals, from the Jacobian as wide as the residuals demand.
///
/// # Errors
/// [`Interrupted`].
pub fn certainty(problem: &Problem<'_>, x: &[f64], ends: Ends) -> Result<Certainty, Interrupted> {
    let linear = linearised(problem, x)?;
    let (covariance, factors) = covariance(&linear);
    let ends = match ends {
        Ends::Jacobian => None,
        Ends::Bootstrap(seed, draws) => Some(bootstrap(&linear, x, seed, draws)),
        Ends::Given(ends) => Some(ends),
    };
    Ok(of_covariance(problem, x, &linear, &covariance, &factors, ends))
}

/// Places of the parameters whose values have run to a bound that is none of the model, and the values of the bounds.
pub fn at_bounds(parameters: &[Parameter], x: &[f64]) -> Vec<(usize, f64)> {
    let bound = |(place, one): (usize, &Parameter)| Some((place, one.bound_of_user_at(x[place], AT_BOUND)?));
    parameters.iter().enumerate().filter_map(bound).collect()
}

/// Parameters that the data would hardly tell if nothing but the noise of the sensors were left, at the start values.
///
/// # Errors
/// [`Interrupted`].
pub fn hidden(problem: &Problem<'_>) -> Result<Vec<Option<&'static str>>, Interrupted> {
    let x = problem.start();
    let linear = linearised(problem, &x)?;
    let factors = vec![student(linear.scores.len()); problem.parameters.len()];
    Ok(of_covariance(problem, &x, &linear, &white(&linear), &factors, None).reasons)
}

fn of_covariance(
    problem: &Problem<'_>,
    x: &[f64],
    linear: &Linear,
    covariance: &DMatrix<f64>,
    factors: &[f64],
    ends: Option<Vec<[f64; 2]>>,
) -> Certainty {
    let count = problem.parameters.len();
    let blind = blind(&linear.derivatives);
    let half = |place: usize| {
        if blind[place] { f64::INFINITY } else { factors[place] * covariance[(place, place)].max(0.0).sqrt() }
    };
    let of_half = |place: usize| [x[place] - half(place), x[place] + half(place)];
    let ends = ends.unwrap_or_else(|| (0..count).map(of_half).collect());
    let deviation = |place: usize| covariance[(place, place)].sqrt();
    let correlation = DMatrix::from_fn(count, count, |a, b| {
        let found = covariance[(a, b)] / (deviation(a) * deviation(b));
        if found.is_finite() { found } else { 0.0 }
    });
    let outer = |(one, ends): (&Parameter, &[f64; 2])| ends.map(|end| one.outer(end));
    Certainty {
        intervals: problem.parameters.iter().zip(&ends).map(outer).collect(),
        correlation,
        reasons: undetermined(&problem.parameters, x, &ends, &blind),
    }
}

/// Values of the tied parameters `names` with the ends of their intervals, by linear propagation of the errors of the estimated
/// parameters. `values` gives the values of all parameters, tied ones included, that a vector of inner values stands for.
pub fn tied(
    parameters: &[Parameter],
    names: &[&str],
    values: &dyn Fn(&[f64]) -> Values,
    x: &[f64],
    sure: &Certainty,
) -> Vec<[f64; 3]> {
    let half = |(one, [low, high]): (&Parameter, &[f64; 2])| {
        let is_finite = (high - low).is_finite() && !(one.is_logarithmic() && *low <= 0.0);
        if is_finite { 0.5 * (one.inner(*high) - one.inner(*low)) } else { f64::INFINITY }
    };
    let halves: Vec<f64> = parameters.iter().zip(&sure.intervals).map(half).collect();
    let x = &x[..parameters.len()];
    let moved = |place: usize| {
        let step = STEP_OF_TIES * x[place].abs().max(1.0);
        let [ahead, behind] = [step, -step].map(|by| {
            let mut vector = x.to_vec();
            vector[place] += by;
            values(&vector)
        });
        names.iter().map(|name| (ahead[*name] - behind[*name]) / (2.0 * step)).collect::<Vec<f64>>()
    };
    let slopes: Vec<Vec<f64>> = (0..x.len()).map(moved).collect();
    let middle = values(x);
    let of = |(tie, name): (usize, &&str)| {
        let moving: Vec<usize> = (0..x.len()).filter(|place| slopes[*place][tie] != 0.0).collect();
        let error = |place: usize| slopes[place][tie] * halves[place];
        let pairs = moving.iter().flat_map(|a| moving.iter().map(move |b| (*a, *b)));
        let square: f64 = pairs.map(|(a, b)| error(a) * sure.correlation[(a, b)] * error(b)).sum();
        let is_told = moving.iter().all(|place| error(*place).is_finite());
        let half = if is_told { square.max(0.0).sqrt() } else { f64::INFINITY };
        let value = middle[*name];
        [value, value - half, value + half]
    };
    names.iter().enumerate().map(of).collect()
}

/// Covariance of the inner values, and the factors from deviations to half intervals.
///
/// For each parameter the widest of three intervals: for independent residuals; by a jackknife over blocks of time, since
/// autocorrelated residuals tell less; and by a jackknife over records, which one model may not fit together.
pub fn covariance(linear: &Linear) -> (DMatrix<f64>, Vec<f64>) {
    let (number, count) = linear.derivatives.shape();
    let white = white(linear);
    let mut wide = vec![1.0; count];
    let mut factors = vec![student(number.saturating_sub(count)); count];
    for (labels, least) in [(&linear.blocks, count + 2), (&linear.records, FEWEST)] {
        let groups = labels.iter().max().map_or(0, |most| most + 1);
        if groups < least {
            continue;
        }
        let factor = student(groups - 1);
        for (place, variance) in jackknife(linear, labels, groups).into_iter().enumerate() {
            let ratio = (variance / white[(place, place)].max(1e-300)).sqrt();
            if ratio * factor > wide[place] * factors[place] {
                (wide[place], factors[place]) = (ratio, factor);
            }
        }
    }
    (DMatrix::from_fn(count, count, |a, b| white[(a, b)] * wide[a] * wide[b]), factors)
}

/// Covariance of independent residuals. Of a parameter without effect it is 0, which rounding would not leave.
pub fn white(linear: &Linear) -> DMatrix<f64> {
    let mut inverse = pseudo_inverse(&triangle(&linear.derivatives), RANK);
    for (mut row, column) in inverse.row_iter_mut().zip(linear.derivatives.column_iter()) {
        if column.iter().all(|value| *value == 0.0) {
            row.fill(0.0);
        }
    }
    &inverse * inverse.transpose()
}

/// Variances by the moves of the parameters as one group of samples after the other is left out.
fn jackknife(linear: &Linear, labels: &[usize], groups: usize) -> Vec<f64> {
    let count = linear.derivatives.ncols();
    let mut parts = vec![(DMatrix::zeros(count, count), DMatrix::zeros(count, 1)); groups];
    for (row, label) in labels.iter().enumerate() {
        let (information, slope) = &mut parts[*label];
        let own = linear.derivatives.row(row);
        for a in 0..count {
            slope[(a, 0)] += own[a] * linear.scores[row];
            for b in 0..count {
                information[(a, b)] += own[a] * own[b];
            }
        }
    }
    let mut whole = DMatrix::zeros(count, count);
    parts.iter().for_each(|(information, _)| whole += information);
    let mut variances = vec![0.0; count];
    for (information, slope) in &parts {
        let moved = pseudo_inverse(&(&whole - information), RANK * RANK) * slope;
        variances.iter_mut().zip(moved.iter()).for_each(|(variance, by)| *variance += by * by);
    }
    let share = (groups - 1) as f64 / groups as f64;
    variances.iter().map(|variance| variance * share).collect()
}

/// Quantiles of one Gauss-Newton step for blocks of time drawn with replacement, as ends of inner values.
pub fn bootstrap(linear: &Linear, x: &[f64], seed: u64, draws: usize) -> Vec<[f64; 2]> {
    use crate::arrays::quantile;
    use crate::distributions::LEVEL;
    use pneumatic_servo::numbers::random;

    let count = linear.derivatives.ncols();
    let groups = linear.blocks.iter().max().map_or(0, |most| most + 1);
    let of_block = |block: usize| {
        let rows: Vec<usize> = (0..linear.blocks.len()).filter(|row| linear.blocks[*row] == block).collect();
        let own = linear.derivatives.select_rows(&rows);
        let scores = DMatrix::from_iterator(rows.len(), 1, rows.iter().map(|row| linear.scores[*row]));
        (own.tr_mul(&own), own.tr_mul(&scores))
    };
    let parts: Vec<_> = (0..groups).map(of_block).collect();
    let (mut state, mut steps) = (seed, vec![Vec::with_capacity(draws); count]);
    for _ in 0..draws {
        let (mut information, mut slope) = (DMatrix::zeros(count, count), DMatrix::zeros(count, 1));
        for _ in 0..groups {
            let (own, score) = &parts[(random::next(&mut state) % groups as u64) as usize];
            information += own;
            slope += score;
        }
        let step = pseudo_inverse(&information, RANK * RANK) * slope;
        steps.iter_mut().zip(step.iter()).for_each(|(steps, step)| steps.push(-step));
    }
    let end = |steps: &[f64], share: f64| quantile(steps, share);
    let both = |steps: &Vec<f64>| [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL].map(|share| end(steps, share));
    steps.iter().zip(x).map(|(steps, x)| both(steps).map(|end| x + end)).collect()
}

/// Parameters that take part in a direction that the residuals do not see.
///
/// It is looked for with the parameters as they are scaled, and with each in units of its own effect: only in these a gain of 50
/// and the logarithm of a mass that make up for one another take part alike.
pub fn blind(derivatives: &DMatrix<f64>) -> Vec<bool> {
    let mut scaled = derivatives.clone();
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    unseen(derivatives).into_iter().zip(unseen(&scaled)).map(|(one, other)| one || other).collect()
}

fn unseen(derivatives: &DMatrix<f64>) -> Vec<bool> {
    let Singular { values, right, .. } = Singular::of(&triangle(derivatives));
    let largest = values.first().copied().unwrap_or(0.0);
    let takes_part = |place: usize| {
        let row = right.row(place);
        let mut pairs = values.iter().zip(row.iter());
        pairs.any(|(value, share)| *value < RANK * largest && share.abs() > TAKES_PART)
    };
    (0..derivatives.ncols()).map(|place| largest == 0.0 || takes_part(place)).collect()
}

fn undetermined(parameters: &[Parameter], x: &[f64], ends: &[[f64; 2]], blind: &[bool]) -> Vec<Option<&'static str>> {
    let reason = |(place, one): (usize, &Parameter)| {
        let ([low, high], [least, most]) = (ends[place], one.inner_bounds());
        // The default of a parameter without a logarithm is 1, as the search sees it.
        let possible = if one.is_bounded { one.bounds[0] } else { one.legal[0] };
        let is_lost = |half: f64| !one.is_logarithmic() && half > 1.0 && low < one.inner(possible);
        let half = 0.5 * (high - low);
        if blind[place] || !half.is_finite() {
            Some("the data do not change with it, or only with a combination of parameters")
        } else if (most - least).is_finite() && low <= least && high >= most {
            Some("its interval is wider than its bounds")
        } else if one.is_logarithmic() && half > 1.0 {
            Some("its interval is wider than from a third to three times its value")
        } else if is_lost(half) {
            Some("its interval reaches beyond what is possible, and is wider than its usual value")
        } else if one.bound_of_user_at(x[place], AT_BOUND).is_some() {
            Some("it is at a bound")
        } else {
            None
        }
    };
    parameters.iter().enumerate().map(reason).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass of 1 kg by its logarithm, and an offset in units of 0.5 N, with inner bounds.
    fn parameter(is_logarithmic: bool, [low, high]: [f64; 2]) -> Parameter {
        let (scale, outer): (f64, fn(f64) -> f64) =
            if is_logarithmic { (0.0, libm::exp) } else { (0.5, |inner| 0.5 * inner) };
        Parameter {
            name: "mass".to_owned(),
            unit: "kg".to_owned(),
            start: 1.0,
            bounds: [outer(low), outer(high)],
            scale,
            is_given: false,
            is_bounded: false,
            legal: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Of a logarithm its error is in proportion to the value; two that err alike make up for one another in a difference.
    #[test]
    fn a_tied_value_errs_as_what_it_follows_from() {
        let parameters = [
            Parameter { name: "a".to_owned(), ..parameter(true, [-9.0, 9.0]) },
            Parameter { name: "b".to_owned(), ..parameter(false, [-9.0, 9.0]) },
        ];
        let x = [libm::log(3.0), 4.0];
        let follow = |x: &[f64]| {
            let (a, b) = (libm::exp(x[0]), 0.5 * x[1]);
            Values::from(
                [("twice", 2.0 * a), ("difference", a - b), ("none", 7.0)].map(|(name, of)| (name.to_owned(), of)),
            )
        };
        let ends = |half: f64| [libm::exp(x[0] - half), libm::exp(x[0] + half)];
        let of = |correlated: f64, half: f64| {
            let correlation = DMatrix::from_row_slice(2, 2, &[1.0, correlated, correlated, 1.0]);
            let intervals = vec![ends(half), [2.0 - 0.3, 2.0 + 0.3]];
            let sure = Certainty { intervals, correlation, reasons: vec![None; 2] };
            tied(&parameters, &["twice", "difference", "none"], &follow, &x, &sure)
        };
        for (correlated, difference) in [(1.0, 0.0), (0.0, 0.3 * 2f64.sqrt())] {
            let found = of(correlated, 0.1);
            for (found, (value, half)) in found.iter().zip([(6.0, 0.6), (1.0, difference), (7.0, 0.0)]) {
                for (end, expected) in found.iter().zip([value, value - half, value + half]) {
                    assert!((end - expected).abs() < 1e-7, "{correlated}: {found:?}");
                }
            }
        }
        // What the data do not tell, they do not tell of what follows from it either.
        let [twice, difference, none] = of(0.0, f64::INFINITY)[..] else { panic!("three") };
        assert!(twice[2] == f64::INFINITY && difference[1] == f64::NEG_INFINITY && none == [7.0; 3]);
    }

    #[test]
    fn what_is_not_determined_says_why() {
        const NONE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
        const WIDE: Option<&str> = Some("its interval is wider than its bounds");
        const THRICE: Option<&str> = Some("its interval is wider than from a third to three times its value");
        const BOUND: Option<&str> = Some("it is at a bound");
        let cases = [
            (false, 0.0, 5.0, NONE, None),
            (false, 0.0, 1.01, [-1.0, 1.0], WIDE),
            (false, 0.0, 0.99, [-1.0, 1.0], None),
            // Beyond one bound alone.
            (false, 0.5, 1.0, [-1.0, 1.0], None),
            (false, -0.5, 1.0, [-1.0, 1.0], None),
            (true, 0.0, 1.01, NONE, THRICE),
            (true, 0.0, 0.99, NONE, None),
            (false, 1.0, 0.5, [-1.0, 1.0], BOUND),
            (false, -1.0, 0.5, [-1.0, 1.0], BOUND),
            (false, 1e4, 0.5, [-1.0, 1e4 * (1.0 + 0.5e-6)], BOUND),
            (false, 1e4, 0.5, [-1.0, 1e4 * (1.0 + 2e-6)], None),
            (false, 0.0, 0.5, [-2e-6, 10.0], None),
        ];
        let of = |one: &Parameter, x: f64, half: f64, is_blind: bool| {
            undetermined(std::slice::from_ref(one), &[x], &[[x - half, x + half]], &[is_blind])[0]
        };
        for (is_logarithmic, x, half, bounds, reason) in cases {
            assert_eq!(of(&parameter(is_logarithmic, bounds), x, half, false), reason, "{x} +- {half} in {bounds:?}");
        }
        let mut one = parameter(false, [-1.0, 1.0]);
        let hidden = Some("the data do not change with it, or only with a combination of parameters");
        assert_eq!(of(&one, 0.0, 0.5, true), hidden);
        assert_eq!(of(&one, 0.0, f64::INFINITY, false), hidden);
        // Beyond a bound of the model is nothing, whoever names it; an interval that reaches there is none of a value.
        one.legal = one.bounds;
        for is_bounded in [false, true] {
            one.is_bounded = is_bounded;
            assert_eq!(of(&one, 1.0, 0.5, false), None);
        }
        let beyond = Parameter { bounds: [-0.5, f64::INFINITY], legal: [-0.5, f64::INFINITY], ..one };
        let impossible = "its interval reaches beyond what is possible, and is wider than its usual value";
        assert_eq!(of(&beyond, 1.0, 2.1, false), Some(impossible));
    }
}
