//! `cargo xtask release`: the files that are published.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use lexopt::Arg::{Long, Short};
use lexopt::{Parser, ValueExt};
use pneumatic_servo_packaging::description::Version;
use pneumatic_servo_packaging::files;
use pneumatic_servo_packaging::package::{self, Package};
use pneumatic_servo_packaging::platform::{self, Binary, Platform};
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::ssp;
use pneumatic_servo_packaging::workspace::Workspace;
use sha2::{Digest, Sha256};

use crate::Work;
use crate::playground;

/// The help of the command.
pub const HELP: &str = "\
Build FMUs for all platforms and put what is published into target/release-files.

Usage: cargo xtask release [--binary PLATFORM=PATH]...

  --binary PLATFORM=PATH    a library that was built elsewhere from the same source; the others are built here

FMUs with sources in C, SSP, the page in which the plant runs, their checksums and a short README.

Examples:
  cargo xtask release                                   build everything here (docs/platforms.md says what that needs)
  cargo xtask release --binary win64=plant.dll --binary darwin64=plant.dylib   libraries from native machines

Afterwards:
  cd target/release-files && sha256sum --check SHA256SUMS";

/// Reads the options.
///
/// # Errors
/// When one is unknown or names no platform.
pub fn read(mut line: Parser) -> Result<Option<Work>> {
    let mut binaries: Vec<Binary> = Vec::new();
    while let Some(argument) = line.next()? {
        match argument {
            Short('h') | Long("help") => return Ok(None),
            Long("binary") => {
                let text = line.value()?.string()?;
                binaries.push(text.parse().with_context(|| format!("--binary {text}"))?);
            }
            other => return Err(other.unexpected().into()),
        }
    }
    Ok(Some(Box::new(move |workspace| run(workspace, &binaries))))
}

/// Packages for all platforms and collects the files.
fn run(workspace: &Workspace, binaries: &[Binary]) -> Result<()> {
    agree(&workspace.root)?;
    let page = playground::page(workspace)?;
    Package::for_everybody(binaries).run(workspace)?;
    heading("Collect the files");
    let mut contents = Vec::new();
    for (version, prefix) in [(Version::Fmi2, ""), (Version::Fmi3, "FMI3-")] {
        for file in package::fmus_of(workspace, version).chain([ssp::file(&workspace.fmus(), version)]) {
            contents.push((format!("{prefix}{}", name(&file)?), files::read(&file)?));
        }
    }
    contents.push(("playground.html".to_owned(), files::read(&page)?));
    contents.push(("README.txt".to_owned(), readme(&revision(&workspace.root)).into_bytes()));
    publish(&workspace.target.join("release-files"), contents)
}

/// Demands the version of the crates where people state it.
fn agree(root: &Path) -> Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    for (file, line) in [("CITATION.cff", format!("version: {version}")), ("CHANGELOG.md", format!("## [{version}]"))] {
        let text = files::text(root.join(file))?;
        ensure!(text.lines().any(|it| it.starts_with(&line)), "{file} should say `{line}`");
    }
    Ok(())
}

fn name(file: &Path) -> Result<String> {
    Ok(file.file_name().context("a file without a name")?.to_string_lossy().into_owned())
}

/// Writes files and their checksums into a folder that holds nothing else, and that is there when all is written.
fn publish(folder: &Path, contents: Vec<(String, Vec<u8>)>) -> Result<()> {
    ensure!(!contents.is_empty(), "there is nothing to publish");
    let partial = folder.with_extension("partial");
    for old in [folder, &partial].into_iter().filter(|old| old.exists()) {
        std::fs::remove_dir_all(old).with_context(|| format!("cannot remove the old {}", old.display()))?;
    }
    let mut sums = String::new();
    for (name, bytes) in contents {
        // As `sha256sum --check` reads it.
        let digest = Sha256::digest(&bytes);
        digest.iter().try_for_each(|byte| write!(sums, "{byte:02x}"))?;
        writeln!(sums, "  {name}")?;
        files::write(&partial.join(&name), bytes)?;
        println!("{}", folder.join(name).display());
    }
    files::write(&partial.join("SHA256SUMS"), sums)?;
    std::fs::rename(&partial, folder).with_context(|| format!("cannot make {}", folder.display()))
}

fn revision(root: &Path) -> String {
    let mut git = std::process::Command::new("git");
    let commit = process::output(git.args(["rev-parse", "HEAD"]).current_dir(root));
    commit.map_or_else(|_| "a folder without history".to_owned(), |commit| commit.trim().to_owned())
}

fn readme(revision: &str) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let platforms = platform::names(Platform::ALL);
    format!(
        "Pneumatic servo cylinder {version}\n\n\
         Functional mock-up units for {platforms}: FMI 2.0, and FMI 3.0 where the name begins\n\
         with FMI3; both for co-simulation and model exchange. A drive of cylinder and controller is there, too,\n\
         as SSP 1.0, and as SSP 2.0 of the FMUs for FMI 3.0.\n\
         Each holds its sources in C, too, for PLCs, real-time computers and microcontrollers.\n\
         Import an .fmu into your tool, or run it from Python:\n\n    \
         pip install fmpy\n    \
         fmpy validate PneumaticServoCylinder.fmu\n\n\
         playground.html runs the cylinder in a browser; open it.\n\
         Each FMU explains itself in documentation/index.html inside; licences are beside it.\n\
         On macOS, a downloaded FMU is in quarantine until `xattr -dr com.apple.quarantine FILE` takes it out.\n\
         Checksums: sha256sum --check SHA256SUMS\n\n\
         Built from commit {revision}.\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_version_is_stated() -> Result<()> {
        agree(&pneumatic_servo_packaging::workspace::home())
    }

    #[test]
    fn published_files_come_with_their_checksums_and_without_those_of_the_last_time() -> Result<()> {
        let folder = std::env::temp_dir().join(format!("release-{}", std::process::id()));
        publish(&folder, vec![("Old.fmu".to_owned(), vec![1])])?;
        publish(&folder, vec![("README.txt".to_owned(), b"abc".to_vec())])?;
        assert!(!folder.join("Old.fmu").exists());
        // FIPS 180-4 has this example.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  README.txt\n";
        assert_eq!(std::fs::read_to_string(folder.join("SHA256SUMS"))?, expected);
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }
}
