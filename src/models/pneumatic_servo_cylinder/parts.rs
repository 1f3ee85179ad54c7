//! What the equations are made of, as it is read from values.

use super::options::Options;
use super::parameters::Parameters;
use super::sensors::Sensors;
use crate::friction::{ContactLaw, FrictionLaw, Law};
use crate::pneumatics::actuator::Actuating;
use crate::variables::{ParameterError, Values};

/// The parameters, in the order of the table.
pub(super) type Listed<L, A> =
    (Parameters, Options, Sensors, <A as Actuating>::Parameters, ContactLaw<L, { Law::Stribeck as i32 }>);

/// What the equations are made of.
pub(super) struct Parts<L, A> {
    pub parameters: Parameters,
    pub options: Options,
    pub sensors: Sensors,
    pub actuator: A,
    pub friction: L,
}

impl<L: FrictionLaw, A: Actuating> Parts<L, A> {
    pub fn read(values: &mut Values) -> Result<Self, ParameterError> {
        let (parameters, options, sensors, actuator, ContactLaw(friction)): Listed<L, A> = values.read()?;
        parameters.check()?;
        options.check(parameters.bore, parameters.stroke)?;
        sensors.check()?;
        Ok(Self { parameters, options, sensors, actuator: A::new(actuator)?, friction })
    }

    /// Whether any of them is compiled for extended equations only.
    pub fn need_extension(&self) -> bool {
        self.options.are_used() || self.sensors.are_used() || self.actuator.is_sampled()
    }
}
