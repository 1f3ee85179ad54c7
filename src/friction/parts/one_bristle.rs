//! Laws with one bristle: a continuous state, its deflection in m.

use std::fmt::Debug;

use serde::{Serialize, de::DeserializeOwned};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw};
use crate::numbers::{Dual, Scalar};
use crate::variables::{Notice, ParameterError, ParameterSet};

/// A law whose friction is that of one bristle, which is without deflection at first.
pub trait BristleLaw: ParameterSet {
    /// What the law remembers apart from the deflection; its default is what a run starts with.
    type Memory: Clone + Default + PartialEq + Debug + Serialize + DeserializeOwned + Send;

    /// Whether the secant `(v - dz/dt)/z` tells the rate of relaxation: the deflection follows the velocity `v` but for a
    /// share that grows with it, about in proportion. It saves an evaluation.
    const RELAXES_BY_SECANT: bool = false;

    /// The drives under which the memory [follows](Self::follow) the motion.
    fn follows(&self) -> &'static [Drive] {
        &[]
    }

    /// Checks that parameters which are legal one by one fit together.
    ///
    /// # Errors
    /// [`ParameterError`] if they do not.
    fn check(&self) -> Result<(), ParameterError> {
        Ok(())
    }

    /// The events that its parameters leave possible.
    fn events(&self) -> &'static [Event] {
        &[]
    }

    /// Whether force and deflection change gently within a mode, but for a relaxation of the deflection.
    fn is_gentle(&self) -> bool {
        true
    }

    /// What is unusual about the parameters.
    fn notice(&self) -> Option<Notice> {
        None
    }

    /// Magnitude of the deflection in m, for error control.
    fn scale(&self) -> f64;

    /// The friction force in N, and the rate of the deflection `z` in m/s.
    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, memory: &Self::Memory) -> (S, S);

    /// Sets the event indicators that the present mode uses.
    fn indicators(&self, _contact: &Contact<f64>, _z: f64, _memory: &Self::Memory, _out: &mut Indicators) {}

    /// Handles an event, whose indicator fell below zero; may set the deflection.
    fn switch(&self, _event: Event, _contact: &Contact<f64>, _z: &mut f64, _memory: &mut Self::Memory) {}

    /// Lets the memory follow an accepted step; must leave the indicators as they are. Returns whether the force may have
    /// changed.
    fn follow(&self, _contact: &Contact<f64>, _z: f64, _memory: &mut Self::Memory) -> bool {
        false
    }
}

/// Share of the scale of a deflection below which the secant would be one of rounding.
const SMALL: f64 = 1e-6;

wrapper! {
    /// A bristle as a friction law.
    OneBristle
}

impl<L: BristleLaw> FrictionLaw for OneBristle<L> {
    type Memory = L::Memory;

    fn follows(&self) -> &'static [Drive] {
        self.0.follows()
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.0.check()
    }

    fn events(&self) -> &'static [Event] {
        self.0.events()
    }

    fn states(&self) -> usize {
        1
    }

    fn is_gentle(&self) -> bool {
        self.0.is_gentle()
    }

    fn notice(&self) -> Option<Notice> {
        self.0.notice()
    }

    fn relaxation(&self, contact: &Contact<f64>, [z, rate]: [f64; 2], memory: &L::Memory) -> f64 {
        if L::RELAXES_BY_SECANT && z.abs() > SMALL * self.0.scale() {
            return (contact.velocity - rate) / z;
        }
        let (_, rate) = self.0.force(&contact.held(), Dual::<1>::variable(z, 0), memory);
        -rate.slope[0]
    }

    fn state_scale(&self) -> f64 {
        self.0.scale()
    }

    fn start(&self, _contact: &Contact<f64>) -> L::Memory {
        L::Memory::default()
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &L::Memory, rates: &mut [S]) -> S {
        let (force, rate) = self.0.force(contact, z[0], memory);
        rates[0] = rate;
        force
    }

    fn indicators(&self, contact: &Contact<f64>, z: &[f64], memory: &L::Memory, out: &mut Indicators) {
        self.0.indicators(contact, z[0], memory, out);
    }

    fn switch(&self, event: Event, contact: &Contact<f64>, _v: &mut f64, z: &mut [f64], memory: &mut L::Memory) {
        self.0.switch(event, contact, &mut z[0], memory);
    }

    fn follow(&self, contact: &Contact<f64>, z: &[f64], memory: &mut L::Memory) -> bool {
        self.0.follow(contact, z[0], memory)
    }
}
