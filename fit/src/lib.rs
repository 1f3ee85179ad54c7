//! Identification: parameters of a model from measured data.
//!
//! A [`Problem`](problem::Problem) compares measured segments with their simulation. A search makes the residuals least within
//! bounds and from several starts ([`search`]); its derivatives become intervals, and name the parameters that the data do not
//! determine ([`intervals`]). The Python package and the page of the browser call the same functions.

#![forbid(unsafe_code)]

pub mod arrays;
pub mod calibration;
pub mod candidates;
pub mod causes;
pub mod cross_validation;
pub mod distributions;
pub mod driver;
pub mod experiment;
pub mod expression;
pub mod fitting;
pub mod friction_table;
pub mod guess;
pub mod intervals;
pub mod jacobian;
pub mod law;
pub mod machine_units;
pub mod matrix;
pub mod nonnegative;
mod number;
pub mod numerals;
pub mod parameter;
pub mod plausibility;
pub mod problem;
pub mod profile;
pub mod record;
mod refused;
pub mod runs;
pub mod search;
pub mod sensor;
pub mod series;
pub mod signals;
pub mod simulation;
pub mod smoothing;
mod steady;
pub mod study;
pub mod tables;
pub mod units;
pub mod verdict;

pub use refused::{NoAnswer, Refused};
