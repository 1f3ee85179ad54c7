//! Singular values with the same bits everywhere.

use nalgebra::DMatrix;

/// Sweeps of rotations at most; about eight are enough.
const SWEEPS: usize = 60;

/// A singular value decomposition.
#[derive(Clone, Debug, PartialEq)]
pub struct Singular {
    /// Singular values, the largest first.
    pub values: Vec<f64>,
    /// Left directions as columns; zeros of a value that is 0.
    pub left: DMatrix<f64>,
    /// Right directions as columns.
    pub right: DMatrix<f64>,
}

impl Singular {
    /// Decomposes a matrix by rotations of its columns until these are orthogonal (M. R. Hestenes, J. SIAM 6, 1958). They take nothing
    /// but square roots, which have the same bits everywhere; nalgebra takes `hypot`, which has not.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        if matrix.nrows() < matrix.ncols() {
            let Self { values, left, right } = Self::of(&matrix.transpose());
            return Self { values, left: right, right: left };
        }
        let (rows, count) = matrix.shape();
        let largest = matrix.amax();
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let (mut left, mut right) = (matrix / scale, DMatrix::identity(count, count));
        let near = f64::EPSILON * (rows as f64).sqrt();
        for _ in 0..SWEEPS {
            let mut is_turned = false;
            for one in 0..count {
                for other in one + 1..count {
                    is_turned |= turn(&mut left, &mut right, one, other, near);
                }
            }
            if !is_turned {
                break;
            }
        }
        let lengths: Vec<f64> = left.column_iter().map(|column| column.norm()).collect();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|one, other| lengths[*other].total_cmp(&lengths[*one]));
        for (mut column, length) in left.column_iter_mut().zip(&lengths) {
            column /= if *length > 0.0 { *length } else { 1.0 };
        }
        Self {
            values: order.iter().map(|place| scale * lengths[*place]).collect(),
            left: left.select_columns(&order),
            right: right.select_columns(&order),
        }
    }
}

/// Makes two columns orthogonal, unless they are.
fn turn(left: &mut DMatrix<f64>, right: &mut DMatrix<f64>, one: usize, other: usize, near: f64) -> bool {
    let [own, others] = [one, other].map(|place| left.column(place).norm_squared());
    let both = left.column(one).dot(&left.column(other));
    let ratio = 0.5 * (others - own) / both;
    let tangent = 1f64.copysign(ratio) / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
    if !(both.abs() > near * own.sqrt() * others.sqrt() && tangent != 0.0) {
        return false;
    }
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = cosine * tangent;
    for matrix in [left, right] {
        for row in 0..matrix.nrows() {
            let (a, b) = (matrix[(row, one)], matrix[(row, other)]);
            matrix[(row, one)] = cosine * a - sine * b;
            matrix[(row, other)] = sine * a + cosine * b;
        }
    }
    true
}

/// Pseudo-inverse; singular values below a share of the largest count as 0.
pub fn pseudo_inverse(matrix: &DMatrix<f64>, share: f64) -> DMatrix<f64> {
    let Singular { values, left, mut right } = Singular::of(matrix);
    let least = share * values.first().copied().unwrap_or(0.0);
    for (mut column, value) in right.column_iter_mut().zip(values) {
        column *= if value > least && value > 0.0 { 1.0 / value } else { 0.0 };
    }
    right * left.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |row, column| libm::sin((1 + row * (column + 2)) as f64))
    }

    #[test]
    fn pseudo_inverse_leaves_out_what_has_no_rank() {
        let mut matrix = sample(5, 3);
        let copy = matrix.column(0) * 2.0;
        matrix.set_column(2, &copy);
        let inverse = pseudo_inverse(&matrix, 1e-7);
        assert!((&matrix * inverse * &matrix - matrix).norm() < 1e-12);
    }

    #[test]
    fn a_matrix_is_the_product_of_its_directions_and_singular_values() {
        let mut graded = sample(6, 3);
        graded.column_mut(0).scale_mut(1e-9);
        let product = sample(5, 2) * sample(2, 4);
        for matrix in [sample(40, 4), sample(3, 5), sample(1, 1), graded, product, DMatrix::zeros(3, 2)] {
            let Singular { values, left, right } = Singular::of(&matrix);
            assert!(values.is_sorted_by(|one, other| one >= other), "{values:?}");
            let whole = &left * DMatrix::from_diagonal(&values.clone().into()) * right.transpose();
            assert!((whole - &matrix).norm() <= 1e-14 * matrix.norm(), "{matrix}");
            assert!(
                (right.tr_mul(&right) - DMatrix::identity(right.ncols(), right.ncols())).norm() < 1e-14
                    || right.nrows() > right.ncols()
            );
            let expected = matrix.svd(false, false).singular_values;
            for (value, expected) in values.iter().zip(&expected) {
                assert!((value - expected).abs() <= 1e-14 * expected.max(1.0), "{values:?}, {expected}");
            }
        }
    }
}
