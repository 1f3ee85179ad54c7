//! Laws with one bristle: a continuous state, its deflection in m.

use std::fmt::Debug;

use serde::{Serialize, de::DeserializeOwned};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw};
use crate::friction::lubrication::Film;
use crate::numbers::{Dual, Scalar, Varying};
use crate::variables::{Notice, ParameterError, ParameterSet};

/// A law of one bristle, undeflected at the start.
pub trait BristleLaw: ParameterSet {
    /// Discrete state of the law; its default is the start of a run.
    type Memory<S: Varying>: Clone + Default + PartialEq + Debug + Serialize + DeserializeOwned + Send;

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

    /// Whether the load factor may depend on the direction of motion: where it limits the deflection, and not the force of one.
    fn may_differ_by_direction(&self) -> bool {
        false
    }

    /// Whether Stribeck velocity and viscous friction may be multiplied by factors, with a [force](Self::lubricated_force) for it.
    fn is_lubricated(&self) -> bool {
        false
    }

    /// Whether force and deflection change gently within a mode, but for a relaxation of the deflection.
    fn is_non_stiff(&self) -> bool {
        true
    }

    /// Warning about the parameters.
    fn notice(&self) -> Option<Notice> {
        None
    }

    /// Magnitude of the deflection in m, for error control.
    fn scale(&self) -> f64;

    /// The friction force in N, and the rate of the deflection `z` in m/s.
    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, memory: &Self::Memory<S::Held>) -> (S, S);

    /// The same with factors on Stribeck velocity and viscous friction, of a law that [follows](Self::is_lubricated) them.
    fn lubricated_force<S: Scalar>(
        &self,
        contact: &Contact<S>,
        _film: impl Film<S>,
        z: S,
        memory: &Self::Memory<S::Held>,
    ) -> (S, S) {
        self.force(contact, z, memory)
    }

    /// Sets the event indicators that the present mode uses.
    fn indicators<S: Varying>(
        &self,
        _contact: &Contact<S>,
        _z: S,
        _memory: &Self::Memory<S>,
        _out: &mut Indicators<S>,
    ) {
    }

    /// Handles an event, whose indicator fell below zero; may set the deflection.
    fn switch<S: Varying>(&self, _event: Event, _contact: &Contact<S>, _z: &mut S, _memory: &mut Self::Memory<S>) {}

    /// Lets the memory follow an accepted step; must leave the indicators as they are. Returns whether the force may have
    /// changed.
    fn follow<S: Varying>(&self, _contact: &Contact<S>, _z: S, _memory: &mut Self::Memory<S>) -> bool {
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
    type Memory<S: Varying> = L::Memory<S>;

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

    fn may_differ_by_direction(&self) -> bool {
        self.0.may_differ_by_direction()
    }

    fn is_lubricated(&self) -> bool {
        self.0.is_lubricated()
    }

    fn is_non_stiff(&self) -> bool {
        self.0.is_non_stiff()
    }

    fn notice(&self) -> Option<Notice> {
        self.0.notice()
    }

    fn relaxation_rate<S: Varying>(&self, contact: &Contact<S>, state: [S; 2], memory: &L::Memory<S>) -> f64 {
        let (contact, [z, rate]) = (contact.values(), state.map(S::value));
        if L::RELAXES_BY_SECANT && z.abs() > SMALL * self.0.scale() {
            return (contact.velocity - rate) / z;
        }
        let (_, rate) = self.0.force(&contact.still(), Dual::<1, S>::variable(z, 0), memory);
        -rate.slope[0]
    }

    fn state_scale(&self) -> f64 {
        self.0.scale()
    }

    fn start<S: Varying>(&self, _contact: &Contact<S>) -> L::Memory<S> {
        L::Memory::default()
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: &[S], memory: &L::Memory<S::Held>, rates: &mut [S]) -> S {
        let (force, rate) = self.0.force(contact, z[0], memory);
        rates[0] = rate;
        force
    }

    fn lubricated_force<S: Scalar>(
        &self,
        contact: &Contact<S>,
        film: impl Film<S>,
        z: &[S],
        memory: &L::Memory<S::Held>,
        rates: &mut [S],
    ) -> S {
        let (force, rate) = self.0.lubricated_force(contact, film, z[0], memory);
        rates[0] = rate;
        force
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, z: &[S], memory: &L::Memory<S>, out: &mut Indicators<S>) {
        self.0.indicators(contact, z[0], memory, out);
    }

    fn switch<S: Varying>(
        &self,
        event: Event,
        contact: &Contact<S>,
        _v: &mut S,
        z: &mut [S],
        memory: &mut L::Memory<S>,
    ) {
        self.0.switch(event, contact, &mut z[0], memory);
    }

    fn follow<S: Varying>(&self, contact: &Contact<S>, z: &[S], memory: &mut L::Memory<S>) -> bool {
        self.0.follow(contact, z[0], memory)
    }
}
