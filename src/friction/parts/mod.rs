//! What several laws are made of.

pub mod anchored;
pub mod bounded;
pub mod curve;
pub mod delay;
pub mod elements;
pub mod fading;
pub mod levels;
pub mod list;
pub mod parameters;
pub mod ramp;
pub mod stick_slip;
