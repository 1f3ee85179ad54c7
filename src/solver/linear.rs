//! The linear systems of the implicit schemes.

use nalgebra::SMatrix;

/// The inverse of `shift*I - J`.
///
/// One inversion serves all stages of a step, and multiplying by an inverse of this size has none of the serial
/// dependencies of a substitution. Gauss-Jordan elimination runs in the given order of the states without pivoting:
/// as the step shrinks, `shift` grows and the matrix approaches a multiple of the identity, so a bad pivot shows as a
/// rejected step, never as a wrong answer. Zero couplings are skipped.
#[derive(Clone, Debug)]
pub struct Inverse<const N: usize> {
    columns: [[f64; N]; N],
}

impl<const N: usize> Inverse<N> {
    /// Inverts `shift*I - jacobian`; `None` if a pivot is zero or not finite.
    #[inline(always)]
    pub fn new(jacobian: &SMatrix<f64, N, N>, shift: f64) -> Option<Self> {
        let mut columns: [[f64; N]; N] = std::array::from_fn(|j| std::array::from_fn(|i| -jacobian[(i, j)]));
        for (k, column) in columns.iter_mut().enumerate() {
            column[k] += shift;
        }
        for k in 0..N {
            let inverse_pivot = 1.0 / columns[k][k];
            if !inverse_pivot.is_finite() {
                return None;
            }
            let multipliers = columns[k].map(|entry| entry * inverse_pivot);
            for (j, column) in columns.iter_mut().enumerate() {
                let entry = column[k];
                if j != k && entry != 0.0 {
                    for i in 0..N {
                        column[i] -= entry * multipliers[i];
                    }
                    column[k] = entry * inverse_pivot;
                }
            }
            columns[k] = multipliers.map(|multiplier| -multiplier);
            columns[k][k] = inverse_pivot;
        }
        Some(Self { columns })
    }

    /// The solution for a right-hand side.
    #[inline(always)]
    pub fn times(&self, right: &[f64; N]) -> [f64; N] {
        let mut solution = [0.0; N];
        for (column, factor) in self.columns.iter().zip(right) {
            for i in 0..N {
                solution[i] += factor * column[i];
            }
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solution_satisfies_the_equations() {
        let jacobian = SMatrix::<f64, 4, 4>::from_row_slice(&[
            -3.0, 1.0, 0.0, 2.0, //
            0.5, -7.0, 1.0, 0.0, //
            0.0, 4.0, -1e6, 3.0, //
            1.0, 0.0, 1e3, -2.0,
        ]);
        let right = [1.0, -2.0, 3.0, 0.5];
        let y = Inverse::new(&jacobian, 10.0).unwrap().times(&right);
        for i in 0..4 {
            let left: f64 = (0..4).map(|j| (if i == j { 10.0 } else { 0.0 } - jacobian[(i, j)]) * y[j]).sum();
            assert!((left - right[i]).abs() < 1e-12, "row {i}: {left} is not {}", right[i]);
        }
    }

    #[test]
    fn a_zero_pivot_is_reported() {
        let jacobian = SMatrix::<f64, 2, 2>::new(5.0, 1.0, 1.0, 0.0);
        assert!(Inverse::new(&jacobian, 5.0).is_none());
    }
}
