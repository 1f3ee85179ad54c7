//! The trait of actuators.

use serde::{Serialize, de::DeserializeOwned};

use super::gas::{GasState, Reservoir};
use super::orifice::Inflow;
use crate::numbers::{Number, Pair, Real, Scalar, Tangent, Varying};
use crate::system::{ClosedForm, Sample, Stride};
use crate::variables::{ParameterError, ParameterSet, Variable};

/// States of an actuator. Each actuator has its own, with variables of their own; those in use share these places, so
/// that no rig integrates what it does not have.
pub const STATES: usize = 2;

/// Place of the state that sets the flow of a valve or a regulator; the other only leads to it.
pub const FLOW: usize = 1;

/// Value reference of the input that commands an actuator, a voltage.
pub const VOLTAGE: u32 = 1;
/// Value references of the inputs that command an actuator of each chamber.
pub const VOLTAGE_A: u32 = 6;
/// The same of chamber B.
pub const VOLTAGE_B: u32 = 7;
/// Value reference of the first of the inputs that switch coils; the others follow.
pub const COIL: u32 = 8;
/// Number of coils.
pub const COILS: usize = 4;
/// Value reference of the parameter that chooses among actuators.
pub const ACTUATION: u32 = 1032;
/// Value reference of the input that is the supply pressure.
pub const SUPPLY: u32 = 3;

/// Surroundings of an actuator apart from the chambers.
#[derive(Clone, Copy, Debug)]
pub struct Ports<'a, S> {
    /// Where the air comes from.
    pub supply: &'a Reservoir,
    /// Its absolute pressure in Pa.
    pub supply_pressure: S,
    /// Where the air goes to.
    pub exhaust: &'a Reservoir,
    /// Its absolute pressure in Pa.
    pub exhaust_pressure: Tangent,
}

/// The inputs that command an actuator, voltages in V and coils.
#[derive(Clone, Copy, Debug)]
pub struct Commands<S> {
    /// Of an actuator for both chambers.
    pub voltage: S,
    /// Of the actuator of chamber A, where there is one for [each chamber](Actuating::takes_commands_of_chambers).
    pub voltage_a: S,
    /// Of the actuator of chamber B.
    pub voltage_b: S,
    /// Of valves that are switched [one by one](Actuating::command): 1 for a coil that is on, else 0.
    pub coils: [S; COILS],
}

impl<S: Copy + Default> Commands<S> {
    /// The same voltage for all, and all coils off.
    pub fn all(voltage: S) -> Self {
        Self { voltage, voltage_a: voltage, voltage_b: voltage, coils: [S::default(); COILS] }
    }

    /// The values for the actuators of the chambers A and B.
    pub fn of_chambers(self) -> [S; 2] {
        [self.voltage_a, self.voltage_b]
    }
}

