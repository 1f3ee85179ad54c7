//! Building the shared library: quickly for this machine, or for everybody who has a platform.

pub mod aarch64;
mod linux;
mod macos;
mod recipe;
pub mod toolchain;
pub mod tools;
pub mod wasm;
mod windows;

use std::collections::BTreeSet;

use anyhow::Result;
use clap::Args;

use self::recipe::Recipe;
use self::toolchain::Toolchain;
use self::tools::Tool;
use crate::library::Library;
use crate::platform::{Platform, Platforms};
use crate::process::heading;
use crate::workspace::Workspace;

/// Build the shared libraries, the first half of `package`; they are left in target/binaries.
#[derive(Args)]
#[command(after_help = "\
Example:
  cargo xtask build --platforms win64     leaves target/binaries/win64/pneumatic_servo_fmu.dll")]
pub struct Build {
    /// `linux64,win64,darwin64` or `all`.
    #[arg(long)]
    platforms: Platforms,
}

impl Build {
    /// Leaves the library of each platform below `target/binaries`.
    ///
    /// # Errors
    /// When a tool is missing, a build fails or a library does not pass the gates.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        for library in libraries(workspace, &self.platforms.0)? {
            println!("{}", library.keep(workspace)?.display());
        }
        Ok(())
    }
}

/// Builds the library of each platform.
///
/// # Errors
/// When a tool is missing, a build fails or a library does not pass the gates.
pub fn libraries(workspace: &Workspace, platforms: &BTreeSet<Platform>) -> Result<Vec<Library>> {
    let missing = platforms.iter().map(|&platform| Ok((platform.folder(), missing(platform)?)));
    tools::require(missing.collect::<Result<Vec<_>>>()?)?;
    let mut libraries = Vec::new();
    for &platform in platforms {
        heading(&format!("Build the shared library for {platform}"));
        libraries.push(Library::for_everybody(workspace, platform)?);
    }
    Ok(libraries)
}

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
