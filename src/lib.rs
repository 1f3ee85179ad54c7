//! A friction-loaded pneumatic servo cylinder: friction laws, valve, chambers, and the solver that runs them.
//!
//! | room | what lives there |
//! |---|---|
//! | [`numbers`], [`variables`] | numbers with exact derivatives; the variable table |
//! | [`hybrid`] | what a hybrid system is |
//! | [`solver`] | the hybrid integrator, which knows equations but no cylinder |
//! | [`friction`], [`pneumatics`], [`mechanics`] | the physics |
//! | [`models`] | complete systems: equations, events and the variable table |
//! | [`model`], [`co_simulation`] | a model built by name, and run |

#![forbid(unsafe_code)]

pub mod co_simulation;
pub mod friction;
pub mod hybrid;
pub mod mechanics;
pub mod model;
pub mod models;
pub mod numbers;
pub mod pneumatics;
pub mod solver;
pub mod variables;
