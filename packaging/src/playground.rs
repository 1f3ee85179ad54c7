//! `cargo xtask playground`: one page with the plant in it, `target/playground/index.html`, and its tests in a browser.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use clap::Args;

use crate::build::wasm;
use crate::licences;
use crate::process::{self, heading};
use crate::tools::{self, Tool};
use crate::venv::Venv;
use crate::workspace::Workspace;

/// Build the page in which the plant runs: target/playground/index.html.
#[derive(Args)]
pub struct Playground {}

impl Playground {
    /// Builds the page.
    ///
    /// # Errors
    /// When a tool is missing or fails.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        println!("{}", page(workspace)?.display());
        Ok(())
    }
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

/// Builds the page and uses it in Chromium as a visitor does, its Python programs in an environment that has the package;
/// where a tool is missing, that is an error under CI and otherwise said.
///
/// # Errors
/// When a tool is missing under CI, or a test fails.
pub fn check(workspace: &Workspace, venv: &Venv) -> Result<()> {
    let mut missing = needed()?;
    missing.extend(Tool::unless_found("chromium", "chromium"));
    if let Err(problem) = tools::require([("the playground", missing)]) {
        return process::leave_out("Playground", &problem.to_string());
    }
    heading("Playground: build the page");
    let sources = sources(workspace);
    install(&sources)?;
    process::run(npm().args(["run", "--silent", "check"]).current_dir(&sources))?;
    let page = build(workspace)?;

    heading("Playground: use the page in Chromium");
    process::run(&mut replay(workspace))?;
    let tests = workspace.root.join("tests/playground");
    install(&tests)?;
    let mut test = npm();
    test.args(["test", "--silent"]).current_dir(&tests);
    test.env("PLAYGROUND", page).env("REPLAY", workspace.target.join("quick/examples/replay"));
    process::run(test.env("PYTHON", venv.program("python")))
}

/// What this machine lacks for the page.
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
    workspace.root.join("playground")
}

/// The package manager that JavaScript comes with.
pub fn npm() -> Command {
    Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" })
}

/// What builds the program that repeats runs of the page with the library; its bits are the same without optimization.
fn replay(workspace: &Workspace) -> Command {
    let mut cargo = process::cargo();
    cargo.args(["build", "--profile", "quick", "--package", wasm::PACKAGE, "--example", "replay"]);
    cargo.args(process::FEATURES_OF_THIS).current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target);
    cargo
}

