//! The linear systems of the implicit schemes.

use std::ops::Range;

use nalgebra::SMatrix;

use crate::system::Groups;

/// The inverse of `shift*I - J`, by blocks.
///
/// One inversion serves all stages of a step, and multiplying by an inverse of this size has none of the serial
/// dependencies of a substitution. Gauss-Jordan elimination runs in the given order of the states without pivoting:
/// as the step shrinks, `shift` grows and the matrix approaches a multiple of the identity, so a bad pivot shows as a
/// rejected step, never as a wrong answer.
///
/// By hand, because zeros are skipped and all loops have bounds that the compiler knows: the inversion and the six solutions of
/// a Rosenbrock step take 1,300 instructions for 8 states in [`Groups`] of 2, 4 and 2, and 2,150 as a whole. For 37 states of a
/// cylinder with hoses, whose couplings are chains in no groups, they take 75,000 as a whole; a sparse LU decomposition took
/// 73,000. The LU decomposition of nalgebra takes 4,147 for 8 states and 24,915 for 18 (callgrind, release, x86-64). The
/// benchmark `calls` times both. Jacobians come as matrices of nalgebra.
#[derive(Clone, Debug)]
pub struct Inverse<const N: usize> {
    /// `J - shift*I`, with inverses in the places of `A`, `C` and `F` (of `F` as it is after elimination of the second
    /// group), and `-C^-1*D` in the place of `D`.
    columns: [[f64; N]; N],
    is_whole: bool,
}

impl<const N: usize> Inverse<N> {
    /// Inverts `shift*I - jacobian`, as a whole or by its groups; `None` if a pivot is zero or not finite.
    #[inline(always)]
    pub fn new(jacobian: &SMatrix<f64, N, N>, shift: f64, groups: Groups, is_whole: bool) -> Option<Self> {
        let mut columns = jacobian.data.0;
        for (k, column) in columns.iter_mut().enumerate() {
            column[k] -= shift;
        }
        if is_whole { invert_whole(&mut columns) } else { invert_groups(&mut columns, groups) }?;
        Some(Self { columns, is_whole })
    }

    /// The solution for a right-hand side, with the groups of the inversion.
    #[inline(always)]
    pub fn times(&self, right: &[f64; N], groups: Groups) -> [f64; N] {
        if self.is_whole { times_whole(&self.columns, right) } else { times_groups(&self.columns, right, groups) }
    }
}

// Functions of their own, as large as a step: inlined, they would be optimised once more with each of them.
#[inline(never)]
fn invert_whole<const N: usize>(columns: &mut [[f64; N]; N]) -> Option<()> {
    invert(columns, 0..N, true)
}

#[inline(never)]
fn times_whole<const N: usize>(columns: &[[f64; N]; N], right: &[f64; N]) -> [f64; N] {
    let mut solution = *right;
    solve(columns, 0..N, &mut solution);
    solution
}

#[inline(always)]
fn invert_groups<const N: usize>(columns: &mut [[f64; N]; N], groups: Groups) -> Option<()> {
    let [first, second, third] = ranges::<N>(groups);
    invert(columns, first, false)?;
    invert(columns, second.clone(), false)?;
    let (before, after) = columns.split_at_mut(third.start);
    for column in after {
        solve(before, second.clone(), column);
        add(before, second.clone(), third.clone(), column);
    }
    invert(columns, third, false)
}

#[inline(always)]
fn times_groups<const N: usize>(columns: &[[f64; N]; N], right: &[f64; N], groups: Groups) -> [f64; N] {
    let [first, second, third] = ranges::<N>(groups);
    let mut solution = *right;
    solve(columns, first.clone(), &mut solution);
    add(columns, first, second.start..N, &mut solution);
    solve(columns, second.clone(), &mut solution);
    add(columns, second.clone(), third.clone(), &mut solution);
    solve(columns, third.clone(), &mut solution);
    add(columns, third, second, &mut solution);
    solution
}

