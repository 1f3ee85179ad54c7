//! Linear least squares with factors that are not negative.

use nalgebra::{DMatrix, DVector};

use crate::matrix::{pseudo_inverse, triangle};

/// Slope by which a factor of 0 has to lower the distance, with columns and right side of length 1.
const FLAT: f64 = 1e-13;
/// Changes of the factors that are 0, for each column, at most.
const MOST: usize = 3;

/// The factors, none of them negative, of columns whose sum comes closest to a right side (C. L. Lawson, R. J. Hanson, Solving
/// Least Squares Problems, 1974, chapter 23).
pub fn nonnegative(columns: &DMatrix<f64>, right: &[f64]) -> Vec<f64> {
    let right = DVector::from_column_slice(right);
    let (count, size) = (columns.ncols(), right.norm());
    let norms: Vec<f64> = columns.column_iter().map(|column| column.norm()).collect();
    if size == 0.0 {
        return vec![0.0; count];
    }
    let mut whole = columns.clone().insert_column(count, 0.0);
    let used = |column: &usize| norms[*column] > 0.0;
    (0..count).filter(used).for_each(|column| whole.column_mut(column).unscale_mut(norms[column]));
    whole.column_mut(count).copy_from(&(right / size));
    let whole = triangle(&whole);
    let (columns, right) = (whole.columns(0, count).into_owned(), whole.column(count).into_owned());
    let mut factors = DVector::zeros(count);
    let mut free = vec![false; count];
    for _ in 0..MOST * count {
        let slopes = columns.tr_mul(&(&right - &columns * &factors));
        let steepest = (0..count).filter(|place| !free[*place]).max_by(|a, b| slopes[*a].total_cmp(&slopes[*b]));
        let Some(place) = steepest.filter(|place| slopes[*place] > FLAT) else { break };
        free[place] = true;
        while !approach(&columns, &right, &mut free, &mut factors) {}
    }
    (0..count).map(|place| if used(&place) { factors[place] * size / norms[place] } else { 0.0 }).collect()
}

/// Moves the factors to the least squares of those that are free, or as far as none becomes negative: the first that would
/// become so is 0 from then on. Returns whether the least squares were reached.
fn approach(columns: &DMatrix<f64>, right: &DVector<f64>, free: &mut [bool], factors: &mut DVector<f64>) -> bool {
    let places: Vec<usize> = (0..free.len()).filter(|place| free[*place]).collect();
    if places.is_empty() {
        return true;
    }
    let own = columns.select_columns(&places);
    let decomposed = own.clone().qr();
    let solved = decomposed.r().solve_upper_triangular(&decomposed.q().tr_mul(right));
    let best = solved.filter(|best| best.iter().all(|value| value.is_finite()));
    let best = best.unwrap_or_else(|| pseudo_inverse(&own, f64::EPSILON) * right);
    let share = |(at, place): (usize, &usize)| {
        let (now, then) = (factors[*place], best[at]);
        (then <= 0.0).then_some((now / (now - then).max(f64::MIN_POSITIVE), *place))
    };
    let first = places.iter().enumerate().filter_map(share).min_by(|a, b| a.0.total_cmp(&b.0));
    let way = first.map_or(1.0, |(share, _)| share);
    for (at, place) in places.iter().enumerate() {
        factors[*place] += way * (best[at] - factors[*place]);
    }
    let Some((_, end)) = first else { return true };
    (free[end], factors[end]) = (false, 0.0);
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_that_would_be_negative_is_left_out() {
        let columns = DMatrix::from_fn(60, 3, |row, column| {
            libm::cos((row * (column + 1)) as f64 * 0.05) * (column as f64 + 1.0)
        });
        for factors in [[2.0, 0.5, 1e3], [0.0, 3.0, 1.0]] {
            let found = nonnegative(&columns, (&columns * DVector::from_column_slice(&factors)).as_slice());
            let near = |(found, expected): (&f64, &f64)| (found - expected).abs() < 1e-12 * factors[2].max(1.0);
            assert!(found.iter().zip(&factors).all(near), "{found:?}, not {factors:?}");
        }
        let found = nonnegative(&columns, (&columns * DVector::from_column_slice(&[1.0, -1.0, 0.0])).as_slice());
        assert!(found.iter().all(|factor| *factor >= 0.0) && found[1] == 0.0, "{found:?}");
        assert_eq!(nonnegative(&DMatrix::zeros(5, 2), &[1.0; 5]), [0.0, 0.0]);
    }
}
