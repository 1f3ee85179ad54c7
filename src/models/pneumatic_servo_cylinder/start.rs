//! A run of as many states as a cylinder needs.

use super::cylinder::PneumaticServoCylinder;
use super::lines;
use super::parts::Parts;
use super::places::MOST;
use super::sensors;
use super::states::State;
use crate::co_simulation::Simulation;
use crate::friction::{FrictionLaw, MAX_STATES};
use crate::model::Start;
use crate::pneumatics::actuator::Actuating;
use crate::run_sized;
use crate::session::read;
use crate::variables::ParameterError;

/// Whether few sizes are compiled, with more states than needed in most of them.
const SMALL: bool = cfg!(feature = "small");

/// Starts a run with as many states as friction law, lines and sensors need, or a few more: each size is the whole solver
/// compiled once more. Spare states cost LuGre 4 % of a step, spare states of options 10 % with GMS and hoses.
pub(super) fn start<L: FrictionLaw, A: Actuating>(start: &Start) -> Result<Box<dyn Simulation>, ParameterError> {
    let (parts, settings) = read::<PneumaticServoCylinder<L, A>, 3, _>(start, &[], Parts::<L, A>::read)?;
    let settings = settings.keeping_balance(parts.parameters.keeps_balance);
    if !parts.need_extension() {
        let equations = PneumaticServoCylinder::<L, A>::of(parts);
        return run_sized!(
            start,
            equations,
            settings,
            3,
            [
                // Always there: kinks are searched for otherwise where a friction law may have states.
                State::OTHERS,
                State::OTHERS + 4,
                State::OTHERS + MAX_STATES
            ]
        );
    }
    let equations = PneumaticServoCylinder::<L, A, true>::of(parts);
    run_sized!(start, equations, settings, 3, [
        State::OTHERS + 2 + sensors::COUNT => !SMALL,
        State::OTHERS + 2 + lines::STATES => !SMALL,
        MOST
    ])
}
