//! What the solver needs to know of a model.

use nalgebra::SMatrix;
use serde::{Serialize, de::DeserializeOwned};

use super::{LongestSteps, Sample};
use crate::numbers::{Dual, Number, Real, Scalar};

/// Where the second and the third group of the states begin, in a system whose Jacobian has zeros as below.
///
/// ```text
///     | A  0  0 |   the first group depends on nothing but itself,
/// J = | B  C  D |   the second on everything,
///     | 0  E  F |   the third not on the first
/// ```
pub type Groups = [usize; 2];

/// Conserved quantities a system can have.
pub const QUANTITIES: usize = 2;

/// A hybrid system with `N` continuous states and `U` inputs.
///
/// Between events the states follow [`derivatives`](Self::derivatives) with a constant memory; a mode is valid while
/// all its [`indicators`](Self::indicators) are positive or zero.
pub trait HybridSystem<const N: usize, const U: usize> {
    /// Modes, stacks, delay lines, generators: everything that changes at events and accepted steps only.
    type Memory: Clone + PartialEq + Serialize + DeserializeOwned + Send;

    /// Values of the event indicators, each in a fixed place: an array of as many as the system has.
    type Indicators: AsRef<[f64]> + Copy + Send;

    /// Which couplings between states the Jacobian has; all of them unless a system says so.
    const GROUPS: Groups = [0, 0];

    /// Whether states are coupled as in a chain under these parameters: in no [`GROUPS`](Self::GROUPS), but most of them not at
    /// all. Matrices are then factorised without their zeros.
    fn is_chain(&self) -> bool {
        false
    }

    /// How many states, the first ones, follow the inputs alone, and have a closed form while these are held.
    const LED: usize = 0;

    /// A state that may relax within a step that is gentle otherwise.
    const RELAXING: Option<usize> = None;

    /// A state at whose zeros the equations have most of their kinks: a velocity that bends bristles.
    const TURNING: Option<usize> = None;

    /// Time derivatives of the states. They must be smooth functions of the states within a mode.
    fn derivatives<S: Scalar>(&self, time: S, x: &[S; N], u: &[S; U], memory: &Self::Memory) -> [S; N];

    /// The same in plain numbers.
    #[inline(always)]
    fn rates(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> [f64; N] {
        self.derivatives(Real::of(time), &Real::all(x), &Real::all(u), memory).map(Real::value)
    }

    /// The same, of which those of the first [`LED`](Self::LED) states may be missing: where these have a closed form,
    /// nobody asks how they change.
    fn driven(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> [f64; N] {
        self.rates(time, x, u, memory)
    }

    /// Time derivatives of the states, and their Jacobian, of which a system may leave out entries that are always
    /// zero: the matrix given is zero at first and written by this system only.
    fn jacobian(
        &self,
        time: f64,
        x: &[f64; N],
        u: &[f64; U],
        memory: &Self::Memory,
        jacobian: &mut SMatrix<f64, N, N>,
    ) -> [f64; N] {
        jacobian_by_duals(self, time, x, u, memory, jacobian)
    }

    /// The event indicators: positive or zero while the present mode is valid, [`UNUSED`](super::UNUSED) where the
    /// mode has no use for them.
    fn indicators(&self, time: f64, x: &[f64; N], u: &[f64; U], memory: &Self::Memory) -> Self::Indicators;

    /// Whether any mode can end: if not, nobody looks at the indicators.
    fn has_events(&self) -> bool {
        true
    }

    /// Handles the event in a place of the indicators, whose value fell below zero.
    fn switch(&self, event: usize, time: f64, x: &mut [f64; N], u: &[f64; U], memory: &mut Self::Memory);

    /// Whether the indicators stay as they are where the inputs change from the first values to the second, and the memory
    /// follows them.
    fn indicators_hold(&self, _inputs: [&[f64; U]; 2]) -> bool {
        false
    }

    /// Lets the memory follow an accepted step, or a change of the inputs; must leave the indicators as they are. Returns
    /// whether the derivatives may have changed, apart from those that [`refresh`](Self::refresh) renews.
    fn follow(&self, _time: f64, _x: &[f64; N], _u: &[f64; U], _memory: &mut Self::Memory) -> bool {
        false
    }

    /// Takes notice of a communication step of a duration in s that begins here, with its inputs; returns whether the
    /// memory may have changed.
    fn begin(&self, _duration: f64, _u: &[f64; U], _memory: &mut Self::Memory) -> bool {
        false
    }

    /// The next sample of a sampled part.
    fn next_sample(&self, _memory: &Self::Memory) -> Sample {
        Sample::NEVER
    }

    /// Takes the samples that are due at a time in s.
    fn sample(&self, _time: f64, _x: &mut [f64; N], _u: &[f64; U], _memory: &mut Self::Memory) {}

    /// Takes notice of a communication point at which a run arrives: samples that show there are taken. It must leave
    /// alone all that the equations depend on.
    fn arrive(&self, _time: f64, _x: &[f64; N], _u: &[f64; U], _memory: &mut Self::Memory) {}

    /// Longest step in s the solver may take.
    fn max_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether the equations have a meaning at these states (positive pressures, for example).
    ///
    /// # Errors
    /// What has no meaning, as part of a sentence.
    fn admit(&self, _x: &[f64; N]) -> Result<(), &'static str> {
        Ok(())
    }

    /// Name of a state, for messages.
    fn state_name(&self, _state: usize) -> &'static str {
        "a state"
    }

