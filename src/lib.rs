//! A friction-loaded pneumatic servo cylinder, compiled as an FMI 2.0 co-simulation FMU.
//!
//! | room | what lives there |
//! |---|---|
//! | [`friction`] | the friction laws and their registry |
//! | [`pneumatics`], [`mechanics`] | gas, orifices, valve, chambers; force balance and end stops |
//! | [`models`] | complete systems: equations, events and the variable table |
//! | [`solver`] | the hybrid integrator, which knows equations but no cylinder |
//! | [`simulation`], [`variables`] | what the FMI layer sees of a model |
//! | [`fmi2`] | the C interface, the only place with `unsafe` |

pub mod fmi2;
pub mod friction;
pub mod mechanics;
pub mod models;
pub mod pair;
pub mod pneumatics;
pub mod random;
pub mod scalar;
pub mod simulation;
pub mod solver;
pub mod variables;
