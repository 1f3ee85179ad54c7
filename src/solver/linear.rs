//! The linear systems of the implicit schemes.

use nalgebra::SMatrix;

/// The factorised matrix `shift*I - J`.
///
/// Eliminates in the given order of the states without pivoting: as the step shrinks, `shift` grows and the matrix
/// approaches a multiple of the identity, so a bad pivot shows as a rejected step, never as a wrong answer. Models
/// number their states so that sparse couplings stay sparse; zero couplings are skipped.
#[derive(Clone, Debug)]
pub struct Factors<const N: usize> {
    /// Multipliers below the diagonal, column by column, zero elsewhere.
    lower: [[f64; N]; N],
    /// Entries above the diagonal, column by column, zero elsewhere.
    upper: [[f64; N]; N],
    inverse_pivots: [f64; N],
}

impl<const N: usize> Factors<N> {
    /// Factorises `shift*I - jacobian`; `None` if a pivot is zero or not finite.
    pub fn new(jacobian: &SMatrix<f64, N, N>, shift: f64) -> Option<Self> {
        let mut columns: [[f64; N]; N] = std::array::from_fn(|j| std::array::from_fn(|i| -jacobian[(i, j)]));
        for (k, column) in columns.iter_mut().enumerate() {
            column[k] += shift;
        }
        let mut factors = Self { lower: [[0.0; N]; N], upper: [[0.0; N]; N], inverse_pivots: [0.0; N] };
        for k in 0..N {
            let inverse_pivot = 1.0 / columns[k][k];
            if !inverse_pivot.is_finite() {
                return None;
            }
            factors.inverse_pivots[k] = inverse_pivot;
            for i in 0..N {
                let entry = columns[k][i];
                if i < k {
                    factors.upper[k][i] = entry;
                } else if i > k {
                    factors.lower[k][i] = entry * inverse_pivot;
                }
            }
            let multipliers = &factors.lower[k];
            for column in &mut columns[k + 1..] {
                let entry = column[k];
                if entry != 0.0 {
                    for i in 0..N {
                        column[i] -= entry * multipliers[i];
                    }
                }
            }
        }
        Some(factors)
    }

    /// Solves in place.
    pub fn solve(&self, y: &mut [f64; N]) {
        for k in 0..N {
            let pivot = y[k];
            for i in 0..N {
                y[i] -= pivot * self.lower[k][i];
            }
        }
        for k in (0..N).rev() {
            let solved = y[k] * self.inverse_pivots[k];
            for i in 0..N {
                y[i] -= solved * self.upper[k][i];
            }
            y[k] = solved;
        }
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
        let mut y = right;
        Factors::new(&jacobian, 10.0).unwrap().solve(&mut y);
        for i in 0..4 {
            let left: f64 = (0..4).map(|j| (if i == j { 10.0 } else { 0.0 } - jacobian[(i, j)]) * y[j]).sum();
            assert!((left - right[i]).abs() < 1e-12, "row {i}: {left} is not {}", right[i]);
        }
    }

    #[test]
    fn a_zero_pivot_is_reported() {
        let jacobian = SMatrix::<f64, 2, 2>::new(5.0, 1.0, 1.0, 0.0);
        assert!(Factors::new(&jacobian, 5.0).is_none());
    }
}