    /// Name of the event in a place of the indicators, for messages.
    fn event_name(&self, _event: usize) -> &'static str {
        "an event"
    }

    /// The choice on which the equations depend most, for messages: the friction law, for example.
    fn variant(&self) -> &'static str {
        ""
    }

    /// Makes the derivatives that [`driven`](Self::driven) has given at the end of a step to these states those that
    /// [`derivatives`](Self::derivatives) gives, with the same bits, after the memory has followed the step, and the inputs
    /// have changed from the first values to the second. `false`, and nothing is changed, if that is no cheaper than to
    /// evaluate them again.
    fn refresh(
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
    fn led(&self, x: &[f64; N], _u: &[f64; U], _memory: &Self::Memory, _stride: &Stride) -> Led<[f64; N]> {
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
    fn relaxation(&self, _time: f64, _x: &[f64; N], _rates: &[f64; N], _u: &[f64; U], _memory: &Self::Memory) -> f64 {
        0.0
    }

    /// The longest explicit steps from these states.
    fn longest_gentle_steps(&self, _x: &[f64; N]) -> LongestSteps {
        LongestSteps::UNLIMITED
    }

    /// Whether the equations are smooth, without a kink, along a step of a size in s from the first of these states, with
    /// the first of these inputs, to the second.
    fn is_smooth(&self, _x: [&[f64; N]; 2], _u: [&[f64; U]; 2], _memory: &Self::Memory, _step: f64) -> bool {
        true
    }

    /// Magnitudes of the states: the solver keeps the error per step of state `i` below
    /// `relative tolerance * max(scale, |x|)`.
    fn scales(&self) -> [f64; N];

    /// What the system holds of each conserved quantity; quantities it does not have stay 0.
    fn content(&self, _x: &[f64; N], _memory: &Self::Memory) -> [f64; QUANTITIES] {
        [0.0; QUANTITIES]
    }

    /// What it receives of each per second.
    fn inflow(&self, _time: f64, _x: &[f64; N], _u: &[f64; U], _memory: &Self::Memory) -> [f64; QUANTITIES] {
        [0.0; QUANTITIES]
    }

    /// Whether a memory can belong to this system.
    fn fits(&self, memory: &Self::Memory) -> bool;

    /// Whether the equations depend on time other than through the inputs.
    fn depends_on_time(&self) -> bool {
        false
    }
}

/// Directions in which the equations are evaluated at a time.
pub(super) const DIRECTIONS: usize = 6;

/// The Jacobian, exact to rounding, by evaluating the equations with dual numbers a few directions at a time.
///
/// The number of directions is the same for all systems, so that the equations are compiled for it once.
pub fn jacobian_by_duals<H: HybridSystem<N, U> + ?Sized, const N: usize, const U: usize>(
    system: &H,
    time: f64,
    x: &[f64; N],
    u: &[f64; U],
    memory: &H::Memory,
    jacobian: &mut SMatrix<f64, N, N>,
) -> [f64; N] {
    let (time, u) = (Dual::constant(time), u.map(Dual::constant));
    let mut derivatives = [0.0; N];
    for first in (0..N).step_by(DIRECTIONS) {
        let mut seeded = x.map(Dual::<DIRECTIONS>::constant);
        for (direction, state) in seeded[first..].iter_mut().take(DIRECTIONS).enumerate() {
            state.slope[direction] = 1.0;
        }
        for (row, rate) in system.derivatives(time, &seeded, &u, memory).iter().enumerate() {
            derivatives[row] = rate.value;
            for (column, slope) in (first..N).zip(rate.slope) {
                jacobian[(row, column)] = slope;
            }
        }
    }
    derivatives
}

/// A size of steps, and how states that follow inputs alone come closer in a step of this size to where these lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride {
    /// The size in s.
    pub size: f64,
    /// What half a step leaves of the distances of two states, as a matrix.
    pub half: [[f64; 2]; 2],
}

/// States that follow inputs alone, in a step over which these are held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Led<X> {
    /// In the middle, the values with which the rule of Simpson has the means over the step.
    pub middle: X,
    /// At the end.
    pub end: X,
    /// By how much those in the middle differ from the true ones, which is their error for those that depend on them.
    pub bend: X,
}

/// Inputs that vary linearly from a point in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<const U: usize> {
    since: f64,
    values: [f64; U],
    slopes: [f64; U],
    /// Whether any slope differs from 0.
    vary: bool,
}

impl<const U: usize> Held<U> {
    /// Inputs with values at a time in s, and with slopes in 1/s from there on.
    pub fn new(since: f64, values: [f64; U], slopes: [f64; U]) -> Self {
        Self { since, values, slopes, vary: slopes.iter().any(|slope| *slope != 0.0) }
    }

    /// The inputs at a time.
    pub fn at(&self, time: f64) -> [f64; U] {
        if !self.vary {
            return self.values;
        }
        std::array::from_fn(|i| self.values[i] + self.slopes[i] * (time - self.since))
    }

    /// Slopes in 1/s.
    pub fn slopes(&self) -> [f64; U] {
        self.slopes
    }

    /// Whether any slope differs from 0.
    pub fn vary(&self) -> bool {
        self.vary
    }
}
