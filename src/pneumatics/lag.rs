//! Two states that follow commands with a lag of first order.

use super::actuating::{BEND_WEIGHT, SHORT, STATES, simpson_middle};
use crate::numbers::{Scalar, Tangent, Varying};
use crate::system::{Led, Stride};

/// A lag of first order, the same for both states.
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

    /// Rates of the states.
    pub fn rates<S: Scalar>(&self, states: [S; STATES], commands: [S; STATES]) -> [S; STATES] {
        std::array::from_fn(|side| (commands[side] - states[side]) / self.time_constant)
    }

    /// What half a step of a size in s leaves of the distances from the commands.
    pub fn half<S: Varying>(&self, step: f64) -> [[S; STATES]; STATES] {
        let left = S::along(-0.5 * step / self.time_constant).exp();
        [[left, S::zero()], [S::zero(), left]]
    }

    /// The states in a step over which the commands are held.
    #[inline(always)]
    pub fn later<S: Varying>(
        &self,
        states: [S; STATES],
        commands: [S; STATES],
        stride: &Stride<S>,
    ) -> Led<[S; STATES]> {
        let &Stride { size: step, half: [[left, _], _] } = stride;
        let [a, b] = std::array::from_fn(|side| {
            let distance = states[side] - commands[side];
            let (middle, end) = (distance * left, distance * left * left);
            let effective = if step < SHORT * self.time_constant.value {
                middle
            } else {
                simpson_middle(distance, (distance - end) * self.time_constant / step, end)
            };
            [commands[side] + effective, commands[side] + end, (effective - middle) * BEND_WEIGHT]
        });
        let at = |place: usize| [a[place], b[place]];
        Led { middle: at(0), end: at(1), bend: at(2) }
    }
}
