//! `cargo xtask wheel`: the Python package with the FMUs and the playground inside, as a wheel in `target/wheels`.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use pneumatic_servo_packaging::files;
use pneumatic_servo_packaging::gates;
use pneumatic_servo_packaging::platform::Platform;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::venv::{Requirements, Venv};
use pneumatic_servo_packaging::workspace::Workspace;

use crate::playground;

/// The help of the command.
pub const HELP: &str = "\
Build the Python package with the FMUs of target/fmu inside, as a wheel in target/wheels.

Usage: cargo xtask wheel

The playground is inside too, where this machine can build it; otherwise the missing tools are named.

Examples:
  cargo xtask package && cargo xtask wheel
  pip install target/wheels/*.whl          into an environment of yours";

/// Builds the page, where that is possible, and the wheel.
///
/// # Errors
/// When there are no FMUs yet, or a tool fails.
pub fn run(workspace: &Workspace) -> Result<()> {
    let page = playground::page_if_possible(workspace)?;
    build(workspace, page.as_deref()).map(|_| ())
}

/// Builds the wheel, with the page where there is one. On Linux it runs wherever the FMUs do; elsewhere on machines like this one.
///
/// # Errors
/// When there are no FMUs yet, or a tool is missing or fails.
pub fn build(workspace: &Workspace, page: Option<&Path>) -> Result<PathBuf> {
    let package = workspace.root.join("python");
    heading("Build the wheel");
    bundle(&workspace.fmus(), &package.join("pneumatic_servo/fmu_files"))?;
    bundle_page(page, &package.join("pneumatic_servo/playground_files"))?;
    let wheels = workspace.target.join("wheels");
    if wheels.exists() {
        fs::remove_dir_all(&wheels).with_context(|| format!("cannot remove the old {}", wheels.display()))?;
    }
    let for_linux = if cfg!(target_os = "linux") { linux() } else { Vec::new() };
    process::run(&mut maturin(workspace, &wheels, &for_linux)?)?;
    let wheel = only_file(&wheels)?;
    println!(
        "{}: {}",
        wheel.display(),
        gates::check_module(Platform::host()?, &[std::env::consts::ARCH], &module(&wheel)?)?
    );
    Ok(wheel)
}

/// The compiled part of a wheel.
fn module(wheel: &Path) -> Result<Vec<u8>> {
    let file = fs::File::open(wheel).with_context(|| format!("cannot open {}", wheel.display()))?;
    let mut archive = zip::ZipArchive::new(file)?;
    let is_module = |name: &str| name.starts_with("pneumatic_servo/_native.") && !name.ends_with(".pyi");
    let names = archive.file_names().map(|name| Ok(name?.into_owned())).collect::<Result<Vec<String>>>()?;
    let name = names.iter().find(|name| is_module(name));
    let name = name.with_context(|| format!("{} has no compiled part", wheel.display()))?;
    let mut bytes = Vec::new();
    archive.by_name(name)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Linked by Zig, for every Linux that the FMUs run on.
fn linux() -> Vec<String> {
    let (major, minor) = gates::NEWEST_GLIBC;
    ["--zig", "--compatibility", &format!("manylinux_{major}_{minor}")].map(str::to_owned).into()
}

fn maturin(workspace: &Workspace, out: &Path, options: &[String]) -> Result<Command> {
    let venv = Venv::prepare(workspace, Requirements::ZIG)?;
    let cache = workspace.environments.join("zig-cache");
    let (major, minor) = gates::OLDEST_MACOS;
    let mut maturin = venv.command();
    maturin.args(["-m", "maturin", "build", "--release", "--locked", "--out"]).arg(out).args(options);
    maturin
        .current_dir(workspace.root.join("python"))
        .env("PATH", venv.path()?)
        .env("CARGO_TARGET_DIR", workspace.target.join("cross"))
        .env("MACOSX_DEPLOYMENT_TARGET", format!("{major}.{minor}"))
        .env("CARGO_ZIGBUILD_CACHE_DIR", &cache)
        .env("ZIG_GLOBAL_CACHE_DIR", &cache);
    Ok(maturin)
}

/// Installs the wheel into an environment, in place of one installed before.
///
/// # Errors
/// When pip fails.
pub fn install(venv: &Venv, wheel: &Path) -> Result<()> {
    let options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--force-reinstall"];
    process::run(venv.command().args(["-m", "pip", "install"]).args(options).arg(wheel))
}

/// Copies the page into the package, if there is one.
fn bundle_page(page: Option<&Path>, to: &Path) -> Result<()> {
    files::renew(to)?;
    let Some(page) = page else { return Ok(()) };
    fs::copy(page, to.join("index.html")).with_context(|| format!("cannot copy {}", page.display()))?;
    Ok(())
}

/// Copies the FMUs and the drive into the package, and nothing else.
fn bundle(from: &Path, to: &Path) -> Result<()> {
    files::renew(to)?;
    let mut copied = 0;
    for file in files(from).with_context(|| format!("no FMUs in {}: run `cargo xtask package`", from.display()))? {
        if file.extension().is_some_and(|extension| extension == "fmu" || extension == "ssp") {
            let name = file.file_name().context("a file without a name")?;
            fs::copy(&file, to.join(name)).with_context(|| format!("cannot copy {}", file.display()))?;
            copied += 1;
        }
    }
    if copied == 0 {
        bail!("no FMUs in {}: run `cargo xtask package`", from.display());
    }
    Ok(())
}

fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect()
}

fn only_file(folder: &Path) -> Result<PathBuf> {
    match &files(folder)?[..] {
        [file] => Ok(file.clone()),
        found => bail!("{} files in {}, not one wheel", found.len(), folder.display()),
    }
}
