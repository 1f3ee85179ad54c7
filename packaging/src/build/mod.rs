//! Building the shared library: quickly for this machine, or for everybody who has a platform.

pub mod aarch64;
mod linux;
mod macos;
mod recipe;
pub mod toolchain;
pub mod wasm;
mod windows;

use anyhow::Result;

use self::recipe::Recipe;
use self::toolchain::Toolchain;
use crate::platform::Platform;
use crate::tools::Tool;
use crate::workspace::Workspace;

/// The tools that the library of a platform needs and this machine lacks.
///
/// # Errors
/// When the Rust compiler in use does not answer.
pub fn missing(platform: Platform) -> Result<Vec<Tool>> {
    match platform {
        Platform::Linux64 => linux::missing(),
        Platform::Win64 => windows::missing(),
        Platform::Darwin64 => macos::missing(),
    }
}

/// The library that Cargo builds when nothing is asked of it but the machine it runs on.
///
/// # Errors
/// When Cargo fails.
pub fn for_this_machine(workspace: &Workspace) -> Result<Vec<u8>> {
    Recipe::of_the_user(workspace, Toolchain::in_use()?).run()
}

/// The library for every machine of a platform.
///
/// # Errors
/// When a step of the build fails.
pub fn for_everybody(workspace: &Workspace, platform: Platform) -> Result<Vec<u8>> {
    match platform {
        Platform::Linux64 => linux::build(workspace),
        Platform::Win64 => windows::build(workspace),
        Platform::Darwin64 => macos::build(workspace),
    }
}
