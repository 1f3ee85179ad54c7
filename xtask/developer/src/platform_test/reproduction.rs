//! The same source gives the same bytes: a second build, in a copy of the checkout and with a target directory of its own.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use pneumatic_servo_packaging::description::Version;
use pneumatic_servo_packaging::library::Library;
use pneumatic_servo_packaging::package;
use pneumatic_servo_packaging::platform::Platform;
use pneumatic_servo_packaging::process;
use pneumatic_servo_packaging::product::Product;
use pneumatic_servo_packaging::workspace::Workspace;

/// A copy of the checkout and the library for linux64 that was built in it.
pub struct Reproduction {
    elsewhere: Workspace,
    library: Library,
}

impl Reproduction {
    /// Builds the library for linux64 in a copy.
    ///
    /// # Errors
    /// When the copy cannot be made or built.
    pub fn build(workspace: &Workspace) -> Result<Self> {
        let root = workspace.target.join("platform-test/a copy of the checkout");
        copy(&workspace.root, &root)?;
        let environments = workspace.environments.clone();
        let product = Product::of_the_project(&root);
        let (target, home) = (root.join("elsewhere"), root.clone());
        let elsewhere = Workspace { target, home, root, environments, product };
        let library = Library::for_everybody(&elsewhere, Platform::Linux64)?;
        Ok(Self { elsewhere, library })
    }

    /// Compares with the build in the checkout and with the FMUs that [`package::join`] has made of it.
    ///
    /// # Errors
    /// When a byte differs.
    pub fn compare(&self, workspace: &Workspace, first: &[Library]) -> Result<()> {
        let platform = self.library.platform;
        let twin = first.iter().find(|library| library.platform == platform).context("nothing to compare with")?;
        ensure!(self.library.bytes == twin.bytes, "the library for {platform} depends on where it is built");
        println!("the library for {platform} has the same bytes");
        package::join(&self.elsewhere, first)?;
        for folder in Version::ALL.map(Version::folder) {
            compare_files(&self.elsewhere.fmus().join(folder), &workspace.fmus().join(folder))?;
        }
        println!("the FMUs and the SSP file have the same bytes");
        Ok(())
    }
}

/// Compares the files of a folder with the files of the same names in another.
fn compare_files(folder: &Path, other: &Path) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))? {
        let file = entry?.path();
        if let Some(name) = file.file_name().filter(|_| file.is_file()) {
            let same = std::fs::read(&file)? == std::fs::read(other.join(name))?;
            ensure!(same, "{} depends on where it is built", file.display());
        }
    }
    Ok(())
}

/// Copies the files of a checkout that git tracks or would track, with its history, whose last date is in the FMU.
fn copy(from: &Path, to: &Path) -> Result<()> {
    if to.exists() {
        std::fs::remove_dir_all(to).with_context(|| format!("cannot remove {}", to.display()))?;
    }
    process::run(Command::new("git").args(["clone", "--quiet", "--no-checkout", "--no-hardlinks"]).arg(from).arg(to))?;
    for file in files(from)? {
        let (source, copy) = (from.join(&file), to.join(&file));
        if let Some(folder) = copy.parent() {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        }
        std::fs::copy(&source, &copy).with_context(|| format!("cannot copy {}", source.display()))?;
    }
    Ok(())
}

fn files(root: &Path) -> Result<BTreeSet<PathBuf>> {
    let mut git = Command::new("git");
    git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]).current_dir(root);
    let files = process::output(&mut git)?;
    let files = files.split('\0').filter(|file| !file.is_empty()).map(PathBuf::from);
    Ok(files.filter(|file| root.join(file).is_file()).collect())
}
