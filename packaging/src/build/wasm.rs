//! The plant for the page: WebAssembly without imports, linked by LLVM's linker.

use std::path::PathBuf;

use anyhow::{Context, Result};

use super::recipe::Recipe;
use super::toolchain::{Target, Toolchain};
use super::tools::Tool;
use crate::workspace::Workspace;

/// The package that is built.
pub const PACKAGE: &str = "pneumatic-servo-playground";
const TRIPLE: &str = "wasm32-unknown-unknown";

/// A standard library and a linker.
///
/// # Errors
/// When the Rust compiler in use does not answer.
pub fn missing() -> Result<Vec<Tool>> {
    let mut missing: Vec<_> = Target::find(TRIPLE, TRIPLE)?.missing().into_iter().collect();
    if linker()?.is_none() {
        missing.push(Tool::new("rust-lld or wasm-ld", "a toolchain of rustup has it; or apt install lld"));
    }
    Ok(missing)
}

/// Builds the module.
///
/// # Errors
/// When a step of the build fails.
pub fn build(workspace: &Workspace) -> Result<Vec<u8>> {
    let (toolchain, triple) = Target::find(TRIPLE, TRIPLE)?.found()?;
    let linker = linker()?.context("no linker for WebAssembly was found")?;
    Recipe::for_target(workspace, toolchain, triple).package(PACKAGE).aborting().linker(triple, linker).run()
}

fn linker() -> Result<Option<PathBuf>> {
    Ok(Toolchain::in_use()?.rust_lld().or_else(|| which::which("wasm-ld").ok()))
}
