//! Cross-validation of a law over operating conditions: each is left out in turn, and predicted from the others.
//!
//! Intervals from residuals alone take the law for true at every pressure, which it is not: friction of a machine differs
//! from any law by some percent between conditions. Here this is part of the model. In each condition a law misses friction
//! by a share of its own, alike along everything that its parameters, or a factor of all friction, could change:
//!
//! ```text
//! B_i' residuals_i = B_i' J_i (theta - theta0) + e_i + noise,    e_i ~ N(0, tau^2 |f_i|^2 I),    tau ~ |N(0, 0.2^2)|
//! ```
//!
//! with the derivatives `J_i` by the parameters in the condition `i`, those `f_i` by the logarithm of all friction, and an
//! orthonormal basis `B_i` of both. How large tau is, is told by friction as a whole in each condition, about the curve that
//! the law can draw through them at best; it is integrated out, as A. Gelman advises for few groups ("Prior distributions
//! for variance parameters in hierarchical models", Bayesian Analysis, 2006): that a law is off by more than a factor of
//! 1.5 between conditions is not expected, unless `law_error` gives another deviation than 0.2; the data say the rest. The
//! condition that is left out is off by a share, too.

use nalgebra::DMatrix;
use pneumatic_servo::variables::Role;

use crate::arrays::{interpolate, mean, median, rms};
use crate::distributions::{LEVEL, normal, student};
use crate::intervals::RANK;
use crate::jacobian::{scale_rows, sensitivities};
use crate::matrix::{Singular, orthogonal, pseudo_inverse};
use crate::parameter::Parameter;
use crate::problem::{Interrupted, Simulated, TOLERANCE};
use crate::runs::LOAD_FACTOR;
use crate::search::{FINE, Loss, Unwatched, Watch, refine};
use crate::simulation::Workers;
use crate::study::Study;

/// Deviations tau that are looked at: a grid that is even in the logarithm, its ends and its number.
const SPREADS: ([f64; 2], usize) = ([1e-3, 1.0], 120);
/// Step of the logarithm of all friction whose effect is looked for, and of an inner value.
const STEP: f64 = 0.01;
const INNER_STEP: f64 = 1e-3;
/// Segments of time of the condition left out that count as independent.
const BLOCKS: usize = 10;
/// Singular values below this, of how the logarithm of friction changes with inner values, are none.
const TOLD: f64 = 1e-3;
/// Information that is known beforehand: nearly none, so that it only bounds directions without any.
const FLAT: f64 = 1e-9;
/// Share of the largest singular value below which one is no information.
const NO_INFORMATION: f64 = 1e-10;
/// Deviations beyond the means at which all of a mixture lies to one side.
const REACH: f64 = 12.0;
/// Properties of sensors, and the area that a pressure pushes on: they are none of the law.
const OF_SENSORS: [&str; 5] = ["area", "gain", "offset", "delay", "lag"];

/// Segments that were measured under one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// What tells it from others, such as `pressure`.
    pub quantity: String,
    /// The condition in words.
    pub name: String,
    /// Places of its segments in the study.
    pub segments: Vec<usize>,
}

/// Mean friction of a condition in N with 95 % intervals: as the other conditions predict it, and as measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Median and ends of the prediction.
    pub predicted: [f64; 3],
    /// Measured value and the ends of its interval.
    pub measured: [f64; 3],
    /// Median of tau as far as the other conditions tell it; NaN if the law has as many parameters as there are.
    pub spread: f64,
}

/// A condition that was left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Vector of the others.
    pub others: Vec<f64>,
    /// The same parameters, with start values of its own segments.
    pub asked: Vec<f64>,
    /// RMS residual of each compared signal in SI units, predicted and fitted.
    pub rms: Vec<[f64; 2]>,
    /// Friction; nothing for experiments that do not tell it alone.
    pub friction: Option<Friction>,
}