#[inline(always)]
fn ranges<const N: usize>([second, third]: Groups) -> [Range<usize>; 3] {
    [0..second, second..third, third..N]
}

/// Inverts a block on the diagonal in place. In a sparse one columns with a zero beside the pivot are skipped; in a small dense
/// one the branch costs more than it saves.
#[inline(always)]
fn invert<const N: usize>(columns: &mut [[f64; N]; N], block: Range<usize>, is_sparse: bool) -> Option<()> {
    for k in block.clone() {
        let inverse_pivot = 1.0 / columns[k][k];
        if !inverse_pivot.is_finite() {
            return None;
        }
        let multipliers = columns[k].map(|entry| entry * inverse_pivot);
        for j in block.clone() {
            if j != k {
                let entry = columns[j][k];
                if is_sparse && entry == 0.0 {
                    continue;
                }
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
        let y = Inverse::new(&jacobian, 10.0, [0, 0], false).unwrap().times(&right, [0, 0]);
        for i in 0..4 {
            let left: f64 = (0..4).map(|j| (if i == j { 10.0 } else { 0.0 } - jacobian[(i, j)]) * y[j]).sum();
            assert!((left - right[i]).abs() < 1e-12, "row {i}: {left} is not {}", right[i]);
        }
    }

    /// A chain whose states change each other, as the air in a hose does, with a state that all others act on.
    #[test]
    fn solution_of_a_chain_satisfies_the_equations() {
        const MANY: usize = 15;
        let jacobian = SMatrix::<f64, MANY, MANY>::from_fn(|i, j| match (i, j) {
            _ if i == j => -3.0,
            _ if i.abs_diff(j) == 1 => 1e4 * (i as f64 - 7.3),
            (_, j) if j == MANY - 1 => 0.3,
            (i, _) if i == MANY - 1 => -0.7,
            _ => 0.0,
        });
        let right: [f64; MANY] = std::array::from_fn(|i| 1.0 - 0.3 * i as f64);
        let y = Inverse::new(&jacobian, 1e4, [2, 6], true).unwrap().times(&right, [2, 6]);
        for i in 0..MANY {
            let terms = (0..MANY).map(|j| (if i == j { 1e4 } else { 0.0 } - jacobian[(i, j)]) * y[j]);
            let largest = terms.clone().fold(0.0, |largest: f64, term| largest.max(term.abs()));
            // Some roundings of the largest term of the row.
            assert!((terms.sum::<f64>() - right[i]).abs() < 1e-14 * largest.max(1.0), "row {i}: {y:?}");
        }
    }

    #[test]
    fn a_zero_pivot_is_reported() {
        let jacobian = SMatrix::<f64, 2, 2>::new(5.0, 1.0, 1.0, 0.0);
        assert!(
            [false, true].map(|is_whole| Inverse::new(&jacobian, 5.0, [0, 0], is_whole)).iter().all(Option::is_none)
        );
    }

    #[test]
    fn groups_change_nothing_but_the_cost() {
        let jacobian = SMatrix::<f64, 5, 5>::from_row_slice(&[
            -3.0, 0.0, 0.0, 0.0, 0.0, //
            0.5, -7.0, 1.0, 0.3, -2.0, //
            4.0, 2.0, -1e6, 3.0, 50.0, //
            0.0, 0.0, 1e3, -2.0, 0.7, //
            0.8, 6.0, -0.1, 1.0, 0.0,
        ]);
        let right = [1.0, -2.0, 3.0, 0.5, 0.1];
        let solve = |groups| Inverse::new(&jacobian, 10.0, groups, false).unwrap().times(&right, groups);
        for (grouped, plain) in solve([1, 3]).iter().zip(solve([0, 0])) {
            assert!((grouped - plain).abs() < 1e-14 * plain.abs().max(1.0), "{grouped} is not {plain}");
        }
    }
}
