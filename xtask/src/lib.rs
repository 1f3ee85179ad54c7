//! What `cargo xtask` does by itself.

pub mod new;