/// Leaves out one condition of a fitted study after the other. `law_error` is the expected deviation of friction from the law, as a
/// share.
///
/// # Errors
/// [`Interrupted`].
pub fn cross_validate(
    study: &Study,
    x: &[f64],
    groups: &[Group],
    loss: Loss,
    law_error: f64,
    workers: &dyn Workers,
    watch: &dyn Watch,
) -> Result<Vec<Case>, Interrupted> {
    let left_out = |(place, group): (usize, &Group)| {
        watch.done(&format!("condition {} of {}: {} is left out", place + 1, groups.len(), group.name));
        case(study, x, groups, place, loss, law_error, workers)
    };
    groups.iter().enumerate().map(left_out).collect()
}

fn case(
    study: &Study,
    x: &[f64],
    groups: &[Group],
    place: usize,
    loss: Loss,
    law_error: f64,
    workers: &dyn Workers,
) -> Result<Case, Interrupted> {
    let (group, count) = (&groups[place], study.parameters.len());
    let others: Vec<usize> = (0..study.segments.len()).filter(|own| !group.segments.contains(own)).collect();
    let (training, start) = study.of_segments(x, &others);
    let found = training.with(workers, |problem| refine(problem, &start, loss, FINE, &Unwatched))?.x;
    let (out, theirs) = study.of_segments(x, &group.segments);
    let asked = [&found[..count], &theirs[count..]].concat();
    let predicted = Left::of(&out, &asked, workers)?;
    let fitted = Left::of(&out, &theirs, workers)?;
    let pairs = predicted.rms(&out).into_iter().zip(fitted.rms(&out));
    let rms = pairs.map(|(predicted, fitted)| [predicted, fitted]).collect();
    let is_other = |(own, other): &(usize, &Group)| *own != place && other.quantity == group.quantity;
    let of_other = |(_, other): (usize, &Group)| {
        (0..others.len()).filter(|own| other.segments.contains(&others[*own])).collect::<Vec<_>>()
    };
    let groups: Vec<Vec<usize>> = groups.iter().enumerate().filter(is_other).map(of_other).collect();
    let level = study.experiment.given().model.table().find(LOAD_FACTOR);
    let friction = if level.is_some_and(|entry| entry.variable.role == Role::Input) {
        Some(friction(&training, &found, &groups, &out, &asked, &predicted, law_error, workers)?)
    } else {
        None
    };
    Ok(Case { others: found, asked, rms, friction })
}

/// Residuals of segments, and the derivatives that could lessen them, in units of the noise; effects of start values are taken out.
struct Left {
    /// Factors that convert a difference to units of the noise.
    weights: Vec<f64>,
    residuals: DMatrix<f64>,
    /// Derivatives by the estimated parameters, with the sign of the simulation.
    derivatives: DMatrix<f64>,
    /// Derivatives by start values.
    begins: DMatrix<f64>,
}

impl Left {
    fn of(study: &Study, x: &[f64], workers: &dyn Workers) -> Result<Self, Interrupted> {
        study.with(workers, |problem| {
            let differences = problem.simulated.differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0);
            let mut slopes = -sensitivities(problem, x, &differences, TOLERANCE, true)?;
            let weights = problem.by_sensor(&differences, |sensor, difference| sensor.weight(difference));
            scale_rows(&mut slopes, &weights);
            let count = problem.parameters.len();
            let begins = slopes.columns(count, slopes.ncols() - count).into_owned();
            let derivatives = orthogonal(slopes.columns(0, count).into_owned(), &begins);
            let weighted = differences.iter().zip(&weights).map(|(difference, weight)| finite(*difference) * weight);
            let residuals = orthogonal(DMatrix::from_iterator(weights.len(), 1, weighted), &begins);
            Ok(Self { weights, residuals, derivatives, begins })
        })
    }

    /// RMS residual of each signal in SI units.
    fn rms(&self, study: &Study) -> Vec<f64> {
        let mut signals = vec![vec![]; study.sensors.len()];
        let mut plain = self.residuals.iter().zip(&self.weights).map(|(residual, weight)| residual / weight);
        for segment in &study.segments {
            let samples = segment.fitted().count();
            signals.iter_mut().for_each(|own| own.extend(plain.by_ref().take(samples)));
        }
        signals.iter().map(|own| rms(own)).collect()
    }

    /// Change of the residuals with the logarithm of all friction.
    fn of_factor(&self, study: &Study, x: &[f64], workers: &dyn Workers) -> Result<DMatrix<f64>, Interrupted> {
        let run = |step: f64| {
            let scaled = Study { scale: study.scale * libm::exp(step), ..study.clone() };
            let differences = scaled.simulation(workers).differences(&[x.to_vec()], TOLERANCE)?.swap_remove(0);
            Ok::<_, Interrupted>(differences)
        };
        let (up, down) = (run(STEP)?, run(-STEP)?);
        let slopes = down.iter().zip(&up).map(|(down, up)| finite((down - up) / (2.0 * STEP)));
        let weighted = slopes.zip(&self.weights).map(|(slope, weight)| slope * weight);
        Ok(orthogonal(DMatrix::from_iterator(self.weights.len(), 1, weighted), &self.begins))
    }
}

