//! `cargo xtask build`: the shared libraries of platforms.

use std::collections::BTreeSet;

use anyhow::Result;
use clap::Args;

use crate::build;
use crate::library::Library;
use crate::platform::{Platform, Platforms};
use crate::process::heading;
use crate::tools;
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
        for library in build(workspace, &self.platforms.0)? {
            println!("{}", library.keep(workspace)?.display());
        }
        Ok(())
    }
}

/// Builds the library of each platform.
///
/// # Errors
/// When a tool is missing, a build fails or a library does not pass the gates.
pub fn build(workspace: &Workspace, platforms: &BTreeSet<Platform>) -> Result<Vec<Library>> {
    let missing = platforms.iter().map(|&platform| Ok((platform.folder(), build::missing(platform)?)));
    tools::require(missing.collect::<Result<Vec<_>>>()?)?;
    let mut libraries = Vec::new();
    for &platform in platforms {
        heading(&format!("Build the shared library for {platform}"));
        libraries.push(Library::for_everybody(workspace, platform)?);
    }
    Ok(libraries)
}
