//! Imports for a friction law, an actuator or a model of your own: `use pneumatic_servo::prelude::*;`.
//!
//! | to write | implement | then |
//! |---|---|---|
//! | a law that is a function of velocity | [`VelocityLaw`] | a line in [`laws!`](crate::laws), as `OfVelocity<...>` |
//! | a law with a break-away force and a curve | [`SetValued`] | the same, as `StickSlip<...>` |
//! | a law with one bristle | [`BristleLaw`] | the same, as `OneBristle<...>` |
//! | any other law | [`FrictionLaw`] | the same, by its own name |
//! | an actuator of the cylinder | [`Actuating`] | a line in [`actuators!`](crate::actuators) |
//! | a model | [`System`] | [`Model::of`](crate::model::Model::of) |
//!
//! Numbers of equations are generic ([`Scalar`]): evaluated with dual numbers they give exact derivatives, and with
//! [`Real`] ones, as in a run, values alone. A number of the equations comes before a parameter: `v * self.damping`. An `f64` is
//! none of them: `Real::of(value)` makes one of it, and `.value` gives it back.

pub use crate::friction::parts::of_velocity::{OfVelocity, VelocityLaw};
pub use crate::friction::parts::one_bristle::{BristleLaw, OneBristle};
pub use crate::friction::parts::stick_slip::{SetValued, StickSlip};
pub use crate::friction::{Contact, ContactLaw, Drive, FrictionContact, FrictionLaw, LawState, StateKind, Stiction};
pub use crate::model::{Course, Experiment, Model, Panel, Setup, Signal};
pub use crate::numbers::{Number, Real, Scalar, Varying, sign};
pub use crate::pneumatics::actuator::Actuating;
pub use crate::system::{Event, Holder, Holds, Part, PartFacts, System, Tables};
pub use crate::system::{Sample, UNUSED};
pub use crate::variables::{
    Choice, Fixed, Meaning, Notice, ParameterError, ParameterSet, Tunable, Unit, Values, Variable, units,
};
pub use crate::{actuators, enumeration, holds, inputs, laws, outputs, parameters, states};
