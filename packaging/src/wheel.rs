//! `cargo xtask wheel`: the Python package with the FMUs and the playground inside, as a wheel in `target/wheels`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::build::toolchain::Toolchain;
use crate::files;
use crate::gates;
use crate::playground;
use crate::process::{self, heading};
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Build the Python package with the FMUs of target/fmu inside, as a wheel in target/wheels.
///
/// The playground is inside too, where this machine can build it; otherwise the missing tools are named.
#[derive(Args)]
#[command(after_help = "\
Examples:
  cargo xtask package && cargo xtask wheel
  pip install target/wheels/*.whl          into an environment of yours")]
pub struct Wheel {}

impl Wheel {
    /// Builds the wheel.
    ///
    /// # Errors
    /// As [`build`].
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        build(workspace).map(|_| ())
    }
}

/// Builds the wheel. On Linux it runs wherever the FMUs do; elsewhere on machines like this one.
///
/// # Errors
/// When there are no FMUs yet, or a tool is missing or fails.
pub fn build(workspace: &Workspace) -> Result<PathBuf> {
    let package = workspace.root.join("python");
    let page = playground::page_if_possible(workspace)?;
    heading("Build the wheel");
    bundle(&workspace.fmus(), &package.join("pneumatic_servo/fmu_files"))?;
    bundle_page(page.as_deref(), &package.join("pneumatic_servo/playground_files"))?;
    let wheels = workspace.target.join("wheels");
    if wheels.exists() {
        fs::remove_dir_all(&wheels).with_context(|| format!("cannot remove the old {}", wheels.display()))?;
    }
    let for_linux = if cfg!(target_os = "linux") { linux() } else { Vec::new() };
    process::run(&mut maturin(workspace, &wheels, &for_linux)?)?;
    let wheel = only_file(&wheels)?;
    println!("{}", wheel.display());
    Ok(wheel)
}

/// Builds a wheel of what was bundled last, for another system or processor that a toolchain can compile for, into a folder
/// of its own.
///
/// # Errors
/// When a tool is missing or fails.
pub fn build_for(workspace: &Workspace, toolchain: &Toolchain, target: &str, folder: &Path) -> Result<PathBuf> {
    files::renew(folder)?;
    // The linker of MinGW is at hand where the library for Windows is built; what Zig brings for Windows is another one.
    let mut options = match target {
        _ if target.contains("linux") => linux(),
        _ => ["--features", "import-library"].map(str::to_owned).into(),
    };
    options.extend(["--target".to_owned(), target.to_owned()]);
    let mut maturin = maturin(workspace, folder, &options)?;
    if toolchain.compiles_std {
        maturin.env("CARGO_UNSTABLE_BUILD_STD", "std,panic_unwind");
    }
    process::run(toolchain.lead(&mut maturin))?;
    only_file(folder)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stand_in::{self, Answer, StandIn};

    /// FMUs and the drive are inside, and nothing else of their folder; a wheel of the last time is gone.
    #[test]
    fn a_wheel_holds_the_fmus() -> Result<()> {
        let folder = crate::files::scratch("wheel");
        let workspace = Workspace::made_up(&folder);
        let machine = |wheels: usize| {
            let machine = StandIn::new(move |command| {
                let out = command.says("maturin build").then(|| Path::new(command.after("--out")).to_owned())?;
                (0..wheels).for_each(|n| drop(stand_in::writes(out.join(format!("{n}.whl")), "")));
                None
            });
            machine.lacking("npm")
        };
        let (outcome, started) = machine(1).does(|| build(&workspace));
        assert!(outcome.is_err_and(|error| error.to_string().contains("run `cargo xtask package`")));
        assert!(started.is_empty(), "{started:?}");
        for name in ["a.csv", "b.svg"] {
            crate::files::write(&workspace.fmus().join(name), "")?;
        }
        assert!(machine(1).does(|| build(&workspace)).0.is_err_and(|error| error.to_string().contains("no FMUs")));
        for name in ["Model.fmu", "Drive.ssp"] {
            crate::files::write(&workspace.fmus().join(name), name)?;
        }
        crate::files::write(&workspace.target.join("wheels/old.whl"), "")?;
        let (wheel, started) = machine(1).does(|| build(&workspace));
        assert_eq!(wheel?, workspace.target.join("wheels/0.whl"));
        let mut inside = files(&workspace.root.join("python/pneumatic_servo/fmu_files"))?;
        inside.sort();
        let names: Vec<_> = inside.iter().filter_map(|file| file.file_name()).collect();
        assert_eq!(names, ["Drive.ssp", "Model.fmu"]);
        let maturin = started.last().context("no maturin")?;
        assert_eq!(maturin.folder, Some(workspace.root.join("python")));
        assert!(maturin.says("build --release --locked"), "{maturin:?}");
        assert_eq!(maturin.says("--compatibility manylinux_2_17"), cfg!(target_os = "linux"));
        let several = machine(2).does(|| build(&workspace)).0.map_err(|error| error.to_string());
        assert!(several.is_err_and(|text| text.starts_with("2 files in ")));
        Ok(fs::remove_dir_all(&folder)?)
    }

    /// In place of one installed before.
    #[test]
    fn a_wheel_is_installed_alone() -> Result<()> {
        let folder = crate::files::scratch("wheel-install");
        let workspace = Workspace::of_a_test(&folder);
        let put = |machine: StandIn| {
            machine.does(|| install(&Venv::prepare(&workspace, Requirements::ZIG)?, Path::new("a.whl")))
        };
        let (outcome, started) = put(StandIn::new(|_| None));
        outcome?;
        let pip = started.last().context("no pip")?;
        assert!(pip.says("-m pip install") && pip.says("--no-deps --force-reinstall a.whl"), "{pip:?}");
        assert!(put(StandIn::new(|it| it.says("--force-reinstall").then_some(Answer::Fails))).0.is_err());
        Ok(fs::remove_dir_all(&folder)?)
    }
}
