//! One run of Cargo that makes the shared library.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cargo_metadata::Message;
use cargo_metadata::camino::Utf8PathBuf;

use super::toolchain::Toolchain;
use crate::files;
use crate::process;
use crate::workspace::Workspace;

/// Arguments of Cargo.
pub struct Recipe<'a> {
    workspace: &'a Workspace,
    toolchain: Toolchain,
    program: PathBuf,
    package: String,
    panic: &'static str,
    target: Vec<OsString>,
    folder: PathBuf,
    strip: &'static str,
    flags: Vec<String>,
    /// Flags of the library alone, not of its dependencies.
    own_flags: Vec<String>,
    settings: Vec<String>,
    features: Vec<String>,
    environment: Vec<(String, OsString)>,
}

impl<'a> Recipe<'a> {
    /// Builds for this machine, with the user's own compiler flags.
    pub fn of_the_user(workspace: &'a Workspace, toolchain: Toolchain) -> Self {
        let flags = users_flags();
        let (program, folder) = (toolchain.cargo.clone(), workspace.target.clone());
        Self {
            workspace,
            toolchain,
            program,
            package: workspace.product.package.clone(),
            panic: "unwind",
            target: Vec::new(),
            folder,
            strip: "symbols",
            flags,
            own_flags: Vec::new(),
            settings: Vec::new(),
            features: Vec::new(),
            environment: Vec::new(),
        }
    }

    /// Builds for a target; of the user's own settings nothing gets in.
    pub fn for_target(workspace: &'a Workspace, toolchain: Toolchain, triple: &str) -> Self {
        let target = vec!["--target".into(), triple.into()];
        // All targets share a folder, so that procedural macros are compiled once.
        let folder = workspace.target.join("cross");
        Self { target, folder, flags: Vec::new(), ..Self::of_the_user(workspace, toolchain) }
    }

    /// Builds the library of another package.
    pub fn package(mut self, package: &str) -> Self {
        self.package = package.to_owned();
        self
    }

    /// Lets a panic end the program, where nothing can catch it.
    pub fn aborting(mut self) -> Self {
        self.panic = "abort";
        self
    }

    /// Starts Cargo through another program.
    pub fn through(mut self, program: PathBuf) -> Self {
        self.program = program;
        self
    }

    /// Changes the release profile: `opt-level='z'`.
    pub fn setting(mut self, setting: &str) -> Self {
        self.settings.push(format!("profile.release.{setting}"));
        self
    }

    /// Switches a feature of the package on.
    pub fn feature(mut self, feature: &str) -> Self {
        self.features.push(feature.to_owned());
        self
    }

    /// Adds a compiler flag.
    pub fn flag(mut self, flag: impl Into<String>) -> Self {
        self.flags.push(flag.into());
        self
    }

    /// Adds a flag that the compiler hands to the linker.
    pub fn link(self, argument: &str) -> Self {
        self.flag(format!("-Clink-arg={argument}"))
    }

    /// The same for the linker of the library alone: its dependencies stay compiled when the argument changes.
    pub fn link_alone(mut self, argument: &str) -> Self {
        self.own_flags.push(format!("-Clink-arg={argument}"));
        self
    }

    /// Sets an environment variable.
    pub fn variable(mut self, name: impl Into<String>, value: impl Into<OsString>) -> Self {
        self.environment.push((name.into(), value.into()));
        self
    }

    /// Links with another program. It is no compiler flag, because those are part of the names of symbols.
    pub fn linker(self, triple: &str, linker: impl Into<OsString>) -> Self {
        self.variable(format!("CARGO_TARGET_{}_LINKER", triple.to_uppercase().replace('-', "_")), linker)
    }

    /// Leaves stripping to the linker.
    pub fn stripped_by_linker(mut self) -> Self {
        self.strip = "none";
        self
    }

    /// Runs Cargo and returns the library.
    ///
    /// # Errors
    /// When Cargo fails or its library cannot be read.
    pub fn run(self) -> Result<Vec<u8>> {
        let messages = process::output(&mut self.command())?;
        let artifacts = Message::parse_stream(messages.as_bytes()).filter_map(|message| match message {
            Ok(Message::CompilerArtifact(artifact)) => Some(artifact),
            _ => None,
        });
        let name = self.package.replace('-', "_");
        let files = artifacts.filter(|artifact| artifact.target.name == name);
        let extensions = ["so", "dll", "dylib", "wasm"];
        let is_library = |file: &Utf8PathBuf| extensions.into_iter().any(|it| file.extension() == Some(it));
        let file = files.flat_map(|artifact| artifact.filenames).find(is_library);
        let file = file.context("cargo rustc reported no shared library")?;
        files::read(file)
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        // The crate is a Rust library too; only a build of the shared library alone is optimized at link time.
        command
            .args(["rustc", "--release", "--package", &self.package, "--lib", "--crate-type", "cdylib"])
            .args(["--config".to_owned(), format!("profile.release.strip='{}'", self.strip)])
            .args(["--config".to_owned(), format!("profile.release.panic='{}'", self.panic)])
            .args(self.settings.iter().flat_map(|setting| ["--config", setting]))
            .args(self.features.iter().flat_map(|feature| ["--features", feature.as_str()]))
            .args(["--message-format", "json-render-diagnostics"])
            .args(&self.target)
            .env("CARGO_TARGET_DIR", &self.folder)
            .env("CARGO_ENCODED_RUSTFLAGS", self.encoded_flags())
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .current_dir(&self.workspace.root);
        // The library says by it which source it is built from.
        if let Some(source) = &self.workspace.product.source {
            command.env("FMU_SOURCE_FINGERPRINT", source);
        }
        if self.toolchain.compiles_std {
            let std = format!("build-std=std,panic_{}", self.panic);
            command.args(["-Z", &std, "-Z", "build-std-features="]);
            // As one unit each, which the release profile asks for, they take more than twice the time.
            for package in ["core", "alloc", "std"] {
                command.args(["--config".to_owned(), format!("profile.release.package.{package}.codegen-units=16")]);
            }
        }
        if !self.own_flags.is_empty() {
            command.arg("--").args(&self.own_flags);
        }
        self.toolchain.lead(&mut command);
        command
    }

    /// The flags, and no path of this machine inside the library.
    fn encoded_flags(&self) -> OsString {
        let mut flags: Vec<OsString> = self.flags.iter().map(OsString::from).collect();
        let mut remap = |from: &Path, to: &str| {
            let mut flag = OsString::from("--remap-path-prefix=");
            flag.push(from);
            flag.push("=");
            flag.push(to);
            flags.push(flag);
        };
        // The last that fits wins, and the target directory is usually inside the workspace.
        remap(&self.toolchain.source(), &self.toolchain.source_name);
        if let Some(home) = crate::workspace::cargo_home() {
            remap(&home, "cargo");
        }
        if self.workspace.home != self.workspace.root {
            remap(&self.workspace.home, "pneumatic-servo");
        }
        remap(&self.workspace.root, ".");
        remap(&self.folder, "target");
        flags.join(OsStr::new("\x1f"))
    }
}

fn users_flags() -> Vec<String> {
    let variable = |name| process::variable(name).and_then(|value| value.into_string().ok());
    match variable("CARGO_ENCODED_RUSTFLAGS") {
        Some(encoded) => encoded.split('\x1f').filter(|flag| !flag.is_empty()).map(str::to_owned).collect(),
        None => variable("RUSTFLAGS").unwrap_or_default().split_whitespace().map(str::to_owned).collect(),
    }
}
