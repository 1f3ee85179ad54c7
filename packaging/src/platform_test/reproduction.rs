//! The same source gives the same bytes: a second build, in a copy of the checkout and with a target directory of its own.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::description::Version;
use crate::library::Library;
use crate::package;
use crate::platform::Platform;
use crate::process;
use crate::product::Product;
use crate::workspace::Workspace;

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
        let elsewhere = Workspace { target: root.join("elsewhere"), home: root.clone(), root, environments, product };
        let library = Library::for_everybody(&elsewhere, Platform::Linux64)?;
        Ok(Self { elsewhere, library })
    }

    /// Compares with what was built in the checkout and with the FMUs that [`package::join`] has made of that.
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

/// Compares the files of a folder with those of the same names in another.
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

/// Copies what git knows or would know of a checkout, with its history, whose last date is in the FMU.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::{scratch, write};
    use crate::stand_in::{Answer, StandIn};

    /// What git knows of, in place of an older copy; a file that git knows of and that is gone is none.
    #[test]
    fn a_checkout_is_copied_with_its_history() -> Result<()> {
        let folder = scratch("reproduction");
        let (from, to) = (folder.join("from"), folder.join("to"));
        for name in ["a.txt", "deep/b.txt", "unknown.txt"] {
            write(&from.join(name), name)?;
        }
        write(&to.join("old.txt"), "")?;
        let machine = StandIn::new(|command| {
            command.says("ls-files").then(|| Answer::Prints("a.txt\0deep/b.txt\0gone.txt\0".to_owned()))
        });
        let (outcome, started) = machine.does(|| copy(&from, &to));
        outcome?;
        assert!(
            started[0].line().starts_with("git clone ") && started[0].says(&to.display().to_string()),
            "{started:?}"
        );
        assert_eq!(std::fs::read_to_string(to.join("deep/b.txt"))?, "deep/b.txt");
        assert!(to.join("a.txt").is_file() && !to.join("unknown.txt").exists() && !to.join("old.txt").exists());
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn a_file_with_another_byte_is_named() -> Result<()> {
        let folder = scratch("reproduction-compare");
        let (one, other) = (folder.join("one"), folder.join("other"));
        for (of, name, text) in
            [(&one, "a.fmu", "a"), (&other, "a.fmu", "a"), (&other, "more.csv", ""), (&one, "fmi3/b", "")]
        {
            write(&of.join(name), text)?;
        }
        compare_files(&one, &other)?;
        write(&one.join("a.fmu"), "b")?;
        assert!(compare_files(&one, &other).is_err_and(|error| error.to_string().contains("a.fmu depends on where")));
        assert!(compare_files(&folder.join("none"), &other).is_err());
        Ok(std::fs::remove_dir_all(&folder)?)
    }
}
