//! Where the repository and its build products are.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::process;

/// The folders that the commands work in.
pub struct Workspace {
    /// The root of the repository.
    pub root: PathBuf,
    /// Cargo's target directory, wherever the user put it.
    pub target: PathBuf,
}

impl Workspace {
    /// Asks Cargo.
    pub fn find() -> Result<Self> {
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let answer = process::output(
            process::cargo().args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path"]).arg(manifest),
        )?;
        let metadata: serde_json::Value = serde_json::from_str(&answer).context("cargo metadata gave no JSON")?;
        let folder = |key: &str| {
            metadata[key].as_str().map(PathBuf::from).with_context(|| format!("cargo metadata has no {key}"))
        };
        Ok(Self { root: folder("workspace_root")?, target: folder("target_directory")? })
    }

    /// Where the FMUs, results and figures go.
    pub fn fmus(&self) -> PathBuf {
        self.target.join("fmu")
    }

    /// Where generated descriptions and hand-written parts of the FMU are kept.
    pub fn descriptions(&self) -> PathBuf {
        self.root.join("modelDescription")
    }

    /// Where the Python tools of the packaging are.
    pub fn python(&self) -> PathBuf {
        self.root.join("packaging/python")
    }
}
