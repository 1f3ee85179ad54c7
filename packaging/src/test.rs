//! `cargo xtask test`: every check, in the order in which mistakes are cheapest to find.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::package;
use crate::platform_test;
use crate::process::{self, heading};
use crate::valgrind;
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Runs everything; the first failure ends it.
///
/// # Errors
/// When a tool is missing or a check fails.
pub fn run(workspace: &Workspace) -> Result<()> {
    heading("Prepare the Python environment");
    let venv = Venv::prepare(workspace, Requirements::Checks)?;
    let checks = Checks { workspace, bindgen: bindgen(&venv)? };

    heading("Format");
    checks.cargo(&["fmt", "--all", "--check"])?;

    heading("Lints");
    checks.cargo(&["clippy", "--workspace", "--exclude", "benchmark", "--all-targets", "--", "--deny", "warnings"])?;
    // The benchmark's rival takes longer to compile than everything else together; `cargo bench` compiles it.
    let benchmark = ["--package", "benchmark", "--no-default-features", "--all-targets"];
    checks.cargo(&[&["clippy"], &benchmark[..], &["--", "--deny", "warnings"]].concat())?;

    heading("Documentation");
    checks.documentation()?;

    heading("Library: unit tests, published numbers, C interface");
    checks.cargo(&["test"])?;

    if valgrind::is_available() {
        heading("C interface under valgrind");
        valgrind::check_memory(workspace)?;
        heading("Instructions of a communication step");
        valgrind::check_instructions(workspace)?;
    } else {
        heading("Not run: memory checks and instruction counts, which need valgrind");
    }

    heading("Packaging: unit tests");
    checks.cargo(&["test", "--package", "packaging"])?;

    package::run(workspace, None, &[])?;

    heading("Import with the crate fmi");
    checks.cargo(&["test", "--package", "importer"])?;

    heading("Import with FMPy");
    checks.pytest(&venv)?;

    platform_test::run_if_possible(workspace)
}

/// Runs checks in the repository.
struct Checks<'a> {
    workspace: &'a Workspace,
    bindgen: Vec<(&'static str, OsString)>,
}

impl Checks<'_> {
    fn cargo(&self, arguments: &[&str]) -> Result<()> {
        process::run(self.prepared(process::cargo().args(arguments)))
    }

    fn documentation(&self) -> Result<()> {
        let mut cargo = process::cargo();
        cargo
            .args(["doc", "--workspace", "--exclude", "benchmark", "--no-deps"])
            .env("RUSTDOCFLAGS", "--deny warnings");
        process::run(self.prepared(&mut cargo))
    }

    fn pytest(&self, venv: &Venv) -> Result<()> {
        let tests = self.workspace.root.join("tests/python");
        process::run(self.prepared(venv.command().args(["-m", "pytest"]).arg(tests)))
    }

    /// Lets a command find the repository, the FMUs and libclang.
    fn prepared<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command
            .current_dir(&self.workspace.root)
            .env("CARGO_TARGET_DIR", &self.workspace.target)
            .env("FMU_FOLDER", self.workspace.fmus())
            .envs(self.bindgen.iter().map(|(name, value)| (name, value)))
    }
}

/// What the crate `fmi` needs in order to read the C headers of FMI: libclang, and the compiler's own headers.
fn bindgen(venv: &Venv) -> Result<Vec<(&'static str, OsString)>> {
    let mut variables = vec![("LIBCLANG_PATH", venv.libclang()?.into_os_string())];
    if cfg!(target_os = "linux") {
        let mut include = OsString::from("-I");
        include.push(compiler_headers()?);
        variables.push(("BINDGEN_EXTRA_CLANG_ARGS", include));
    }
    Ok(variables)
}

fn compiler_headers() -> Result<OsString> {
    let mut gcc = Command::new("gcc");
    let answer = gcc.arg("-print-file-name=include").stderr(Stdio::inherit()).output();
    let answer = answer.context("gcc was not found; install it (on Debian or Ubuntu: apt install gcc libc6-dev)")?;
    let folder = String::from_utf8(answer.stdout).context("gcc named no folder")?;
    let folder = Path::new(folder.trim());
    if !folder.is_absolute() {
        bail!("gcc has no folder of headers; install it (on Debian or Ubuntu: apt install gcc libc6-dev)");
    }
    Ok(folder.into())
}
