//! States that follow commands with a lag of first order.

use super::actuation::{DEFECT_WEIGHT, SHORT, STATES, simpson_middle};
use crate::numbers::{Scalar, Tangent, Varying};
use crate::system::{ClosedForm, Stride};

/// A lag of first order, the same for all its states.
///
/// ```text
/// dy/dt = (u - y)/tau
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lag {
    /// Time constant `tau` in s.
    time_constant: Tangent,
}

impl Lag {
    /// A lag with a time constant in s.
    pub fn new(time_constant: Tangent) -> Self {
        Self { time_constant }
    }

    /// Rate of a state.
    pub fn rate<S: Scalar>(&self, state: S, command: S) -> S {
        (command - state) / self.time_constant
    }

    /// Rates of two states.
    pub fn rates<S: Scalar>(&self, states: [S; STATES], commands: [S; STATES]) -> [S; STATES] {
        std::array::from_fn(|side| self.rate(states[side], commands[side]))
    }

    /// The share of the distance from a command that half a step of a size in s leaves.
    pub fn left<S: Varying>(&self, step: f64) -> S {
        S::along(-0.5 * step / self.time_constant).exp()
    }

    /// These shares of two states, as [`Actuating::half`](super::actuation::Actuating::half).
    pub fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
        let left = self.left(step);
        [[left, S::zero()], [S::zero(), left]]
    }

    /// A state in a step of a size in s over which the command is held, half of which leaves a share of the distance: in the middle,
    /// at the end, and the defect.
    #[inline(always)]
    pub fn course<S: Varying>(&self, state: S, command: S, step: f64, left: S) -> [S; 3] {
        let distance = state - command;
        let (middle, end) = (distance * left, distance * left * left);
        let effective = if step < SHORT * self.time_constant.value {
            middle
        } else {
            simpson_middle(distance, (distance - end) * self.time_constant / step, end)
        };
        [command + effective, command + end, (effective - middle) * DEFECT_WEIGHT]
    }

    /// Two states in a step over which the commands are held.
    #[inline(always)]
    pub fn later<S: Varying>(
        &self,
        states: [S; STATES],
        commands: [S; STATES],
        stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        let &Stride { size: step, half: [[left, _], _] } = stride;
        let [a, b] = std::array::from_fn(|side| self.course(states[side], commands[side], step, left));
        let at = |place: usize| [a[place], b[place]];
        ClosedForm { middle: at(0), end: at(1), defect: at(2) }
    }
}
