//! Hosts made with the crate `fmi`, an FMI implementation that shares nothing with the one of this repository.
//!
//! Their tests import the FMUs that `cargo xtask package` left. The crate needs libclang to be built, which
//! `cargo xtask test` provides, and it is left out unless the feature `fmi` asks for it.

#![cfg(feature = "fmi")]

pub mod fmi2;
pub mod fmi3;
mod host;
mod integrator;

use std::path::{Path, PathBuf};

pub use host::{Host, Version};
pub use integrator::{Exchange, Integrator};

/// The folder with the packaged FMUs.
pub fn fmus() -> PathBuf {
    product("FMU_FOLDER", "fmu")
}

/// A folder that `cargo xtask` leaves, wherever the variable says it is.
fn product(variable: &str, name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    std::env::var_os(variable).map_or_else(|| target.join(name), PathBuf::from)
}
