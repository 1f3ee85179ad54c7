//! Where the states stand among those of a run.

use super::lines;
use super::sensors;
use super::states::State;
use crate::friction::MAX_STATES;
use crate::pneumatics::actuator::STATES;

// In front of the friction law the places do not depend on its number of states.
pub(super) const TEMPERATURE_A: usize = State::TemperatureA.at(State::OTHERS);
pub(super) const TEMPERATURE_B: usize = State::TemperatureB.at(State::OTHERS);
/// Index of the pressure in chamber A among the states.
#[doc(hidden)]
pub const PRESSURE_A: usize = State::PressureA.at(State::OTHERS);
/// Index of the pressure in chamber B among the states.
#[doc(hidden)]
pub const PRESSURE_B: usize = State::PressureB.at(State::OTHERS);

/// The states of the actuator, which come first.
#[inline(always)]
pub(super) fn of_actuator<S: Copy>(x: &[S]) -> [S; STATES] {
    std::array::from_fn(|place| x[place])
}

/// States of a cylinder that has them all.
pub(super) const MOST: usize = State::OTHERS + MAX_STATES + lines::STATES + sensors::COUNT;
