//! `cargo xtask playground`: one page with the plant in it, `target/playground/index.html`, and its tests in a browser.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use pneumatic_servo_packaging::build::wasm;
use pneumatic_servo_packaging::licences;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::tools::{self, Tool};
use pneumatic_servo_packaging::venv::Venv;
use pneumatic_servo_packaging::workspace::Workspace;

use crate::quick;

/// The help of the command.
pub const HELP: &str = "\
Build the page in which the plant runs: target/playground/index.html.

Usage: cargo xtask playground";

/// Builds the page.
///
/// # Errors
/// When a tool is missing or fails.
pub fn run(workspace: &Workspace) -> Result<()> {
    println!("{}", page(workspace)?.display());
    Ok(())
}

/// Builds the page and says where it is.
///
/// # Errors
/// When a tool is missing or fails.
pub fn page(workspace: &Workspace) -> Result<PathBuf> {
    tools::require([("the playground", needed()?)])?;
    build(workspace)
}

/// Builds the page and says where it is; where a tool is missing, that is an error under CI and otherwise said.
///
/// # Errors
/// When a tool is missing under CI, or fails.
pub fn page_if_possible(workspace: &Workspace) -> Result<Option<PathBuf>> {
    if let Err(problem) = tools::require([("the playground", needed()?)]) {
        process::leave_out("Playground", &problem.to_string())?;
        return Ok(None);
    }
    heading("Build the playground");
    build(workspace).map(Some)
}

/// Uses the page in Chromium as a visitor does, its Python programs in an environment that has the package; where a tool is missing,
/// that is an error under CI and otherwise said.
///
/// # Errors
/// When a tool is missing under CI, or a test fails.
pub fn check(workspace: &Workspace, venv: &Venv, page: &Path) -> Result<()> {
    heading("Playground: types of its sources");
    process::run(npm().args(["run", "--silent", "check"]).current_dir(sources(workspace)))?;
    if let Err(problem) =
        tools::require([("the playground", Tool::unless_found("chromium", "chromium").into_iter().collect())])
    {
        return process::leave_out("Playground in a browser", &problem.to_string());
    }
    heading("Playground: use the page in Chromium");
    process::run(&mut replay(workspace))?;
    let tests = workspace.root.join("tests/playground");
    install(&tests)?;
    let mut test = npm();
    test.args(["test", "--silent"]).current_dir(&tests);
    test.env("PLAYGROUND", page).env("REPLAY", workspace.target.join("quick/examples/replay"));
    test.env("FMU_FOLDER", workspace.fmus());
    process::run(test.env("PYTHON", venv.program("python")))
}

/// Missing tools for the page.
///
/// # Errors
/// When the Rust compiler in use does not answer.
pub fn needed() -> Result<Vec<Tool>> {
    Ok(wasm::missing()?.into_iter().chain(Tool::unless_found("npm", "nodejs npm")).collect())
}

fn build(workspace: &Workspace) -> Result<PathBuf> {
    let sources = sources(workspace);
    let folder = workspace.target.join("playground");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let plant = keep(&folder.join("plant.wasm"), &wasm::build(workspace)?)?;
    let licences = licences::of_package(workspace, wasm::PACKAGE)?;
    let licences = keep(&folder.join("licences.txt"), licences.as_bytes())?;
    let page = folder.join("index.html");
    install(&sources)?;
    let mut bundle = npm();
    bundle.args(["run", "--silent", "bundle", "--"]).args([&plant, &licences, &page]);
    process::run(bundle.current_dir(&sources))?;
    Ok(page)
}

fn sources(workspace: &Workspace) -> PathBuf {
    workspace.root.join("web/playground")
}

/// The package manager that JavaScript comes with.
pub fn npm() -> Command {
    Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" })
}

/// The build of the program that repeats runs of the page with the library; its bits do not depend on optimization. Packages and
/// features are the same as for the unit tests.
fn replay(workspace: &Workspace) -> Command {
    let mut cargo = process::cargo();
    cargo.args(["build", "--profile", "quick", "--example", "replay", "--no-default-features"]).args(quick::FEATURES);
    cargo.args(quick::packages()).current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target);
    cargo
}

/// Installs the packages of a folder's lock file, unless they are installed.
///
/// # Errors
/// When npm fails.
pub fn install(folder: &Path) -> Result<()> {
    let changed = |file: &str| fs::metadata(folder.join(file)).and_then(|file| file.modified()).ok();
    let installed = changed("node_modules/.package-lock.json");
    if installed.is_some() && installed >= changed("package-lock.json") {
        return Ok(());
    }
    process::run(npm().args(["ci", "--no-audit", "--no-fund", "--loglevel=error"]).current_dir(folder))
}

fn keep(file: &Path, bytes: &[u8]) -> Result<PathBuf> {
    fs::write(file, bytes).with_context(|| format!("cannot write {}", file.display()))?;
    Ok(file.to_owned())
}