/// Predicts friction of segments from others that are fitted, and measures it. `groups` are the places of the others, condition by
/// condition; `left` the residuals under the values of the others.
#[expect(clippy::too_many_arguments, reason = "two studies with their vectors")]
fn friction(
    training: &Study,
    x: &[f64],
    groups: &[Vec<usize>],
    out: &Study,
    asked: &[f64],
    left: &Left,
    law_error: f64,
    workers: &dyn Workers,
) -> Result<Friction, Interrupted> {
    let fitted = Left::of(training, x, workers)?;
    let whole = fitted.of_factor(training, x, workers)?;
    let signals = training.sensors.len();
    let counts = training.segments.iter().map(|segment| segment.fitted().count() * signals);
    let segments: Vec<usize> = counts.enumerate().flat_map(|(own, count)| std::iter::repeat_n(own, count)).collect();
    let own = |row: usize, group: usize| {
        if groups[group].contains(&segments[row]) { whole[(row, 0)] } else { 0.0 }
    };
    let factors = DMatrix::from_fn(segments.len(), groups.len(), own);
    let sensors = of_sensors(&training.parameters);
    let blocks = |study: &Study, number| study.with(workers, |problem| problem.blocks(number));
    let (mean, slope) = mean_friction(out, asked, workers)?;
    let [low, middle, high, spread] =
        predicted(&fitted, &factors, &blocks(training, 2 * BLOCKS), &slope, &sensors, law_error);
    let factor = left.of_factor(out, asked, workers)?;
    let (share, half) = measured(left, &factor, &blocks(out, BLOCKS), &sensors);
    Ok(Friction {
        predicted: [middle, low, high].map(|end| mean * libm::exp(end)),
        measured: [0.0, -half, half].map(|end| mean * (1.0 + share + end)),
        spread,
    })
}

/// Ends and median of the logarithm of the factor of friction that is expected, and the median of tau. `factors` have a column for
/// each condition, which is 0 in the others.
fn predicted(
    left: &Left,
    factors: &DMatrix<f64>,
    blocks: &[usize],
    slope: &[f64],
    sensors: &[usize],
    law_error: f64,
) -> [f64; 4] {
    let columns = beside(&left.derivatives, factors);
    let noise = noise(&columns, &left.residuals, blocks);
    let of = |number: usize| inside(left, factors, number);
    let seen: Vec<Seen> = (0..factors.ncols()).map(|number| Seen::of(of(number))).collect();
    let levels: Vec<Seen> = (0..factors.ncols()).map(|number| Seen::level(of(number), sensors)).collect();
    let slope = DMatrix::from_column_slice(slope.len(), 1, slope);
    let ([first, last], number) = SPREADS;
    let spread = |place: usize| first * libm::pow(last / first, place as f64 / (number - 1) as f64);
    let (mut weights, mut means, mut deviations) = (vec![], vec![], vec![]);
    for place in 0..number {
        let tau = spread(place);
        let Information { whole, right, .. } = information(&seen, tau, noise);
        let solved = solved(&whole, &beside(&right, &slope));
        let likely = information(&levels, tau, noise).likely;
        // The grid is even in the logarithm of tau.
        weights.push(likely + libm::log(tau) - 0.5 * (tau / law_error) * (tau / law_error));
        means.push(slope.dot(&solved.columns(0, 1)));
        deviations.push((slope.dot(&solved.columns(1, 1)) + tau * tau).sqrt());
    }
    let most = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut shares: Vec<f64> = weights.iter().map(|weight| libm::exp(weight - most)).collect();
    let sum: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|share| *share /= sum);
    let [low, middle, high] = [0.5 - 0.5 * LEVEL, 0.5, 0.5 + 0.5 * LEVEL].map(|level| {
        let below = |value: f64| mixture(&shares, &means, &deviations, value);
        let reach = REACH * deviations.iter().copied().fold(0.0, f64::max);
        let (least, most) = crate::arrays::extremes(&means);
        crossing(below, level, least - reach, most + reach)
    });
    let rows: Vec<_> = levels.iter().map(|one| one.derivatives.row(0) / one.size.sqrt()).collect();
    let told = Singular::of(&DMatrix::from_rows(&rows)).values.into_iter().filter(|value| *value > TOLD).count();
    let is_told = rows.len() > told;
    let mut below = 0.0;
    let half = shares.iter().position(|share| {
        below += share;
        below >= 0.5
    });
    let tau = if is_told { spread(half.unwrap_or(number - 1)) } else { f64::NAN };
    [low, middle, high, tau]
}