/// Installs what the lock file of a folder states, unless that is done.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files;
    use crate::stand_in::{self, Answer, StandIn, Started};
    use crate::venv::Requirements;

    /// A workspace of a test, and a machine that builds the module and whose packages are installed by the lock file.
    fn workshop(folder: &Path) -> Result<(Workspace, StandIn)> {
        let workspace = Workspace::made_up(folder);
        let (root, module) = (workspace.root.clone(), folder.join("module.wasm"));
        files::write(&module, "module")?;
        let machine = StandIn::new(move |command| match command {
            _ if command.says("metadata") => {
                Some(stand_in::metadata(&root, &root, &[(wasm::PACKAGE, "0.1.0", "playground")]))
            }
            _ if command.says("rustc --release") => Some(stand_in::built(command, &module)),
            _ => None,
        });
        Ok((workspace, machine.compiling_for(&folder.join("sysroot"), &["wasm32-unknown-unknown"])))
    }

    fn of_npm(started: &[Started]) -> Vec<&str> {
        let npm = started.iter().filter(|it| it.path == Path::new(npm().get_program()));
        npm.map(|it| it.arguments.iter().find(|it| *it != "run" && !it.starts_with('-')).map_or("", |it| it)).collect()
    }

    /// Of the module and its licences.
    #[test]
    fn page_is_bundled_of_the_module() -> Result<()> {
        let folder = files::scratch("playground");
        let (workspace, machine) = workshop(&folder)?;
        let (made, started) = machine.does(|| page(&workspace));
        let (place, page) = (workspace.target.join("playground"), made?);
        assert_eq!(page, place.join("index.html"));
        assert_eq!(files::text(place.join("plant.wasm"))?, "module");
        assert!(files::text(place.join("licences.txt"))?.contains(wasm::PACKAGE));
        assert_eq!(of_npm(&started), ["ci", "bundle"]);
        let bundle = started.last().context("no bundle")?;
        let files = ["plant.wasm", "licences.txt", "index.html"].map(|name| place.join(name).display().to_string());
        assert!(bundle.line().ends_with(&files.join(" ")) && bundle.folder == Some(workspace.root.join("playground")));
        let (outcome, started) = workshop(&folder)?.1.lacking("wasm-ld").does(|| super::page(&workspace));
        assert!(outcome.is_err_and(|error| error.to_string().contains("for the playground: ")) && started.is_empty());
        assert!(workshop(&folder)?.1.lacking("npm").does(|| Playground {}.run(&workspace)).0.is_err());
        for is_ci in [false, true] {
            let machine = workshop(&folder)?.1.lacking("npm").with("CI", is_ci.to_string());
            let (outcome, started) = machine.does(|| page_if_possible(&workspace));
            assert!(outcome.map_or(is_ci, |page| page.is_none() && !is_ci) && started.is_empty(), "{started:?}");
        }
        assert_eq!(workshop(&folder)?.1.does(|| page_if_possible(&workspace)).0?, Some(page));
        Ok(fs::remove_dir_all(&folder)?)
    }

    /// The sources of the page are checked, the page is built, and a browser runs it beside the library.
    #[test]
    fn page_is_used_where_there_is_a_browser() -> Result<()> {
        let folder = files::scratch("playground-check");
        let (workspace, machine) = workshop(&folder)?;
        let use_it = || check(&workspace, &Venv::prepare(&workspace, Requirements::TESTS)?);
        let (outcome, started) = machine.does(use_it);
        outcome?;
        assert_eq!(of_npm(&started), ["ci", "check", "ci", "bundle", "ci", "test"]);
        let test = started.last().context("no test")?;
        assert_eq!(test.folder, Some(workspace.root.join("tests/playground")));
        assert_eq!(Path::new(test.variable("PLAYGROUND")), workspace.target.join("playground/index.html"));
        assert_eq!(Path::new(test.variable("REPLAY")), workspace.target.join("quick/examples/replay"));
        let replay = started.iter().find(|it| it.says("--example replay")).context("no replay")?;
        assert!(
            replay.says("build --profile quick") && replay.says(&format!("--package {}", wasm::PACKAGE)),
            "{replay:?}"
        );
        let (outcome, started) = workshop(&folder)?.1.lacking("chromium").does(use_it);
        assert!(outcome.is_ok() && of_npm(&started).is_empty());
        let failing = StandIn::new(|command| command.says("check").then_some(Answer::Fails));
        let failing = failing.compiling_for(&folder.join("sysroot"), &["wasm32-unknown-unknown"]);
        assert!(failing.does(use_it).0.is_err());
        Ok(fs::remove_dir_all(&folder)?)
    }

    /// Unless what is installed is as new as the lock file.
    #[test]
    fn packages_are_installed_when_the_lock_file_is_newer() -> Result<()> {
        let folder = files::scratch("playground-npm");
        let installs = || StandIn::new(|_| None).does(|| install(&folder)).1.len();
        let (lock, installed) = (folder.join("package-lock.json"), folder.join("node_modules/.package-lock.json"));
        files::write(&lock, "")?;
        assert_eq!(installs(), 1);
        files::write(&installed, "")?;
        let times = [&lock, &installed].map(|file| fs::File::options().write(true).open(file));
        let [lock, installed] = times;
        let (lock, installed, moment) = (lock?, installed?, std::time::SystemTime::UNIX_EPOCH);
        let minute = std::time::Duration::from_secs(60);
        for (of_lock, of_installed, expected) in [(0, 0, 0), (0, 1, 0), (1, 0, 1)] {
            lock.set_modified(moment + of_lock * minute)?;
            installed.set_modified(moment + of_installed * minute)?;
            assert_eq!(installs(), expected, "{of_lock} {of_installed}");
        }
        Ok(fs::remove_dir_all(&folder)?)
    }
}
