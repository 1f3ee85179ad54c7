//! Tall matrices of least squares.

pub use nalgebra::DMatrix;
pub use pneumatic_servo::numbers::{Singular, pseudo_inverse};

/// Rows that are decomposed at once, as far as they are at least four times as many as the columns.
const ROWS: usize = 1000;

/// A matrix from its numbers row by row.
pub fn from_rows(rows: usize, columns: usize, numbers: impl IntoIterator<Item = f64>) -> DMatrix<f64> {
    DMatrix::from_row_iterator(rows, columns, numbers)
}

/// The factor `R` of a QR decomposition: `R'R` is `A'A`.
pub fn triangle(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let count = matrix.ncols();
    let size = ROWS.max(4 * count);
    let mut above = DMatrix::zeros(0, count);
    for first in (0..matrix.nrows()).step_by(size) {
        let rows = size.min(matrix.nrows() - first);
        let mut block = DMatrix::zeros((above.nrows() + rows).max(count), count);
        block.rows_mut(0, above.nrows()).copy_from(&above);
        block.rows_mut(above.nrows(), rows).copy_from(&matrix.rows(first, rows));
        above = block.qr().r();
    }
    if above.nrows() == 0 { DMatrix::zeros(count, count) } else { above }
}

/// The part of some columns that is orthogonal to others.
pub fn orthogonal(columns: DMatrix<f64>, others: &DMatrix<f64>) -> DMatrix<f64> {
    // A column of zeros has no direction that could be taken away.
    let others: Vec<_> = others.column_iter().filter(|column| column.iter().any(|value| *value != 0.0)).collect();
    if others.is_empty() {
        return columns;
    }
    let basis = DMatrix::from_columns(&others).qr().q();
    let mut rest = columns;
    // Twice is enough for all digits (B. N. Parlett, The Symmetric Eigenvalue Problem, 1980).
    for _ in 0..2 {
        let shares = basis.tr_mul(&rest);
        rest -= &basis * shares;
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |row, column| libm::sin((1 + row * (column + 2)) as f64))
    }

    #[test]
    fn triangle_keeps_the_products_of_columns() {
        for rows in [2, 3, 40, 2500] {
            let matrix = sample(rows, 3);
            let found = triangle(&matrix);
            assert_eq!(found.shape(), (3, 3));
            assert!((found.tr_mul(&found) - matrix.tr_mul(&matrix)).norm() < 1e-9, "{rows}");
        }
    }

    #[test]
    fn the_rest_is_orthogonal() {
        let others = sample(50, 2);
        assert!(others.tr_mul(&orthogonal(sample(50, 4), &others)).norm() < 1e-12);
    }
}
