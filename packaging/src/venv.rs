//! The Python environments of the packaging: made under the target directory, with pinned packages.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::build::tools::Tool;
use crate::process;
use crate::workspace::Workspace;

/// What an environment is for.
#[derive(Clone, Copy)]
pub enum Requirements {
    /// The checks, the figures and the tests: `packaging/requirements.txt`.
    Checks,
    /// Linking for other machines: `packaging/requirements-zig.txt`.
    Zig,
}

impl Requirements {
    fn file(self) -> &'static str {
        match self {
            Self::Checks => "packaging/requirements.txt",
            Self::Zig => "packaging/requirements-zig.txt",
        }
    }

    fn folder(self) -> &'static str {
        match self {
            Self::Checks => "venv",
            Self::Zig => "venv-zig",
        }
    }
}

/// A virtual environment that holds exactly the packages it was asked for.
pub struct Venv {
    folder: PathBuf,
}

impl Venv {
    /// Makes the environment, or takes the one made before from the same requirements.
    ///
    /// # Errors
    /// When Python or its venv module is missing (the message says what to install), or a package is.
    pub fn prepare(workspace: &Workspace, requirements: Requirements) -> Result<Self> {
        let venv = Self { folder: workspace.environments.join(requirements.folder()) };
        let file = workspace.root.join(requirements.file());
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
        let python = find_python().map_err(|tool| anyhow::anyhow!("missing: {tool}"))?;
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
            .with_context(|| format!("{} is not complete", requirements.display()))
    }

    /// The Python of the environment.
    pub fn python(&self) -> PathBuf {
        self.program("python")
    }

    /// A program of the environment.
    pub fn program(&self, name: &str) -> PathBuf {
        self.programs().join(name).with_extension(std::env::consts::EXE_EXTENSION)
    }

    /// The search path for programs, with those of the environment first.
    ///
    /// # Errors
    /// When the environment lies in a folder that a search path cannot hold.
    pub fn path(&self) -> Result<OsString> {
        let inherited = std::env::var_os("PATH").unwrap_or_default();
        let folders = std::iter::once(self.programs()).chain(std::env::split_paths(&inherited));
        std::env::join_paths(folders).context("the target directory has a name that PATH cannot hold")
    }

    fn programs(&self) -> PathBuf {
        self.folder.join(if cfg!(windows) { "Scripts" } else { "bin" })
    }

    /// A command that runs a script or module in the environment.
    pub fn command(&self) -> Command {
        let mut command = Command::new(self.python());
        // Figures need no display, and nothing of the user's own packages may leak in.
        command.env("MPLBACKEND", "Agg").env("PYTHONNOUSERSITE", "1").env_remove("PYTHONPATH");
        command
    }

    /// The folder of a package in the environment.
    ///
    /// # Errors
    /// When the package is not there.
    pub fn module(&self, name: &str) -> Result<PathBuf> {
        let script = format!("import {name}, pathlib; print(pathlib.Path({name}.__file__).parent)");
        Ok(process::output(self.command().args(["-c", &script]))?.trim().into())
    }

    /// The folder of the libclang that is in the environment.
    ///
    /// # Errors
    /// When the package `libclang` is not there.
    pub fn libclang(&self) -> Result<PathBuf> {
        let folder = self.module("clang")?.join("native");
        if !folder.is_dir() {
            bail!("the Python package libclang has no folder {}", folder.display());
        }
        Ok(folder)
    }
}

/// The Python that a virtual environment needs, if it is missing.
pub fn missing() -> Option<Tool> {
    find_python().err()
}

/// The name of a Python 3 that can make virtual environments.
fn find_python() -> Result<&'static str, Tool> {
    const INSTALL: &str = "on Debian or Ubuntu: apt install python3 python3-venv";
    let works = |program: &str, code: &str| {
        let mut command = Command::new(program);
        command.args(["-c", code]).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    let Some(python) = ["python3", "python"].into_iter().find(|name| works(name, REQUIRED)) else {
        return Err(Tool::new("Python 3.11 or newer", INSTALL));
    };
    if !works(python, "import venv, ensurepip") {
        return Err(Tool::new(format!("the modules venv and ensurepip of {python}"), INSTALL));
    }
    Ok(python)
}

/// Fails on a Python for which the pinned packages do not exist.
const REQUIRED: &str = "import sys; sys.exit(sys.version_info < (3, 11))";
