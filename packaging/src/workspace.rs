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
    /// Where Python environments are made.
    pub environments: PathBuf,
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
        let target = folder("target_directory")?;
        Ok(Self { root: folder("workspace_root")?, environments: target.clone(), target })
    }

    /// The same source with a target directory of its own below this one's, so that two builds can run at a time.
    pub fn inside(&self, folder: &str) -> Self {
        Self { root: self.root.clone(), target: self.target.join(folder), environments: self.environments.clone() }
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

    /// Paths of this machine that nobody should find in a library, each with its last slash.
    pub fn private_paths(&self) -> Vec<String> {
        let home = std::env::home_dir();
        let folders = [Some(self.root.clone()), Some(self.target.clone()), cargo_home(), home];
        let folders = folders.into_iter().flatten().filter(|folder| folder.parent().is_some());
        folders.map(|folder| format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR)).collect()
    }
}

/// Where Cargo keeps the sources of libraries.
pub fn cargo_home() -> Option<PathBuf> {
    let home = || std::env::home_dir().map(|home| home.join(".cargo"));
    std::env::var_os("CARGO_HOME").map(PathBuf::from).or_else(home)
}
