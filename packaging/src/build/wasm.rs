//! The plant as WebAssembly, for the page and for sources in C, linked by LLVM's linker.

use std::path::PathBuf;

use anyhow::{Context, Result};

use super::recipe::Recipe;
use super::toolchain::{Target, Toolchain};
use crate::process;
use crate::tools::Tool;
use crate::workspace::Workspace;

/// The package that is built for the page.
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

/// Builds the module for the page.
///
/// # Errors
/// When a step of the build fails.
pub fn build(workspace: &Workspace) -> Result<Vec<u8>> {
    let (toolchain, triple) = Target::find(TRIPLE, TRIPLE)?.found()?;
    let linker = linker()?.context("no linker for WebAssembly was found")?;
    Recipe::for_target(workspace, toolchain, triple).package(PACKAGE).aborting().linker(triple, linker).run()
}

/// Builds the module of one model of the library from which sources are made: of the package that has the models, whoever's it
/// is.
///
/// # Errors
/// When a step of the build fails.
pub fn of_model(workspace: &Workspace, model: &str, is_small: bool) -> Result<Vec<u8>> {
    let (toolchain, triple) = Target::find(TRIPLE, TRIPLE)?.found()?;
    let linker = linker()?.context("no linker for WebAssembly was found")?;
    let recipe = Recipe::for_target(workspace, toolchain, triple)
        .aborting()
        .linker(triple, linker)
        .feature("pneumatic-servo-fmu/module")
        .variable("FMU_ONLY_MODEL", model)
        .setting("lto='fat'")
        // What calls need at most, several times over; a stack that overflows traps.
        .link("-zstack-size=262144");
    if !is_small {
        return recipe.run();
    }
    // The plant is a little larger in this way, and several times faster: its matrices are not called element by element.
    recipe
        .setting("opt-level='z'")
        .setting("package.pneumatic-servo.opt-level='s'")
        .feature("pneumatic-servo-fmu/small")
        .run()
}

fn linker() -> Result<Option<PathBuf>> {
    Ok(Toolchain::in_use()?.rust_lld().or_else(|| process::find("wasm-ld")))
}
