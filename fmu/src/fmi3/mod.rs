//! The C interface of FMI 3.0, for co-simulation and model exchange: the C types and functions, for any model of a
//! [`Library`](crate::Library). Arrays are variables of their own here.
//!
//! | file | what it does |
//! |---|---|
//! | [`exports`] | the functions, declared once: C functions, and a table of them to load or to call |
//! | [`instantiation`] | instantiation, called by them |
//! | `callbacks` | the host's logger |
//! | `values` | values on their way between host and instance |
//! | [`types`] | the C types |

mod callbacks;
pub mod exports;
pub mod instantiation;
pub mod types;
mod values;

pub use crate::{LOG_CATEGORIES, LogCategory, guid};
