//! Laws that are a function of velocity.

use crate::friction::law::{Contact, FrictionLaw};
use crate::numbers::{Scalar, Varying};
use crate::variables::{ParameterError, ParameterSet};

/// A law without states, modes and stiction.
pub trait VelocityLaw: ParameterSet {
    /// Whether the force changes gently with the velocity.
    const IS_NON_STIFF: bool = false;

    /// Checks that parameters which are legal one by one fit together.
    ///
    /// # Errors
    /// [`ParameterError`] if they do not.
    fn check(&self) -> Result<(), ParameterError> {
        Ok(())
    }

    /// The friction force in N at a velocity and load factor.
    fn force<S: Scalar>(&self, velocity: S, level: S) -> S;
}

wrapper! {
    /// A function of velocity as a friction law.
    OfVelocity
}

impl<L: VelocityLaw> FrictionLaw for OfVelocity<L> {
    type Memory<S: Varying> = ();

    fn check(&self) -> Result<(), ParameterError> {
        self.0.check()
    }

    fn may_differ_by_direction(&self) -> bool {
        true
    }

    fn is_non_stiff(&self) -> bool {
        L::IS_NON_STIFF
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) {}

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
        self.0.force(contact.velocity, contact.level)
    }
}
