//! The shared library that every FMU holds: bytes that passed the gates of their platform.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock, PoisonError};

use anyhow::{Context, Result, ensure};

use crate::archive::Compressed;
use crate::build;
use crate::description::Version;
use crate::files;
use crate::gates::{self, Reach};
use crate::platform::{Binary, Platform};
use crate::process::heading;
use crate::timestamp::Timestamp;
use crate::tools;
use crate::workspace::Workspace;

/// A shared library.
#[derive(Clone)]
pub struct Library {
    /// Platform that it runs on.
    pub platform: Platform,
    /// The processors it runs on.
    pub architectures: BTreeSet<String>,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// The same for archives.
    compressed: OnceLock<Compressed>,
}

impl Library {
    /// Builds the library with the tools of this machine, for machines like it.
    ///
    /// # Errors
    /// When Cargo fails or the library does not pass the gates.
    pub fn for_this_machine(workspace: &Workspace) -> Result<Self> {
        let platform = Platform::host()?;
        Self::checked(workspace, platform, Reach::ThisMachine, build::for_this_machine(workspace)?)
    }

    /// The library that the tests ask: the one that is handed out, where this machine can build and run it, otherwise one for this
    /// machine alone. It is built once in a process: a second build would find nothing to do, but wait for others in its folder.
    ///
    /// # Errors
    /// When a step fails or the library does not pass the gates.
    pub fn for_tests(workspace: &Workspace) -> Result<Self> {
        static BUILT: Mutex<Option<(PathBuf, Library)>> = Mutex::new(None);
        let mut built = BUILT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, library)) = built.as_ref().filter(|(target, _)| *target == workspace.target) {
            return Ok(library.clone());
        }
        let library = Self::build_for_tests(workspace)?;
        *built = Some((workspace.target.clone(), library.clone()));
        Ok(library)
    }

    fn build_for_tests(workspace: &Workspace) -> Result<Self> {
        let platform = Platform::host()?;
        let is_handed_out =
            cfg!(all(target_os = "linux", target_arch = "x86_64")) && build::missing(platform)?.is_empty();
        if is_handed_out { Self::for_everybody(workspace, platform) } else { Self::for_this_machine(workspace) }
    }

    /// Builds the library of a platform for every machine of its kind.
    ///
    /// # Errors
    /// When a step fails or the library does not pass the gates.
    pub fn for_everybody(workspace: &Workspace, platform: Platform) -> Result<Self> {
        Self::checked(workspace, platform, Reach::Everybody, build::for_everybody(workspace, platform)?)
    }

    /// Reads a library that was built before, here or elsewhere.
    ///
    /// # Errors
    /// When it cannot be read or does not pass the gates.
    pub fn read(workspace: &Workspace, binary: &Binary) -> Result<Self> {
        let file = &binary.file;
        let bytes = files::read(file)?;
        Self::checked(workspace, binary.platform, Reach::Everybody, bytes)
            .with_context(|| format!("{} is refused", file.display()))
    }

    /// Writes it where [`kept`] says.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn keep(&self, workspace: &Workspace) -> Result<PathBuf> {
        let file = kept(workspace, self.platform);
        files::write(&file, &self.bytes)?;
        Ok(file)
    }

    /// Archives of the library with a time stamp, compressed once.
    ///
    /// # Errors
    /// When it is too large for the format.
    pub fn compressed(&self, timestamp: Timestamp) -> Result<Compressed> {
        if let Some(compressed) = self.compressed.get() {
            return Ok(compressed.clone());
        }
        let compressed = Compressed::program(&self.bytes, timestamp)?;
        Ok(self.compressed.get_or_init(|| compressed).clone())
    }

    /// Its folders in `binaries/`; in FMI 3.0 there is one for each processor.
    pub fn folders(&self, version: Version) -> Vec<String> {
        match version {
            Version::Fmi2 => vec![self.platform.folder().to_owned()],
            Version::Fmi3 => {
                self.architectures.iter().map(|name| format!("{name}-{}", self.platform.system())).collect()
            }
        }
    }

    fn checked(workspace: &Workspace, platform: Platform, reach: Reach, bytes: Vec<u8>) -> Result<Self> {
        let report = gates::check(platform, reach, &bytes, &workspace.private_paths())?;
        println!("{platform}: {report}");
        Ok(Self { platform, architectures: gates::architectures(&bytes)?, bytes, compressed: OnceLock::new() })
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

/// Where `cargo xtask build` leaves the library of a platform and `cargo xtask join` finds it.
pub fn kept(workspace: &Workspace, platform: Platform) -> PathBuf {
    let name = format!("pneumatic_servo_fmu.{}", platform.extension());
    workspace.target.join("binaries").join(platform.folder()).join(name)
}

/// The libraries that the user hands in, by platform.
///
/// # Errors
/// When a platform comes twice, or a file cannot be read or does not pass the gates.
pub fn handed_in(workspace: &Workspace, binaries: &[Binary]) -> Result<BTreeMap<Platform, Library>> {
    let mut libraries = BTreeMap::new();
    for binary in binaries {
        let platform = binary.platform;
        ensure!(!libraries.contains_key(&platform), "{platform} is handed in twice");
        libraries.insert(platform, Library::read(workspace, binary)?);
    }
    Ok(libraries)
}

/// Libraries for platforms: libraries that were handed in stay, and other wanted ones are built.
///
/// # Errors
/// Errors of the build.
pub fn complete(
    mut handed_in: BTreeMap<Platform, Library>,
    wanted: BTreeSet<Platform>,
    build: impl FnOnce(&BTreeSet<Platform>) -> Result<Vec<Library>>,
) -> Result<Vec<Library>> {
    let missing = wanted.into_iter().filter(|platform| !handed_in.contains_key(platform)).collect();
    handed_in.extend(build(&missing)?.into_iter().map(|library| (library.platform, library)));
    Ok(handed_in.into_values().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_processor_has_a_folder_of_its_own_in_fmi_3() {
        let library = |platform, names: &[&str]| Library {
            platform,
            architectures: names.iter().map(|name| (*name).to_owned()).collect(),
            bytes: Vec::new(),
            compressed: OnceLock::new(),
        };
        let linux = library(Platform::Linux64, &["x86_64"]);
        assert_eq!([Version::Fmi2, Version::Fmi3].map(|it| linux.folders(it)), [["linux64"], ["x86_64-linux"]]);
        let mac = library(Platform::Darwin64, &["aarch64", "x86_64"]);
        assert_eq!(mac.folders(Version::Fmi3), ["aarch64-darwin", "x86_64-darwin"]);
    }

    #[test]
    fn a_library_that_was_handed_in_is_neither_built_nor_replaced() -> Result<()> {
        let library = |platform, byte: u8| Library {
            platform,
            architectures: BTreeSet::new(),
            bytes: vec![byte],
            compressed: OnceLock::new(),
        };
        let handed_in = [Platform::Linux64, Platform::Darwin64].map(|platform| (platform, library(platform, 1))).into();
        let wanted = [Platform::Linux64, Platform::Win64].into();
        let libraries = complete(handed_in, wanted, |missing| {
            assert_eq!(*missing, [Platform::Win64].into());
            Ok(missing.iter().map(|&platform| library(platform, 2)).collect())
        })?;
        let found: Vec<_> = libraries.iter().map(|library| (library.platform, library.bytes[0])).collect();
        assert_eq!(found, [(Platform::Linux64, 1), (Platform::Win64, 2), (Platform::Darwin64, 1)]);
        Ok(())
    }

    fn problem(binaries: &[Binary]) -> Result<String> {
        Ok(handed_in(&Workspace::of_the_project()?, binaries)
            .map(|_| ())
            .map_or_else(|error| format!("{error:#}"), |()| String::new()))
    }

    #[test]
    fn a_file_that_is_not_there_is_named() -> Result<()> {
        let problem = problem(&["win64=no/such.dll".parse()?])?;
        assert!(problem.contains("cannot read no/such.dll"), "{problem}");
        Ok(())
    }

    #[test]
    fn a_file_that_is_no_library_is_refused() -> Result<()> {
        let manifest = concat!("linux64=", env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
        let problem = problem(&[manifest.parse()?])?;
        assert!(problem.contains("Cargo.toml is refused"), "{problem}");
        Ok(())
    }
}