/// Factor, residuals and derivatives of one condition.
fn inside(left: &Left, factors: &DMatrix<f64>, number: usize) -> [DMatrix<f64>; 3] {
    let rows: Vec<usize> = (0..factors.nrows()).filter(|row| factors[(*row, number)] != 0.0).collect();
    [
        factors.select_rows(&rows).columns(number, 1).into_owned(),
        left.residuals.select_rows(&rows),
        left.derivatives.select_rows(&rows),
    ]
}

/// A condition along the effects of the parameters and of the factor of friction.
struct Seen {
    /// Residuals in units of the noise, one for each direction.
    residuals: DMatrix<f64>,
    /// Their derivatives by the parameters.
    derivatives: DMatrix<f64>,
    /// Square of how much the factor of all friction does.
    size: f64,
}

impl Seen {
    /// It, with the factor of all friction as the first direction.
    fn of([factor, residuals, slopes]: [DMatrix<f64>; 3]) -> Self {
        let size = factor.norm_squared();
        let first = factor / size.sqrt();
        let mut columns = slopes.clone();
        for mut column in columns.column_iter_mut() {
            column /= column.norm().max(1e-300);
        }
        let shares = first.tr_mul(&columns);
        let Singular { values, left, .. } = Singular::of(&(columns - &first * shares));
        let own: Vec<usize> = (0..values.len()).filter(|k| values[*k] > RANK).collect();
        let basis = beside(&first, &left.select_columns(&own));
        Self { residuals: basis.tr_mul(&residuals), derivatives: basis.tr_mul(&slopes), size }
    }

    /// Friction as a whole alone, as far as no sensor could make it look so.
    fn level([factor, residuals, slopes]: [DMatrix<f64>; 3], sensors: &[usize]) -> Self {
        let own = orthogonal(factor, &slopes.select_columns(sensors));
        let size = own.norm_squared();
        let first = own / size.sqrt();
        Self { residuals: first.tr_mul(&residuals), derivatives: first.tr_mul(&slopes), size }
    }
}

/// Information about the parameters, its right side, and how likely the residuals are.
struct Information {
    whole: DMatrix<f64>,
    right: DMatrix<f64>,
    likely: f64,
}

fn information(seen: &[Seen], tau: f64, noise: f64) -> Information {
    let count = seen[0].derivatives.ncols();
    let (mut whole, mut right, mut likely) =
        (FLAT * DMatrix::<f64>::identity(count, count), DMatrix::zeros(count, 1), 0.0);
    for Seen { residuals, derivatives, size } in seen {
        let variance = tau * tau * size + noise;
        whole += derivatives.tr_mul(derivatives) / variance;
        right += derivatives.tr_mul(residuals) / variance;
        likely -= 0.5 * (residuals.len() as f64 * libm::log(variance) + residuals.norm_squared() / variance);
    }
    let logarithm: f64 = whole.clone().lu().u().diagonal().iter().map(|value| libm::log(value.abs())).sum();
    likely += 0.5 * (right.dot(&solved(&whole, &right)) - logarithm);
    Information { whole, right, likely }
}

