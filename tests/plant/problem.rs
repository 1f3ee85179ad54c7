//! Problems of the hybrid solver: models without parameters, outputs and variables of their states.

use pneumatic_servo::numbers::{Real, Scalar};
use pneumatic_servo::solver::{Run, Settings};
use pneumatic_servo::system::{System, Tables};
use pneumatic_servo::variables::{StateSet, Variable, units};

/// States without variables.
#[derive(Clone, Copy, PartialEq)]
pub enum Unnamed {}

impl StateSet<()> for Unnamed {
    const ALL: &'static [Self] = &[];
    const OTHERS: usize = 0;
    fn at(self, _n: usize) -> usize {
        match self {}
    }
    fn reference(self) -> u32 {
        match self {}
    }
    fn of(_reference: u32) -> Option<Self> {
        None
    }
    fn scale(self, (): &()) -> f64 {
        match self {}
    }
}

/// Numbers in an array whose length the solver chooses.
#[allow(dead_code, reason = "each test file uses some of it")]
pub fn all<S: Copy, const M: usize, const N: usize>(numbers: [S; M]) -> [S; N] {
    std::array::from_fn(|i| numbers[i])
}

/// A run in plain numbers, from given states and with an input.
pub fn run<H: System<1>, const N: usize>(
    system: H,
    settings: Settings,
    x: [f64; N],
    memory: H::Memory<Real>,
    input: f64,
) -> Run<H, N, 1> {
    Run::new(system, settings, 0.0, Real::all(&x), memory, [Real::of(input)])
}

/// Where a run is.
#[allow(dead_code, reason = "each test file uses some of it")]
pub fn states<H: System<1>, const N: usize>(run: &Run<H, N, 1>) -> [f64; N] {
    run.state().0.map(Real::value)
}

/// A table of states and their rates, the references of the states being their places.
pub fn tables(states: &[&str]) -> Tables {
    let named = states.iter().zip(0..);
    let state = |(name, place): (&&str, u32)| Variable::output(10 + place, name, units::ONE);
    let rate = |(name, place): (&&str, u32)| {
        Variable::output(20 + place, &format!("{name}Rate"), units::ONE).derivative_of(10 + place)
    };
    let computed = named.clone().map(state).chain(named.map(rate)).collect();
    Tables { inputs: Vec::new(), computed, parameters: Vec::new() }
}

/// The items of a `System` that a problem of the solver has no use for, and names of its states where messages need them.
/// Runs begin from given states.
macro_rules! problem {
    ($($state:literal),*) => {
        type Parameters = ();
        type State = $crate::problem::Unnamed;
        fn tables() -> pneumatic_servo::system::Tables {
            $crate::problem::tables(&[$($state),*])
        }
        fn state_at(&self, reference: u32, _n: usize) -> Option<usize> {
            reference.checked_sub(10).map(|place| place as usize)
        }
        fn new(
            _: &mut pneumatic_servo::variables::Values,
        ) -> Result<Self, pneumatic_servo::variables::ParameterError> {
            unreachable!("problems are not built from a table")
        }
        fn parameters(&self) -> &() {
            &()
        }
        fn start<S: pneumatic_servo::numbers::Varying, const N: usize>(&self, _: &[S; 1]) -> ([S; N], Self::Memory<S>) {
            unreachable!("runs begin from given states")
        }
        fn outputs<S: Scalar, const N: usize>(
            &self,
            _: S,
            _: &[S; N],
            _: &[S; 1],
            _: &Self::Memory<S::Held>,
            _: &mut [S],
        ) {
        }
        fn event_name(&self, _: usize) -> &'static str {
            "an event"
        }
    };
}

pub(crate) use problem;
