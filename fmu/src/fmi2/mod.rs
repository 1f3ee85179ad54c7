//! The C interface of FMI 2.0, for co-simulation and model exchange: the C types and functions, for any model of a
//! [`Library`](crate::Library).
//!
//! | file | what it does |
//! |---|---|
//! | [`exports`] | the functions, declared once: C functions, and a table of them to load or to call |
//! | `callbacks` | the host's logger |
//! | `status` | what is told about the last step |
//! | [`types`] | the C types |

mod callbacks;
pub mod exports;
mod status;
pub mod types;

pub use crate::{LOG_CATEGORIES, LogCategory, guid};
