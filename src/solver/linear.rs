//! The linear systems of the implicit schemes.

use std::ops::Range;

use nalgebra::SMatrix;

use crate::hybrid::Groups;

/// The inverse of `shift*I - J`, by blocks.
///
/// One inversion serves all stages of a step, and multiplying by an inverse of this size has none of the serial
/// dependencies of a substitution. Gauss-Jordan elimination runs in the given order of the states without pivoting:
/// as the step shrinks, `shift` grows and the matrix approaches a multiple of the identity, so a bad pivot shows as a
/// rejected step, never as a wrong answer.
///
/// By hand, because the zeros of the [`Groups`] are skipped and all loops have bounds that the compiler knows: the
/// inversion and the six solutions of a Rosenbrock step take 1535 instructions for 8 states in groups of 2, 4 and 2, 1868
/// for 9 and 11834 for 18; the LU decomposition of nalgebra with six solutions takes 4147, 4953 and 24915 (callgrind,
/// release, x86-64). The benchmark `calls` times both. The matrices are those of nalgebra.
#[derive(Clone, Debug)]
pub struct Inverse<const N: usize> {
    /// `J - shift*I`, with inverses in the places of `A`, `C` and `F` (of `F` as it is after elimination of the second
    /// group), and `-C^-1*D` in that of `D`.
    columns: [[f64; N]; N],
}

impl<const N: usize> Inverse<N> {
    /// Inverts `shift*I - jacobian`; `None` if a pivot is zero or not finite.
    #[inline(always)]
    pub fn new(jacobian: &SMatrix<f64, N, N>, shift: f64, groups: Groups) -> Option<Self> {
        let mut columns: [[f64; N]; N] = std::array::from_fn(|j| std::array::from_fn(|i| jacobian[(i, j)]));
        for (k, column) in columns.iter_mut().enumerate() {
            column[k] -= shift;
        }
        let [first, second, third] = ranges::<N>(groups);
        invert(&mut columns, first)?;
        invert(&mut columns, second.clone())?;
        let (before, after) = columns.split_at_mut(third.start);
        for column in after {
            solve(before, second.clone(), column);
            add(before, second.clone(), third.clone(), column);
        }
        invert(&mut columns, third)?;
        Some(Self { columns })
    }

    /// The solution for a right-hand side; the groups are those of the inversion.
    #[inline(always)]
    pub fn times(&self, right: &[f64; N], groups: Groups) -> [f64; N] {
        let [first, second, third] = ranges::<N>(groups);
        let (columns, mut solution) = (&self.columns, *right);
        solve(columns, first.clone(), &mut solution);
        add(columns, first, second.clone(), &mut solution);
        solve(columns, second.clone(), &mut solution);
        add(columns, second.clone(), third.clone(), &mut solution);
        solve(columns, third.clone(), &mut solution);
        add(columns, third, second, &mut solution);
        solution
    }
}

#[inline(always)]
fn ranges<const N: usize>([second, third]: Groups) -> [Range<usize>; 3] {
    [0..second, second..third, third..N]
}

/// Inverts a block on the diagonal in place.
#[inline(always)]
fn invert<const N: usize>(columns: &mut [[f64; N]; N], block: Range<usize>) -> Option<()> {
    for k in block.clone() {
        let inverse_pivot = 1.0 / columns[k][k];
        if !inverse_pivot.is_finite() {
            return None;
        }
        let multipliers = columns[k].map(|entry| entry * inverse_pivot);
        for j in block.clone() {
            if j != k {
                let entry = columns[j][k];
                for i in block.clone() {
                    columns[j][i] -= entry * multipliers[i];
                }
                columns[j][k] = entry * inverse_pivot;
            }
        }
        for i in block.clone() {
            columns[k][i] = -multipliers[i];
        }
        columns[k][k] = inverse_pivot;
    }
    Some(())
}

/// Multiplies a part of a vector by an inverted block on the diagonal, and changes its sign.
#[inline(always)]
fn solve<const N: usize>(columns: &[[f64; N]], block: Range<usize>, vector: &mut [f64; N]) {
    let right = *vector;
    vector[block.clone()].fill(0.0);
    for k in block.clone() {
        for i in block.clone() {
            vector[i] -= right[k] * columns[k][i];
        }
    }
}

/// Adds a part of a vector, multiplied by a block, to another part.
#[inline(always)]
fn add<const N: usize>(columns: &[[f64; N]], from: Range<usize>, to: Range<usize>, vector: &mut [f64; N]) {
    for k in from {
        let factor = vector[k];
        for i in to.clone() {
            vector[i] += factor * columns[k][i];
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
        let y = Inverse::new(&jacobian, 10.0, [0, 0]).unwrap().times(&right, [0, 0]);
        for i in 0..4 {
            let left: f64 = (0..4).map(|j| (if i == j { 10.0 } else { 0.0 } - jacobian[(i, j)]) * y[j]).sum();
            assert!((left - right[i]).abs() < 1e-12, "row {i}: {left} is not {}", right[i]);
        }
    }

    #[test]
    fn a_zero_pivot_is_reported() {
        let jacobian = SMatrix::<f64, 2, 2>::new(5.0, 1.0, 1.0, 0.0);
        assert!(Inverse::new(&jacobian, 5.0, [0, 0]).is_none());
    }

    #[test]
    fn groups_change_nothing_but_the_cost() {
        let jacobian = SMatrix::<f64, 5, 5>::from_row_slice(&[
            -3.0, 0.0, 0.0, 0.0, 0.0, //
            0.5, -7.0, 1.0, 0.3, -2.0, //
            4.0, 2.0, -1e6, 3.0, 50.0, //
            0.0, 0.0, 1e3, -2.0, 0.7, //
            0.0, 6.0, -0.1, 1.0, 0.0,
        ]);
        let right = [1.0, -2.0, 3.0, 0.5, 0.1];
        let solve = |groups| Inverse::new(&jacobian, 10.0, groups).unwrap().times(&right, groups);
        for (grouped, plain) in solve([1, 3]).iter().zip(solve([0, 0])) {
            assert!((grouped - plain).abs() < 1e-14 * plain.abs().max(1.0), "{grouped} is not {plain}");
        }
    }
}
