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
    // Stack of several times the largest need of a call; an overflow traps.
    let recipe = module(workspace, 262_144)?.feature("pneumatic-servo-fmu/module").variable("FMU_ONLY_MODEL", model);
    if is_small { small(workspace, recipe).feature("pneumatic-servo-fmu/small").run() } else { recipe.run() }
}

/// Builds the module of a loop alone, with bytes of stack and features of its crate.
///
/// # Errors
/// When a step of the build fails.
pub fn of_loop(workspace: &Workspace, stack: u32, features: &[String]) -> Result<Vec<u8>> {
    // The heap begins where the data ends, not with the next page.
    let recipe = small(workspace, module(workspace, stack)?.link_alone("--export=__heap_base"));
    features.iter().fold(recipe, |recipe, feature| recipe.feature(feature)).run()
}

fn module(workspace: &Workspace, stack: u32) -> Result<Recipe<'_>> {
    let (toolchain, triple) = Target::find(TRIPLE, TRIPLE)?.found()?;
    let linker = linker()?.context("no linker for WebAssembly was found")?;
    let recipe = Recipe::for_target(workspace, toolchain, triple).aborting().linker(triple, linker);
    Ok(recipe.setting("lto='fat'").link_alone(&format!("-zstack-size={stack}")))
}

/// The plant is a little larger in this way, and several times faster: its matrices are not called element by element. What is
/// generic is compiled with the crate that uses it.
fn small<'a>(workspace: &Workspace, recipe: Recipe<'a>) -> Recipe<'a> {
    let recipe = recipe.setting("opt-level='z'").setting("package.pneumatic-servo.opt-level='s'");
    let product = &workspace.product;
    if product.is_of_the_project() {
        return recipe;
    }
    recipe.setting(&format!("package.{}.opt-level='s'", product.package))
}

fn linker() -> Result<Option<PathBuf>> {
    Ok(Toolchain::in_use()?.rust_lld().or_else(|| process::find("wasm-ld")))
}
