//! Friction laws behind one interface.
//!
//! A law is given the [`Contact`] (position, velocity, applied force, load factor) and answers with the friction
//! force, which is positive when it opposes a positive velocity. What it remembers is of two kinds: continuous
//! states (bristle deflections), integrated by the solver, and a memory (modes, stacks, generators) that only
//! changes at events. Laws know neither models nor solvers; a model may hold several contacts.
//!
//! | module | contents |
//! |---|---|
//! | [`catalogue`] | laws to choose from, made by `laws!` |
//! | [`contact`] | a law held by a model |
//! | `law` | the trait of a law |
//! | `event` | ends of the modes of a contact |
//! | `lubrication` | pressures that change the Stribeck velocity and the viscous friction of a law |
//! | `registry` | one line for each law |
//! | [`laws`] | the laws, one file each |
//! | `states` | the states of a contact as variables |
//! | `trend` | the acceleration of a prescribed motion |
//! | [`parts`] | parts of several laws, and the simpler kinds of law: of velocity, set-valued, of one bristle |

pub mod catalogue;
pub mod contact;
mod event;
pub mod law;
#[doc(hidden)]
pub mod laws;
mod lubrication;
pub mod parts;
mod registry;
pub(crate) mod states;
mod trend;

pub use contact::{FrictionContact, Observation};
pub use event::{Event, Indicators};
pub use law::{Contact, ContactLaw, Drive, FrictionLaw, LawState, MAX_STATES, StateKind, Stiction};
pub use lubrication::{Film, Lubrication, Rated};
pub use registry::{Friction, LAWS, Law, Memory};
pub(crate) use trend::{OVERWHELMING, Trend};
