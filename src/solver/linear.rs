//! The linear systems of the implicit schemes.
//!
//! The matrix of a chain is factorised without its zeros, any other inverted, by blocks where its couplings are grouped.

use std::ops::Range;

use nalgebra::SMatrix;

use crate::system::{Groups, bits};

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
/// release, x86-64). The benchmark `calls` times both. Jacobians come as matrices of nalgebra.
#[derive(Clone, Debug)]
pub struct Inverse<const N: usize> {
    /// `J - shift*I`, with inverses in the places of `A`, `C` and `F` (of `F` as it is after elimination of the second
    /// group), and `-C^-1*D` in the place of `D`.
    columns: [[f64; N]; N],
}

/// Solves the linear systems of a step. Its groups are constants of the type of system, with bounds that the compiler knows.
#[derive(Clone, Debug)]
pub enum Solver<const N: usize> {
    /// For few states, or couplings that are grouped.
    Inverse(Inverse<N>),
    /// For chains.
    Factors(Factors<N>),
}

impl<const N: usize> Solver<N> {
    /// Prepares for `shift*I - jacobian`, whose sparsity may be a chain's; `None` if a pivot is zero or not finite. The choice
    /// does not depend on the number of states that are compiled, nor do the bits of a run; but for chains of more states than
    /// a set of rows has bits.
    #[inline(always)]
    pub fn new(jacobian: &SMatrix<f64, N, N>, shift: f64, groups: Groups, is_chain: bool) -> Option<Self> {
        if is_chain && N <= u64::BITS as usize {
            Factors::new(jacobian, shift).map(Self::Factors)
        } else {
            Inverse::new(jacobian, shift, groups).map(Self::Inverse)
        }
    }

    /// The solution for a right-hand side, with the groups of the preparation.
    #[inline(always)]
    pub fn solve(&self, right: &[f64; N], groups: Groups) -> [f64; N] {
        match self {
            Self::Inverse(inverse) => inverse.times(right, groups),
            Self::Factors(factors) => factors.solve(right),
        }
    }
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

    /// The solution for a right-hand side, with the groups of the inversion.
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

/// The triangular factors of a sparse matrix.
///
/// The couplings of a chain, of hoses for example, fill few of the zeros in between: then factors take operations
/// in proportion to the number of states, and an inversion in proportion to its cube.
#[derive(Clone, Debug)]
pub struct Factors<const N: usize> {
    /// Both factors, with the inverses of the pivots on the diagonal.
    columns: [[f64; N]; N],
    /// For each column, the rows of entries that are not zero, as bits.
    filled: [u64; N],
}

impl<const N: usize> Factors<N> {
    /// Factorises `shift*I - jacobian` in the given order of the states, as [`Inverse`] inverts it; `None` if a pivot is zero or
    /// not finite.
    // A function of its own, as large as a step: inlined, it would be optimised once more with each of them.
    #[inline(never)]
    pub fn new(jacobian: &SMatrix<f64, N, N>, shift: f64) -> Option<Self> {
        let mut factors = Self { columns: jacobian.data.0, filled: [0; N] };
        for (k, column) in factors.columns.iter_mut().enumerate() {
            for (row, entry) in column.iter_mut().enumerate() {
                factors.filled[k] |= u64::from(*entry != 0.0) << row;
                *entry = -*entry;
            }
            column[k] += shift;
        }
        for k in 0..N {
            let below = below(factors.filled[k], k);
            let (before, after) = factors.columns.split_at_mut(k + 1);
            let pivot = &mut before[k];
            let inverse_pivot = 1.0 / pivot[k];
            if !inverse_pivot.is_finite() {
                return None;
            }
            pivot[k] = inverse_pivot;
            bits(below).for_each(|row| pivot[row] *= inverse_pivot);
            for (column, filled) in after.iter_mut().zip(&mut factors.filled[k + 1..]) {
                if *filled >> k & 1 == 1 {
                    let value = column[k];
                    bits(below).for_each(|row| column[row] -= value * pivot[row]);
                    *filled |= below;
                }
            }
        }
        Some(factors)
    }

    /// The solution for a right-hand side.
    #[inline(never)]
    pub fn solve(&self, right: &[f64; N]) -> [f64; N] {
        let mut solution = *right;
        for (k, (column, filled)) in self.columns.iter().zip(&self.filled).enumerate() {
            let value = solution[k];
            bits(below(*filled, k)).for_each(|row| solution[row] -= value * column[row]);
        }
        for (k, (column, filled)) in self.columns.iter().zip(&self.filled).enumerate().rev() {
            let value = solution[k] * column[k];
            solution[k] = value;
            bits(filled & ((1 << k) - 1)).for_each(|row| solution[row] -= value * column[row]);
        }
        solution
    }
}

/// The rows below a pivot.
#[inline(always)]
fn below(rows: u64, k: usize) -> u64 {
    rows & !((2 << k) - 1)
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

    /// A chain whose states change each other, as the air in a hose does, with a state that all others act on.
    #[test]
    fn solution_by_factors_satisfies_the_equations() {
        const MANY: usize = 15;
        let jacobian = SMatrix::<f64, MANY, MANY>::from_fn(|i, j| match (i, j) {
            _ if i == j => -3.0,
            _ if i.abs_diff(j) == 1 => 1e4 * (i as f64 - 7.3),
            (_, j) if j == MANY - 1 => 0.3,
            (i, _) if i == MANY - 1 => -0.7,
            _ => 0.0,
        });
        let right: [f64; MANY] = std::array::from_fn(|i| 1.0 - 0.3 * i as f64);
        let y = Factors::new(&jacobian, 1e4).unwrap().solve(&right);
        for i in 0..MANY {
            let terms = (0..MANY).map(|j| (if i == j { 1e4 } else { 0.0 } - jacobian[(i, j)]) * y[j]);
            let largest = terms.clone().fold(0.0, |largest: f64, term| largest.max(term.abs()));
            // Some roundings of the largest term of the row.
            assert!((terms.sum::<f64>() - right[i]).abs() < 1e-14 * largest.max(1.0), "row {i}: {y:?}");
        }
        assert!(Factors::new(&SMatrix::<f64, MANY, MANY>::identity(), 1.0).is_none(), "a pivot of 0");
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
