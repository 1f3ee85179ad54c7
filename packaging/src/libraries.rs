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

#[cfg(test)]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::files;
    use crate::gates::made;
    use crate::stand_in::{self, StandIn};

    /// All that is missing for any platform is said before the first is built.
    #[test]
    fn libraries_are_built_and_kept_once_all_tools_are_there() -> Result<()> {
        let folder = files::scratch("libraries");
        let (workspace, library) = (Workspace::of_a_test(&folder), folder.join("built.so"));
        files::write(&library, made::linux())?;
        let build = |platforms: &str, machine: StandIn| {
            let platforms = platforms.parse().expect("platforms");
            machine.does(|| Build { platforms }.run(&workspace))
        };
        let sysroot = folder.join("sysroot");
        let machine = || {
            let library = library.clone();
            StandIn::new(move |it| it.says("rustc --release").then(|| stand_in::built(it, &library)))
                .compiling_for(&sysroot, &["x86_64-unknown-linux-gnu"])
        };
        let (outcome, started) = build("linux64,win64", machine());
        let problem = outcome.map_or_else(|problem| problem.to_string(), |()| String::new());
        assert!(problem.contains("for win64: ") && !problem.contains("linux64:"), "{problem}");
        assert!(!started.iter().any(|it| it.says("rustc --release")), "{started:?}");
        let (outcome, started) = build("linux64", machine());
        outcome?;
        assert!(started.iter().any(|it| it.says("--target x86_64-unknown-linux-gnu.2.17")), "{started:?}");
        assert_eq!(files::read(crate::library::kept(&workspace, Platform::Linux64))?, made::linux());
        Ok(std::fs::remove_dir_all(&folder)?)
    }
}
