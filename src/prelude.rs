//! What it takes to write a friction law, an actuator or a model of one's own: `use pneumatic_servo::prelude::*;`.
//!
//! | to write | implement | then |
//! |---|---|---|
//! | a law that is a function of velocity | [`VelocityLaw`] | a line in [`laws!`](crate::laws), as `OfVelocity<...>` |
//! | a law with a break-away force and a curve | [`SetValued`] | the same, as `StickSlip<...>` |
//! | a law with one bristle | [`BristleLaw`] | the same, as `OneBristle<...>` |
//! | any other law | [`FrictionLaw`] | the same, by its own name |
//! | an actuator of the cylinder | [`Actuating`] | a line in [`actuators!`](crate::actuators) |
//! | a model | [`System`], and [`Shortcuts`], which may stay empty | [`Model::of`](crate::model::Model::of) |
//!
//! Numbers of equations are generic ([`Scalar`]): evaluated with dual numbers they give exact derivatives. In products and
//! differences a number of the equations comes before a parameter (`v * self.damping`), and a parameter before a plain number
//! (`-self.b + 1.0`): a plain number on the left would lose the slope by the parameter.

pub use crate::friction::parts::of_velocity::{OfVelocity, VelocityLaw};
pub use crate::friction::parts::one_bristle::{BristleLaw, OneBristle};
pub use crate::friction::parts::stick_slip::{SetValued, StickSlip};
pub use crate::friction::{Contact, Drive, FrictionContact, FrictionLaw, Laws, StateKind, Stiction};
pub use crate::hybrid::{Sample, UNUSED};
pub use crate::model::{Course, Experiment, Model, Panel, Setup, Signal};
pub use crate::numbers::{Number, Scalar, sign};
pub use crate::pneumatics::actuator::{Actuating, Actuators};
pub use crate::system::{Event, Shortcuts, System, Tables};
pub use crate::variables::{
    Choice, Meaning, Notice, ParameterError, ParameterSet, Tunable, Unit, Values, Variable, units,
};
pub use crate::{actuators, enumeration, inputs, laws, outputs, parameters, states};