/// Variance of the residuals beside factors and parameters, for autocorrelated samples.
///
/// Variance of the residuals that the columns leave, times the number of samples that count as one: by how much the sums over blocks
/// of the products with a column vary more than sums of independent samples, as the median over the columns and at least 1.
fn noise(columns: &DMatrix<f64>, residuals: &DMatrix<f64>, blocks: &[usize]) -> f64 {
    let rest = residuals - columns * (pseudo_inverse(columns, NO_INFORMATION) * residuals);
    let number = blocks.iter().max().map_or(0, |last| last + 1);
    let ratio = |column: nalgebra::DMatrixView<'_, f64>| {
        let (mut sums, mut squares) = (vec![0.0; number], 0.0);
        for ((value, rest), block) in column.iter().zip(rest.iter()).zip(blocks) {
            sums[*block] += value * rest;
            squares += (value * rest) * (value * rest);
        }
        sums.iter().map(|sum| sum * sum).sum::<f64>() / squares.max(1e-300)
    };
    let ratios: Vec<f64> = (0..columns.ncols()).map(|place| ratio(columns.columns(place, 1))).collect();
    rest.norm_squared() / rest.len() as f64 * median(&ratios).max(1.0)
}

/// Share by which friction is measured to be more than simulated, and half the interval of it.
///
/// What sensors do is found along with it.
fn measured(left: &Left, factor: &DMatrix<f64>, blocks: &[usize], sensors: &[usize]) -> (f64, f64) {
    let columns = beside(factor, &left.derivatives.select_columns(sensors));
    let (square, right) = (columns.tr_mul(&columns), columns.tr_mul(&left.residuals));
    let of = |square: DMatrix<f64>, right: DMatrix<f64>| (pseudo_inverse(&square, 1e-12) * right)[(0, 0)];
    let whole = of(square.clone(), right.clone());
    let number = blocks.iter().max().map_or(0, |last| last + 1);
    if number < 2 {
        return (whole, f64::INFINITY);
    }
    let without = |block: usize| {
        let rows: Vec<usize> = (0..blocks.len()).filter(|row| blocks[*row] == block).collect();
        let part = columns.select_rows(&rows);
        of(&square - part.tr_mul(&part), &right - part.tr_mul(&left.residuals.select_rows(&rows)))
    };
    let squares: Vec<f64> = (0..number).map(without).map(|one| (one - whole) * (one - whole)).collect();
    (whole, student(number - 1) * ((number - 1) as f64 * mean(&squares)).sqrt())
}

/// Mean magnitude of friction as it is simulated, and the derivatives of its logarithm by inner values.
fn mean_friction(study: &Study, x: &[f64], workers: &dyn Workers) -> Result<(f64, Vec<f64>), Interrupted> {
    let count = study.parameters.len();
    let mut vectors = vec![x.to_vec()];
    for (place, parameter) in study.parameters.iter().enumerate() {
        let [low, high] = parameter.inner_bounds();
        for end in [(x[place] + INNER_STEP).min(high), (x[place] - INNER_STEP).max(low)] {
            let mut moved = x.to_vec();
            moved[place] = end;
            vectors.push(moved);
        }
    }
    let simulation = study.simulation(workers);
    let (runs, segments) = (&simulation.runs, study.segments.len());
    let points: Vec<_> = vectors.iter().map(|x| runs.point(x)).collect();
    let every = simulation.each(segments * vectors.len(), |piece, goes_on| {
        let (vector, place) = (piece / segments, piece % segments);
        let given = runs.given(place, &points[vector]);
        let friction = runs.recorded(place, &given, &["frictionForce"], TOLERANCE, goes_on).outputs.swap_remove(0);
        let segment = &study.segments[place];
        let course = interpolate(segment.record.time.iter().copied(), &segment.record.grid, &friction);
        let used = course.iter().zip(&segment.used).filter(|(_, is_used)| **is_used);
        used.fold((0.0, 0), |(sum, number), (friction, _)| (sum + friction.abs(), number + 1))
    })?;
    let of_vector = |own: &[(f64, usize)]| {
        own.iter().map(|(sum, _)| sum).sum::<f64>() / own.iter().map(|(_, number)| number).sum::<usize>() as f64
    };
    let means: Vec<f64> = every.chunks(segments).map(of_vector).collect();
    let slope = |place: usize| {
        let (up, down) = (1 + 2 * place, 2 + 2 * place);
        libm::log(means[up] / means[down]) / (vectors[up][place] - vectors[down][place])
    };
    Ok((means[0], (0..count).map(slope).collect()))
}

