//! The plant as an FMU: the C interface to every model of [`pneumatic_servo`].

pub mod fmi2;
