//! Linux on 64-bit Arm: no platform of FMI 2.0, but a second processor to compare trajectories with.

use anyhow::Result;

use super::recipe::Recipe;
use super::toolchain::Target;
use crate::tools::Tool;
use crate::workspace::Workspace;

/// The C compiler, which also links.
pub const COMPILER: &str = "aarch64-linux-gnu-gcc";
const TRIPLE: &str = "aarch64-unknown-linux-gnu";

/// A standard library and a linker.
///
/// # Errors
/// When the Rust compiler in use does not answer.
pub fn missing() -> Result<Vec<Tool>> {
    let linker = Tool::unless_found(COMPILER, "gcc-aarch64-linux-gnu libc6-dev-arm64-cross");
    Ok(Target::find(TRIPLE, TRIPLE)?.missing().into_iter().chain(linker).collect())
}

/// Builds the library.
///
/// # Errors
/// When a step of the build fails.
pub fn build(workspace: &Workspace) -> Result<Vec<u8>> {
    let (toolchain, triple) = Target::find(TRIPLE, TRIPLE)?.found()?;
    Recipe::for_target(workspace, toolchain, triple).linker(triple, COMPILER).run()
}
