//! The Python environments of the packaging: made under the target directory by `venv` and `pip`, with pinned packages.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, anyhow};

use crate::files;
use crate::process;
use crate::tools::Tool;
use crate::workspace::Workspace;

/// Purpose of an environment: the folder it is made in, and the lists of its packages in `packaging`.
///
/// Environments in one folder share it: each list is installed once.
#[derive(Clone, Copy)]
pub struct Requirements(&'static str, &'static [&'static str]);

impl Requirements {
    /// Validating and running FMUs.
    pub const PACKAGE: Self = Self("venv", &["requirements.txt"]);
    /// The tests too.
    pub const TESTS: Self = Self("venv", &["requirements.txt", "requirements-figures.txt", "requirements-tests.txt"]);
    /// The site too.
    pub const SITE: Self = Self(
        "venv",
        &["requirements.txt", "requirements-figures.txt", "requirements-tests.txt", "requirements-site.txt"],
    );
    /// Fuzzing what the Python package reads.
    pub const FUZZ: Self = Self("venv", &["requirements.txt", "requirements-figures.txt", "requirements-fuzz.txt"]);
    /// Linking for other machines.
    pub const ZIG: Self = Self("venv-zig", &["requirements-zig.txt"]);
}

/// A virtual environment.
pub struct Venv {
    folder: PathBuf,
    /// Folder of the caches of Matplotlib, ruff and mypy.
    cache: PathBuf,
}

impl Venv {
    /// Makes the environment, or takes the one made before from the same requirements.
    ///
    /// # Errors
    /// When Python or its venv module is missing (the message says what to install), or a package is.
    pub fn prepare(workspace: &Workspace, Requirements(folder, lists): Requirements) -> Result<Self> {
        let cache = workspace.environments.join("cache");
        let venv = Self { folder: workspace.environments.join(folder), cache };
        for list in lists {
            venv.install(&workspace.home.join("packaging").join(list))?;
        }
        Ok(venv)
    }

    /// Installs the packages of a list, unless that is what was installed last.
    fn install(&self, list: &Path) -> Result<()> {
        let wanted = files::text(list)?;
        // The list of the last installation is kept beside the packages.
        let stamp = self.folder.join(list.file_name().context("requirements without a name")?);
        if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
            return Ok(());
        }
        println!("installing the packages of {} into {}", list.display(), self.folder.display());
        // The last thing that is made of an environment is its pip.
        if !self.program("pip").exists() {
            let python = find_python().map_err(|tool| anyhow!("missing: {tool}"))?;
            process::run(Command::new(python).args(["-m", "venv", "--clear"]).arg(&self.folder))?;
        }
        let mut pip = self.command();
        pip.args([
            "-m",
            "pip",
            "install",
            "--disable-pip-version-check",
            "--no-compile",
            "--no-deps",
            "--progress-bar=off",
        ]);
        process::run(pip.env("PIP_CACHE_DIR", self.cache.join("pip")).arg("--requirement").arg(list))?;
        files::write(&stamp, wanted)
    }

    /// A program of the environment.
    pub fn program(&self, name: &str) -> PathBuf {
        self.programs().join(name).with_extension(std::env::consts::EXE_EXTENSION)
    }

    /// The search path for programs, with the environment's first.
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
        let mut command = Command::new(self.program("python"));
        // Figures need no display, and nothing of the user's own packages may leak in.
        command.env("MPLBACKEND", "Agg").env("PYTHONNOUSERSITE", "1").env_remove("PYTHONPATH");
        command.env("MPLCONFIGDIR", self.cache.join("matplotlib")).env("PYTHONUNBUFFERED", "1");
        command.env("RUFF_CACHE_DIR", self.cache.join("ruff")).env("MYPY_CACHE_DIR", self.cache.join("mypy"));
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
}

/// The Python that a virtual environment needs, if it is missing.
pub fn missing() -> Option<Tool> {
    find_python().err()
}

/// A Python for which the pinned packages exist and that can make virtual environments.
fn find_python() -> Result<&'static str, Tool> {
    const CHECK: &str = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))";
    let works = |program: &&str| process::works(Command::new(program).args(["-c", CHECK]));
    let tool = || {
        let install = "on Debian or Ubuntu: apt install python3 python3-venv";
        Tool::new("Python 3.11 or newer with its modules venv and ensurepip", install)
    };
    ["python3", "python"].into_iter().find(works).ok_or_else(tool)
}