/// An actuator: its parameters, its states, its variables and its equations.
pub trait Actuating: Clone + std::fmt::Debug + Send + Sync + Sized + 'static {
    /// Discrete state apart from its states; changes with the accepted steps.
    type Memory<S: Varying>: Clone + PartialEq + std::fmt::Debug + Serialize + DeserializeOwned + Send;

    /// Its parameters.
    type Parameters: ParameterSet;

    /// Number of its computed variables.
    const COMPUTED: usize;

    /// Builds it.
    ///
    /// # Errors
    /// [`ParameterError`] when values that are legal one by one do not fit together.
    fn new(parameters: Self::Parameters) -> Result<Self, ParameterError>;

    /// Its computed variables.
    fn computed() -> Vec<Variable>;

    /// Value references of the states and inputs on which the inflow of a chamber depends, 0 for A and 1 for B.
    fn feeds(chamber: usize) -> Vec<u32>;

    /// Value references of the variables of its states, by their places; `None` where it has no state.
    fn variables(&self) -> [Option<u32>; STATES];

    /// Place of the state that a variable stands for, if the actuator has it.
    fn state_at(&self, reference: u32) -> Option<usize> {
        self.variables().iter().position(|variable| *variable == Some(reference))
    }

    /// Whether the flow depends on the supply pressure, an input.
    fn has_supply(&self) -> bool {
        Self::feeds(0).contains(&SUPPLY)
    }

    /// Whether it changes by itself at points in time.
    #[inline(always)]
    fn is_sampled(&self) -> bool {
        false
    }

    /// Whether [`half`](Self::half) and [`later`](Self::later) have its states in closed form while the commands are held. Without
    /// it runs take implicit steps only, which cost two to four times as much.
    fn has_closed_form(&self) -> bool {
        false
    }

    /// Whether it takes a command for each chamber, and not one for both.
    fn takes_commands_of_chambers(&self) -> bool {
        false
    }

    /// Magnitudes of its states, for error control.
    fn scales(&self) -> [f64; STATES];

    /// States and memory at the start, under commands.
    fn start<S: Varying>(&self, commands: Commands<S>) -> ([S; STATES], Self::Memory<S>);

    /// Rates of the states under commands.
    fn rates<S: Scalar>(
        &self,
        states: [S; STATES],
        commands: Commands<S>,
        memory: &Self::Memory<S::Held>,
    ) -> [S; STATES];

    /// Decay matrix of half a step of a size in s, for the distances of the states from their equilibrium under held
    /// commands.
    /// Asked of actuators with a [closed form](Self::has_closed_form).
    fn half<S: Varying>(&self, _step: f64) -> [[S; STATES]; STATES] {
        [[S::zero(); STATES]; STATES]
    }

    /// The states in a step, under commands that are held and that the memory has followed. Asked of actuators with a
    /// [closed form](Self::has_closed_form).
    fn later<S: Varying>(
        &self,
        states: [S; STATES],
        _commands: Commands<S>,
        _memory: &Self::Memory<S>,
        _stride: &Stride<S>,
    ) -> ClosedForm<[S; STATES]> {
        ClosedForm { middle: states, end: states, defect: [S::zero(); STATES] }
    }

    /// Whether it opens or closes now, at a rate that may fill a step: the flow then follows a higher power of the time than
    /// the error estimate of explicit steps sees.
    fn is_fast<S: Varying>(&self, _memory: &Self::Memory<S>) -> bool {
        false
    }

    /// Whether the flow depends on the time, too.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// Takes notice of the commands at a time in s. Asked of actuators that [change by themselves](Self::is_sampled), after each
    /// accepted step and where inputs change.
    fn command<S: Varying>(&self, _time: S, _commands: Commands<S>, _memory: &mut Self::Memory<S>) {}

    /// Lets the memory follow the commands.
    fn follow<S: Varying>(&self, _commands: Commands<S>, _memory: &mut Self::Memory<S>) {}

    /// The next point in time at which it changes by itself.
    fn next_sample<S: Varying>(&self, _memory: &Self::Memory<S>) -> Sample<S> {
        Sample::never()
    }

    /// Changes at that point, under commands.
    fn sample<S: Varying>(&self, _states: &mut [S; STATES], _commands: Commands<S>, _memory: &mut Self::Memory<S>) {}

    /// Flow into the chambers.
    fn feed<S: Scalar>(&self, states: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Inflow<Pair<S>>;

    /// Flow into the chambers at a time in s, where it depends on the memory, too.
    fn feed_at<S: Scalar>(
        &self,
        _time: S,
        states: [S; STATES],
        _memory: &Self::Memory<S::Held>,
        ports: &Ports<S>,
        gas: GasState<Pair<S>>,
    ) -> Inflow<Pair<S>> {
        self.feed(states, ports, gas)
    }

    /// The numbers, one for each chamber, of the smooth regions of [`feed`](Self::feed) in which the states and the pressures
    /// in Pa of both chambers lie: whole numbers, which are compared side by side.
    fn smooth_region(&self, _states: [f64; STATES], _ports: &Ports<Real>, _pressures: Pair<Real>) -> Pair<Real> {
        Pair::zero()
    }

    /// Whether the states stay in their smooth region all along a step of a size in s, at both ends of which they are in the same one.
    fn stays_in_piece<S: Varying>(
        &self,
        _ends: [[f64; STATES]; 2],
        _commands: Commands<f64>,
        _memory: &Self::Memory<S>,
        _step: f64,
    ) -> bool {
        true
    }

    /// Mass flows in kg/s that it draws from the supply for the chambers: all that flows into them, unless it has an
    /// exhaust.
    fn drawn<S: Scalar>(&self, states: [S; STATES], ports: &Ports<S>, gas: GasState<Pair<S>>) -> Pair<S> {
        self.feed(states, ports, gas).mass
    }

    /// Writes its computed variables.
    fn write<S: Scalar>(
        &self,
        states: [S; STATES],
        commands: Commands<S>,
        memory: &Self::Memory<S::Held>,
        slots: &mut [S],
    );

    /// Name of the computed variable that shows a number of its memory, given by the fields that lead to it.
    fn variable_of(&self, _fields: &str) -> Option<&'static str> {
        None
    }

    /// Whether a memory has a meaning.
    fn fits<S: Varying>(&self, _memory: &Self::Memory<S>) -> bool {
        true
    }
}

/// Weight, as error, of a state's departure from a parabola: its effect on the pressures has the same sign in step after
/// step.
pub(super) const DEFECT_WEIGHT: f64 = 10.0;

/// Steps times the fastest rate of a state below which the rule of Simpson has its mean: it errs by a 1920th of the fourth
/// power. In much shorter steps the mean would be lost in rounding.
pub(super) const SHORT: f64 = 0.01;

/// The value in the middle of a step with which the rule of Simpson has a mean, between values at the start and at the end.
pub(super) fn simpson_middle<S: Scalar>(start: S, mean: S, end: S) -> S {
    mean * 1.5 - (start + end) * 0.25
}
