//! No friction.

use crate::friction::law::{Contact, FrictionLaw};
use crate::numbers::Scalar;
use crate::parameters;
use crate::variables::ParameterError;

parameters! {
    /// No friction: `F = 0`.
    NoFriction {}
}

impl FrictionLaw for NoFriction {
    type Memory = ();
    type Parameters = Self;

    fn new(parameters: Self) -> Result<Self, ParameterError> {
        Ok(parameters)
    }

    fn start(&self, _contact: &Contact<f64>, _z: &mut [f64]) {}

    fn force<S: Scalar>(&self, _contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
        S::zero()
    }
}
