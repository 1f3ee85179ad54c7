//! What the equations are made of, as it is read from values.

use super::options::Options;
use super::parameters::Parameters;
use super::sensors::Sensors;
use crate::friction::FrictionLaw;
use crate::pneumatics::actuator::Actuating;
use crate::variables::{ParameterError, Values};

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
        let parameters: Parameters = values.read()?;
        parameters.check()?;
        let options: Options = values.read()?;
        options.check(parameters.bore, parameters.stroke)?;
        let sensors: Sensors = values.read()?;
        sensors.check()?;
        let actuator = A::new(values.read()?)?;
        Ok(Self { parameters, options, sensors, actuator, friction: values.read_group("friction")? })
    }

    /// Whether any of them is compiled for extended equations only.
    pub fn need_extension(&self) -> bool {
        self.options.are_used() || self.sensors.are_used() || self.actuator.is_sampled()
    }
}