/// Places of estimated parameters of sensors.
fn of_sensors(parameters: &[Parameter]) -> Vec<usize> {
    let is_one =
        |place: &usize| parameters[*place].name.split('.').next().is_some_and(|kind| OF_SENSORS.contains(&kind));
    (0..parameters.len()).filter(is_one).collect()
}

/// Probability of less than a value in a mixture of normal distributions.
fn mixture(shares: &[f64], means: &[f64], deviations: &[f64], value: f64) -> f64 {
    let parts = shares.iter().zip(means).zip(deviations);
    parts.map(|((share, mean), deviation)| share * normal((value - mean) / deviation)).sum()
}

/// Where a rising function has a value, between two ends.
fn crossing(of: impl Fn(f64) -> f64, value: f64, mut low: f64, mut high: f64) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high || !middle.is_finite() {
            return middle;
        }
        if of(middle) < value { low = middle } else { high = middle }
    }
}

/// Columns of two matrices.
fn beside(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = left.clone().resize_horizontally(left.ncols() + right.ncols(), 0.0);
    both.columns_mut(left.ncols(), right.ncols()).copy_from(right);
    both
}

/// Solution of linear equations.
fn solved(whole: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let none = || DMatrix::from_element(right.nrows(), right.ncols(), f64::NAN);
    whole.clone().lu().solve(right).unwrap_or_else(none)
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::numbers::random;

    use super::*;

    fn noisy(rows: usize, columns: usize, state: &mut u64) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| random::normal(state))
    }

    fn left(residuals: DMatrix<f64>, derivatives: DMatrix<f64>) -> Left {
        let rows = residuals.nrows();
        Left { weights: vec![1.0; rows], residuals, derivatives, begins: DMatrix::zeros(rows, 0) }
    }

    fn assert_close(found: f64, expected: f64, within: f64) {
        assert!((found - expected).abs() <= within, "{found}, not {expected}");
    }

    #[test]
    fn a_quantile_of_a_mixture_has_the_level_below_it() {
        let below = |value| mixture(&[0.3, 0.7], &[-1.0, 2.0], &[0.5, 0.1], value);
        // Of a single distribution, by tables.
        assert_close(crossing(|value| mixture(&[1.0], &[3.0], &[2.0], value), 0.975, -9.0, 99.0), 6.919_927_969, 1e-8);
        for level in [0.025, 0.5, 0.975] {
            assert_close(below(crossing(below, level, -9.0, 9.0)), level, 1e-14);
        }
    }

    /// Of two conditions with an error of their own each; nothing else is known of the parameters.
    #[test]
    fn information_of_conditions_is_that_of_weighted_least_squares() {
        let (mut state, noise, sizes) = (2, 0.5, [4.0, 25.0]);
        let rows = noisy(6, 2, &mut state);
        let residuals = noisy(6, 1, &mut state);
        let of = |k: usize| Seen {
            residuals: residuals.rows(3 * k, 3).into_owned(),
            derivatives: rows.rows(3 * k, 3).into_owned(),
            size: sizes[k],
        };
        let seen = [of(0), of(1)];
        // Residuals that the parameters cannot change have the likelihood of the remainder.
        let basis = rows.clone().qr().q();
        let projector = DMatrix::<f64>::identity(6, 6) - &basis * basis.transpose();
        let eigen = projector.symmetric_eigen();
        let beyond: Vec<usize> = (0..6).filter(|place| eigen.eigenvalues[*place] > 0.5).collect();
        let beside = eigen.eigenvectors.select_columns(&beyond);
        assert_eq!(beside.ncols(), 4);
        let differences = [0.1, 0.3].map(|tau: f64| {
            let Information { whole, right, likely } = information(&seen, tau, noise);
            let variances: Vec<f64> = (0..6).map(|row| tau * tau * sizes[row / 3] + noise).collect();
            let weigh = |matrix: &DMatrix<f64>| {
                DMatrix::from_fn(6, matrix.ncols(), |row, column| matrix[(row, column)] / variances[row].sqrt())
            };
            let weighted = pseudo_inverse(&weigh(&rows), 1e-12) * weigh(&residuals);
            // The least that is known beforehand, 1e-9, moves them by as much.
            assert!((solved(&whole, &right) - weighted).norm() < 1e-8);
            let covariance = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(variances));
            let spread = beside.tr_mul(&(covariance * &beside));
            let rest = beside.tr_mul(&residuals);
            let density = -0.5 * (libm::log(spread.determinant()) + rest.dot(&solved(&spread, &rest)));
            likely - density
        });
        // But for a constant.
        assert_close(differences[1], differences[0], 1e-8);
    }

    /// In pairs they double the variance of a mean; where neighbours cancel, it is no less than for white noise.
    #[test]
    fn autocorrelated_residuals_count_as_fewer() {
        let (columns, blocks) = (DMatrix::from_element(8, 1, 1.0), [0, 0, 1, 1, 2, 2, 3, 3]);
        let pairs = [1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0];
        let turns = [6.0, 4.0, 6.0, 4.0, 6.0, 4.0, 6.0, 4.0];
        assert_close(noise(&columns, &DMatrix::from_column_slice(8, 1, &pairs), &blocks), 2.0, 1e-14);
        assert_close(noise(&columns, &DMatrix::from_column_slice(8, 1, &turns), &blocks), 1.0, 1e-14);
    }

    /// With friction of 1 everywhere, its share is the mean, and omitted blocks give the error of their means.
    #[test]
    fn friction_is_measured_with_the_error_of_a_mean_of_blocks() {
        let residuals = noisy(40, 1, &mut 3);
        let values: Vec<f64> = residuals.iter().copied().collect();
        let (left, factor) = (left(residuals, DMatrix::zeros(40, 0)), DMatrix::from_element(40, 1, 1.0));
        let error = |size: usize| {
            let means: Vec<f64> = values.chunks(size).map(mean).collect();
            let number = means.len() as f64;
            let squares: f64 = means.iter().map(|one| (one - mean(&values)) * (one - mean(&values))).sum();
            student(means.len() - 1) * (squares / (number - 1.0) / number).sqrt()
        };
        // Two blocks are enough for one degree of freedom.
        for size in [4, 20] {
            let blocks: Vec<usize> = (0..40).map(|row| row / size).collect();
            let (share, half) = measured(&left, &factor, &blocks, &[]);
            assert_close(share, mean(&values), 1e-14);
            assert_close(half, error(size), 1e-12);
        }
        assert_eq!(measured(&left, &factor, &[0; 40], &[]).1, f64::INFINITY);
    }

    /// Two parameters follow two conditions, if they do not change both alike but for a part in 100 000.
    #[test]
    fn the_error_of_a_law_is_told_only_by_conditions_that_it_cannot_follow() {
        for (apart, is_told) in [(1e-5, true), (0.1, false)] {
            let slopes = DMatrix::from_fn(200, 2, |row, column| match (column, row / 100) {
                (0, _) => 1.0,
                (_, 0) => 0.0,
                _ => apart,
            });
            let factors = DMatrix::from_fn(200, 2, |row, column| if row / 100 == column { 1.0 } else { 0.0 });
            let blocks: Vec<usize> = (0..200).map(|row| row / 10).collect();
            let found = left(0.01 * noisy(200, 1, &mut 4), slopes);
            let [low, middle, high, spread] = predicted(&found, &factors, &blocks, &[1.0, 0.0], &[], 0.2);
            assert_eq!(spread.is_finite(), is_told, "{apart}: {spread}");
            assert!(low < middle && middle < high, "{low}, {middle}, {high}");
        }
    }
}
