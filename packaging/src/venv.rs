//! The Python environment of the packaging: made under the target directory, with pinned packages.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::process;
use crate::workspace::Workspace;

/// A virtual environment that holds exactly the packages of `packaging/requirements.txt`.
pub struct Venv {
    folder: PathBuf,
}

impl Venv {
    /// Makes the environment, or takes the one made before from the same requirements.
    ///
    /// # Errors
    /// When Python or its venv module is missing (the message says what to install), or a package is.
    pub fn prepare(workspace: &Workspace) -> Result<Self> {
        let venv = Self { folder: workspace.target.join("venv") };
        let file = workspace.root.join("packaging/requirements.txt");
        let requirements = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
        let stamp = venv.folder.join("requirements.txt");
        if std::fs::read_to_string(&stamp).is_ok_and(|made_from| made_from == requirements) && venv.python().exists() {
            return Ok(venv);
        }
        venv.make(&file)?;
        std::fs::write(&stamp, requirements).with_context(|| format!("cannot write {}", stamp.display()))?;
        Ok(venv)
    }

    fn make(&self, requirements: &Path) -> Result<()> {
        println!("making {} (once per set of packages)", self.folder.display());
        let python = find_python()?;
        if self.folder.exists() {
            let problem = || format!("cannot remove the old {}", self.folder.display());
            std::fs::remove_dir_all(&self.folder).with_context(problem)?;
        }
        process::run(Command::new(python).args(["-m", "venv"]).arg(&self.folder))?;
        process::run(
            Command::new(self.python())
                .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--requirement"])
                .arg(requirements),
        )?;
        process::run(Command::new(self.python()).args(["-m", "pip", "check", "--disable-pip-version-check"]))
            .context("packaging/requirements.txt is not complete")
    }

    /// The Python of the environment.
    pub fn python(&self) -> PathBuf {
        self.folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
    }

    /// A command that runs a script or module in the environment.
    pub fn command(&self) -> Command {
        let mut command = Command::new(self.python());
        // Figures need no display, and nothing of the user's own packages may leak in.
        command.env("MPLBACKEND", "Agg").env("PYTHONNOUSERSITE", "1").env_remove("PYTHONPATH");
        command
    }

    /// The folder of the libclang that is in the environment.
    ///
    /// # Errors
    /// When the package `libclang` is not there.
    pub fn libclang(&self) -> Result<PathBuf> {
        let script = "import clang, pathlib; print(pathlib.Path(clang.__file__).parent / 'native')";
        let folder = PathBuf::from(process::output(self.command().args(["-c", script]))?.trim());
        if !folder.is_dir() {
            bail!("the Python package libclang has no folder {}", folder.display());
        }
        Ok(folder)
    }
}

/// The name of a Python 3 that can make virtual environments.
fn find_python() -> Result<&'static str> {
    const INSTALL: &str = "on Debian or Ubuntu: apt install python3 python3-venv";
    let works = |program: &str, code: &str| {
        let mut command = Command::new(program);
        command.args(["-c", code]).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    let Some(python) = ["python3", "python"].into_iter().find(|name| works(name, REQUIRED)) else {
        bail!("no Python 3.11 or newer was found, which the checks and figures need; install it ({INSTALL})");
    };
    if !works(python, "import venv, ensurepip") {
        bail!(
            "{python} cannot make virtual environments: its modules venv and ensurepip are missing; install them ({INSTALL})"
        );
    }
    Ok(python)
}

/// Fails on a Python for which the pinned packages do not exist.
const REQUIRED: &str = "import sys; sys.exit(sys.version_info < (3, 11))";
