//! Paths of the repository and its build products.

use std::path::{Path, PathBuf};

use anyhow::Result;
use cargo_metadata::MetadataCommand;

use crate::process;
use crate::product::Product;

/// The variable that names a folder with Python environments to share; otherwise they are made in the target directory.
pub const ENVIRONMENTS: &str = "FMU_ENVIRONMENTS";

/// The folders that the commands work in.
#[derive(Clone)]
pub struct Workspace {
    /// The root of the workspace that the library is built from.
    pub root: PathBuf,
    /// The root of the project's repository, where the Python tools and the parts of its FMUs are.
    pub home: PathBuf,
    /// Cargo's target directory.
    pub target: PathBuf,
    /// Where Python environments are made.
    pub environments: PathBuf,
    /// Product to pack.
    pub product: Product,
}

impl Workspace {
    /// The workspace of the project, from Cargo.
    ///
    /// # Errors
    /// When Cargo does not answer.
    pub fn of_the_project() -> Result<Self> {
        Self::around(&home().join("packaging"), Product::of_the_project(&home()))
    }

    /// The workspace of a package, from Cargo.
    ///
    /// # Errors
    /// When Cargo does not answer.
    pub fn around(package: &Path, product: Product) -> Result<Self> {
        let metadata = process::metadata(MetadataCommand::new().manifest_path(package.join("Cargo.toml")).no_deps())?;
        let target = metadata.target_directory.into_std_path_buf();
        let environments = process::variable(ENVIRONMENTS).map_or_else(|| target.clone(), PathBuf::from);
        Ok(Self { root: metadata.workspace_root.into(), home: home(), environments, target, product })
    }

    /// The project's workspace, with target directory and environments in a folder of a test.
    #[cfg(test)]
    pub fn of_a_test(target: &Path) -> Self {
        let (target, environments) = (target.to_owned(), target.join("environments"));
        let product = Product::of_the_project(&home());
        Self { root: home(), home: home(), target, environments, product }
    }

    /// The same source with a target directory of its own below this one's, so that two builds can run at a time.
    pub fn inside(&self, folder: &str) -> Self {
        Self { target: self.target.join(folder), ..self.clone() }
    }

    /// Where the FMUs go, with the results of their default experiments.
    pub fn fmus(&self) -> PathBuf {
        self.target.join("fmu")
    }

    /// Where generated descriptions and hand-written parts of the project's FMUs are kept.
    pub fn descriptions(&self) -> PathBuf {
        self.home.join("modelDescription")
    }

    /// Where the Python tools of the packaging are.
    pub fn python(&self) -> PathBuf {
        self.home.join("packaging/python")
    }

    /// Paths of this machine that nobody should find in a library, each with its last slash.
    pub fn private_paths(&self) -> Vec<String> {
        let home = std::env::home_dir();
        let folders = [Some(self.root.clone()), Some(self.target.clone()), Some(self.home.clone()), cargo_home(), home];
        let folders = folders.into_iter().flatten().filter(|folder| folder.parent().is_some());
        folders.map(|folder| format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR)).collect()
    }
}

/// The root of the project's repository.
pub fn home() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_path_buf)
}

/// Where Cargo keeps the sources of libraries.
pub fn cargo_home() -> Option<PathBuf> {
    let home = || std::env::home_dir().map(|home| home.join(".cargo"));
    process::variable("CARGO_HOME").map(PathBuf::from).or_else(home)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variables for other programs are named in their documentation.
    #[test]
    fn folders_of_the_project_hold_what_they_are_named_for() {
        let workspace = Workspace::of_a_test(Path::new("/target"));
        assert!(workspace.descriptions().join("experiments.json").is_file());
        assert!(workspace.python().join("check.py").is_file());
        assert_eq!(workspace.fmus(), Path::new("/target/fmu"));
        assert_eq!(workspace.inside("a").target, Path::new("/target/a"));
        assert_eq!(workspace.inside("a").environments, workspace.environments);
    }

    /// With a slash behind them: a folder whose name only begins alike is another.
    #[test]
    fn private_are_the_places_of_the_project_of_cargo_and_of_the_user() -> Result<()> {
        let workspace = Workspace::of_the_project()?;
        let (root, target) = (workspace.root.clone(), workspace.target.clone());
        let cargo = std::env::var_os("CARGO_HOME")
            .map_or(std::env::home_dir().unwrap_or_default().join(".cargo"), PathBuf::from);
        assert!(cargo.is_dir() && cargo_home() == Some(cargo.clone()), "{}", cargo.display());
        let paths = workspace.private_paths();
        for folder in [root, target, cargo, home()] {
            let path = format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR);
            assert!(paths.contains(&path), "{path} is not among {paths:?}");
        }
        Ok(())
    }
}
