//! linux64: linked by Zig against an old glibc, on any machine.

use anyhow::Result;

use super::recipe::Recipe;
use super::toolchain::Toolchain;
use crate::gates;
use crate::tools::Tool;
use crate::venv::{self, Requirements, Venv};
use crate::workspace::Workspace;

const TRIPLE: &str = "x86_64-unknown-linux-gnu";

/// Zig comes from PyPI.
pub fn missing() -> Result<Vec<Tool>> {
    let mut missing: Vec<_> = venv::missing().into_iter().collect();
    if !Toolchain::in_use()?.has(TRIPLE) {
        missing.push(Tool::new(format!("Rust's standard library for {TRIPLE}"), format!("rustup target add {TRIPLE}")));
    }
    Ok(missing)
}

/// Builds the library.
pub fn build(workspace: &Workspace) -> Result<Vec<u8>> {
    let venv = Venv::prepare(workspace, Requirements::ZIG)?;
    let (major, minor) = gates::NEWEST_GLIBC;
    Recipe::for_target(workspace, Toolchain::in_use()?, &format!("{TRIPLE}.{major}.{minor}"))
        .through(venv.program("cargo-zigbuild"))
        .variable("PATH", venv.path()?)
        .variable("CARGO_ZIGBUILD_CACHE_DIR", workspace.environments.join("zig-cache"))
        .variable("ZIG_GLOBAL_CACHE_DIR", workspace.environments.join("zig-cache"))
        .run()
}
