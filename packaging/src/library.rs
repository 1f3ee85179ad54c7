//! The shared library that every FMU holds: building it, and what it may export.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use object::Object;

use crate::platform::Platform;
use crate::process;
use crate::workspace::Workspace;

/// A built shared library.
pub struct Library {
    /// What it runs on.
    pub platform: Platform,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl Library {
    /// Builds the release library for this machine and checks it.
    ///
    /// # Errors
    /// When Cargo fails, or the library exports anything but the functions of FMI 2.0.
    pub fn build(workspace: &Workspace) -> Result<Self> {
        Self::read(Platform::host()?, &compile(workspace)?)
    }

    /// Reads a library that was built before, here or elsewhere, and checks it.
    ///
    /// # Errors
    /// When it cannot be read, or exports anything but the functions of FMI 2.0.
    pub fn read(platform: Platform, file: &Path) -> Result<Self> {
        let bytes = std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
        check_exports(&exports(&bytes)?).with_context(|| file.display().to_string())?;
        Ok(Self { platform, bytes })
    }
}

/// Runs Cargo and returns the file it made.
fn compile(workspace: &Workspace) -> Result<PathBuf> {
    let mut command = process::cargo();
    // The crate is a Rust library too; only a build of the shared library alone is optimized at link time.
    command
        .args(["rustc", "--release", "--package", "pneumatic-servo-fmu", "--lib", "--crate-type", "cdylib"])
        .args(["--config", "profile.release.strip='symbols'", "--message-format", "json-render-diagnostics"])
        .env("CARGO_ENCODED_RUSTFLAGS", flags(workspace))
        .current_dir(&workspace.root);
    let messages = process::output(&mut command)?;
    let file = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter(|message| message["target"]["name"] == "pneumatic_servo")
        .find_map(|message| message["filenames"].as_array()?.iter().find_map(|name| shared_library(name.as_str()?)));
    file.context("cargo rustc reported no shared library")
}

fn shared_library(name: &str) -> Option<PathBuf> {
    name.ends_with(std::env::consts::DLL_SUFFIX).then(|| PathBuf::from(name))
}

/// The user's compiler flags, and no path of this machine inside the library.
fn flags(workspace: &Workspace) -> String {
    let mut flags: Vec<String> = match std::env::var("CARGO_ENCODED_RUSTFLAGS") {
        Ok(encoded) => encoded.split('\x1f').filter(|flag| !flag.is_empty()).map(str::to_owned).collect(),
        Err(_) => std::env::var("RUSTFLAGS").unwrap_or_default().split_whitespace().map(str::to_owned).collect(),
    };
    let home = std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| std::env::home_dir().map(|home| home.join(".cargo")));
    if let Some(home) = home {
        flags.push(format!("--remap-path-prefix={}=cargo", home.display()));
    }
    flags.push(format!("--remap-path-prefix={}=.", workspace.root.display()));
    flags.join("\x1f")
}

/// The names of all symbols that a shared library defines for others.
fn exports(bytes: &[u8]) -> Result<BTreeSet<String>> {
    let file = object::File::parse(bytes).context("not a shared library")?;
    let mut names = BTreeSet::new();
    for export in file.exports().context("unreadable table of exports")? {
        let name = export.context("unreadable export")?.into_name().into_name();
        names.insert(name.map_or_else(|| "(a number)".to_owned(), |name| String::from_utf8_lossy(&name).into_owned()));
    }
    Ok(names)
}

/// Every function that FMI 2.0 defines for all FMUs and for co-simulation, and nothing else, must be there.
fn check_exports(exports: &BTreeSet<String>) -> Result<()> {
    let wanted: BTreeSet<String> = FUNCTIONS.iter().map(|name| format!("fmi2{name}")).collect();
    let names = |set: &mut dyn Iterator<Item = &String>| set.map(String::as_str).collect::<Vec<_>>().join(", ");
    let missing = names(&mut wanted.difference(exports));
    if !missing.is_empty() {
        bail!("functions of FMI 2.0 are missing: {missing}");
    }
    let foreign = names(&mut exports.difference(&wanted));
    if !foreign.is_empty() {
        bail!("exports that are no functions of FMI 2.0: {foreign}");
    }
    Ok(())
}

/// The functions, without their prefix.
const FUNCTIONS: &[&str] = &[
    "GetTypesPlatform",
    "GetVersion",
    "SetDebugLogging",
    "Instantiate",
    "FreeInstance",
    "SetupExperiment",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "Terminate",
    "Reset",
    "GetReal",
    "GetInteger",
    "GetBoolean",
    "GetString",
    "SetReal",
    "SetInteger",
    "SetBoolean",
    "SetString",
    "GetFMUstate",
    "SetFMUstate",
    "FreeFMUstate",
    "SerializedFMUstateSize",
    "SerializeFMUstate",
    "DeSerializeFMUstate",
    "GetDirectionalDerivative",
    "SetRealInputDerivatives",
    "GetRealOutputDerivatives",
    "DoStep",
    "CancelStep",
    "GetStatus",
    "GetRealStatus",
    "GetIntegerStatus",
    "GetBooleanStatus",
    "GetStringStatus",
];

#[cfg(test)]
mod tests {
    use super::*;

    fn standard() -> BTreeSet<String> {
        FUNCTIONS.iter().map(|name| format!("fmi2{name}")).collect()
    }

    #[test]
    fn the_functions_of_the_standard_pass() {
        assert!(check_exports(&standard()).is_ok());
    }

    #[test]
    fn a_missing_function_is_named() {
        let mut exports = standard();
        exports.remove("fmi2DoStep");
        let message = check_exports(&exports).unwrap_err().to_string();
        assert_eq!(message, "functions of FMI 2.0 are missing: fmi2DoStep");
    }

    #[test]
    fn a_foreign_symbol_is_named() {
        let mut exports = standard();
        exports.insert("rust_eh_personality".to_owned());
        let message = check_exports(&exports).unwrap_err().to_string();
        assert_eq!(message, "exports that are no functions of FMI 2.0: rust_eh_personality");
    }
}
