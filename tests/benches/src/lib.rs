//! Measures the cost of a step, and compares it at equal error with general stiff solvers on the same equations.
//!
//! | file | what it does |
//! |---|---|
//! | `case` | the friction laws with their parameters, and the experiment |
//! | `host` | drives an FMU through its C interface |
//! | `plant` | our equations, events and inputs as a general solver meets them |
//! | `rival` | general solvers (CVODE, diffsol) on them, with our error weights |
//! | `error` | trajectories and their deviation from a reference |
//! | `precision` | cost against error, and the ratio of two costs at equal error |
//! | `latency` | the distribution of the cost of a communication step |
//! | `report` | the report, the measured points and the figure |
//! | `page` | the tables of `docs/performance.md`, and the files beside it |
//!
//! `benches/calls.rs` times single calls with criterion, `benches/comparison.rs` writes the report.

pub mod case;
pub mod error;
pub mod host;
pub mod latency;
#[cfg(feature = "rival")]
pub mod page;
pub mod plant;
#[cfg(feature = "rival")]
pub mod precision;
#[cfg(feature = "rival")]
pub mod report;
#[cfg(feature = "rival")]
pub mod rival;
