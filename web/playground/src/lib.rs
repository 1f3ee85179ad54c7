//! The plant for a web page: models, variables and runs behind plain functions of WebAssembly.
//!
//! The page writes numbers into a buffer, calls a function, and reads numbers or a text back. Everything it passes is
//! checked first, because a panic would end the page.

mod error;
mod exports;
mod fit;
mod friction_table;
mod index;
mod own_fmu;
mod plausibility;
mod session;
mod ssv;
mod table;
mod tables;

pub use error::CallError;
pub use fit::{estimable, fit};
pub use friction_table::{friction_columns, friction_table};
pub use own_fmu::own_fmu;
pub use plausibility::findings;
pub use session::{BUFFER, SLOTS, Session};
pub use table::{proposed_columns, read_table, scale, table_signals};
pub use tables::tables;
