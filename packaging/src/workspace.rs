//! Where the repository and its build products are.

use std::path::{Path, PathBuf};

use anyhow::Result;
use cargo_metadata::MetadataCommand;

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
        let metadata = MetadataCommand::new().manifest_path(manifest).no_deps().exec()?;
        let target = metadata.target_directory.into_std_path_buf();
        Ok(Self { root: metadata.workspace_root.into(), environments: target.clone(), target })
    }

    /// The same source with a target directory of its own below this one's, so that two builds can run at a time.
    pub fn inside(&self, folder: &str) -> Self {
        Self { root: self.root.clone(), target: self.target.join(folder), environments: self.environments.clone() }
    }

    /// Where the FMUs go, with the results of their default experiments.
    pub fn fmus(&self) -> PathBuf {
        self.target.join("fmu")
    }

    /// Where the results of all laws, the catalogue and the comparison go.
    pub fn gallery(&self) -> PathBuf {
        self.target.join("gallery")
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
