//! What makes the runs of a model faster.

use nalgebra::SMatrix;

use super::System;
use crate::hybrid::{Groups, Led, LongestSteps, Stride, jacobian_by_duals};
use crate::numbers::{Real, Scalar};

/// The place of a state among those of a run, whose number depends on the friction law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// So many states are before it.
    Front(usize),
    /// So many states are behind it.
    Back(usize),
}

impl Place {
    /// Its index among `n` states.
    pub const fn among(self, n: usize) -> usize {
        match self {
            Self::Front(before) => before,
            Self::Back(behind) => n - 1 - behind,
        }
    }
}

/// What a model can say of its equations so that its runs take less time. Nothing here changes what is computed, but for
/// rounding and the error that the tolerance allows; `impl Shortcuts<U> for MyModel {}` says nothing, and costs nothing but
/// time.
///
/// What it is worth, measured on the cylinder, whose plain step takes 4,300 instructions:
///
/// - [`is_gentle`](Self::is_gentle) with [`is_smooth`](Self::is_smooth): explicit steps where the implicit method would need
///   a Jacobian each time, a factor of two to four.
/// - [`LED`](Self::LED) with [`led`](Self::led) and [`driven`](Self::driven): a fast actuator costs no small steps.
/// - [`RELAXING`](Self::RELAXING) with [`relaxation`](Self::relaxation): explicit steps for a stiff bristle that slides.
/// - [`GROUPS`](Self::GROUPS) and [`jacobian`](Self::jacobian): a sparse elimination and fewer directions, a third of an
///   implicit step.
/// - [`refresh`](Self::refresh), [`indicators_hold`](Self::indicators_hold), [`at_hand`](Self::at_hand): an evaluation of the
///   equations each, where inputs jump or a single output is read.
pub trait Shortcuts<const U: usize>: System<U> {
    /// Which couplings between states the Jacobian has; all of them unless a system says so.
    const GROUPS: Groups = [0, 0];

    /// Whether states are coupled as in a chain under these parameters: in no [`GROUPS`](Self::GROUPS), but most of them not at
    /// all. Matrices are then factorised without their zeros.
    fn is_chain(&self) -> bool {
        false
    }

    /// How many states, the first ones, follow the inputs alone, and have a closed form while these are held.
    const LED: usize = 0;

    /// A state that may relax within a step that is gentle otherwise; only in runs in which a friction law has states.
    const RELAXING: Option<Place> = None;

    /// A state at whose zeros the equations have most of their kinks: a velocity that bends bristles; only in runs in which a
    /// friction law has states.
    const TURNING: Option<Place> = None;

    /// The derivatives, of which those of the first [`LED`](Self::LED) states may be missing: where these have a closed
    /// form, nobody asks how they change.
    fn driven<const N: usize>(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> [f64; N] {
        self.derivatives(Real::of(time), &Real::all(x), &Real::all(u), memory).map(Real::value)
    }

    /// Time derivatives of the states, and their Jacobian, of which a system may leave out entries that are always
    /// zero: the matrix given is zero at first and written by this system only.
    fn jacobian<const N: usize>(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; U],
        memory: &Self::Memory,
        jacobian: &mut SMatrix<f64, N, N>,
    ) -> [f64; N] {
        jacobian_by_duals(self, time, x, u, memory, jacobian)
    }

    /// Whether the indicators stay as they are where the inputs change from the first values to the second, and the memory
    /// follows them.
    fn indicators_hold(&self, _inputs: [&[f64; U]; 2]) -> bool {
        false
    }

    /// Makes the derivatives that [`driven`](Self::driven) has given at the end of a step to these states those that
    /// [`derivatives`](System::derivatives) gives, with the same bits, after the memory has followed the step, and the inputs
    /// have changed from the first values to the second. `false`, and nothing is changed, if that is no cheaper than to
    /// evaluate them again.
    fn refresh<const N: usize>(
        &self,
        _x: &[f64; N],
        _inputs: [&[f64; U]; 2],
        _memory: &Self::Memory,
        _derivatives: &mut [f64; N],
    ) -> bool {
        false
    }

    /// What [`led`](Self::led) needs to know of a step of a size in s, whatever the states and the inputs.
    fn stride(&self, size: f64) -> Stride {
        Stride { size, half: [[0.0; 2]; 2] }
    }

    /// The states in a step, under inputs that are held and that the memory has followed; of each array the first
    /// [`LED`](Self::LED).
    fn led<const N: usize>(
        &self,
        x: &[f64; N],
        _u: &[f64; U],
        _memory: &Self::Memory,
        _stride: &Stride,
    ) -> Led<[f64; N]> {
        Led { middle: *x, end: *x, bend: [0.0; N] }
    }

    /// Whether the equations change gently within a mode, so that accuracy, not stability, bounds the steps of an explicit
    /// method. It may be wrong for some parameters: then steps cost more, but are as accurate.
    fn is_gentle(&self) -> bool {
        false
    }

    /// Whether something changes faster now than the error estimate of the explicit method can tell, such as a flow through a
    /// valve that opens within a step. The difference from the midpoint rule then counts, too.
    fn is_hasty(&self, _memory: &Self::Memory) -> bool {
        false
    }

    /// The rate in 1/s at which the [relaxing](Self::RELAXING) state comes closer to where it is led: minus the derivative of
    /// its own rate by itself. Steps are as accurate, but more, if it is not exact. Asked of gentle steps only, with the
    /// derivatives at hand.
    fn relaxation<const N: usize>(
        &self,
        _time: f64,
        _x: &[f64; N],
        _rates: &[f64; N],
        _u: &[f64; U],
        _memory: &Self::Memory,
    ) -> f64 {
        0.0
    }

    /// The longest explicit steps from these states.
    fn longest_gentle_steps<const N: usize>(&self, _x: &[f64; N]) -> LongestSteps {
        LongestSteps::UNLIMITED
    }

    /// Whether the equations are smooth, without a kink, along a step of a size in s from the first of these states, with
    /// the first of these inputs, to the second.
    fn is_smooth<const N: usize>(
        &self,
        _x: [&[f64; N]; 2],
        _u: [&[f64; U]; 2],
        _memory: &Self::Memory,
        _step: f64,
    ) -> bool {
        true
    }

    /// The value of a computed variable, given by its place, if it takes no evaluation of the equations: as a rule one
    /// that is a state. It is the same, bit for bit, as that of [`outputs`](System::outputs).
    fn at_hand<const N: usize>(&self, _place: usize, _x: &[f64; N], _memory: &Self::Memory) -> Option<f64> {
        None
    }
}
