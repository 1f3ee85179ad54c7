//! `cargo xtask test --sources`: the sources of the cylinder, compiled for other processors and run there. Every result is
//! compared with the library in Rust, bit for bit.

mod target;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

use self::target::Target;
use super::Size;
use crate::build::tools::{self, Tool};
use crate::build::{self, wasm};
use crate::description::Version;
use crate::platform_test::{Machine, experiments_of, same};
use crate::process::{self, heading};
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Compiles and runs the sources for all targets; a missing tool is an error.
///
/// # Errors
/// When a tool is missing, a step fails or a bit differs.
pub fn run(workspace: &Workspace) -> Result<()> {
    tools::require(missing(&Target::ALL)?)?;
    on(workspace, &Target::ALL)
}

fn missing(targets: &[Target]) -> Result<Vec<(&'static str, Vec<Tool>)>> {
    let mut missing = vec![("the sources in C", wasm::missing()?), ("running them", Machine::Linux.missing())];
    missing.extend(targets.iter().map(|target| (target.name(), target.missing())));
    Ok(missing)
}

fn on(workspace: &Workspace, targets: &[Target]) -> Result<()> {
    heading("Sources in C: build them");
    let folder = workspace.target.join("sources-test");
    let sources = write(workspace, &folder)?;
    heading("Sources in C: run every law on this machine, through FMI");
    through_fmi(workspace, &folder, &sources)?;
    heading("Sources in C: run a control loop");
    let expected = Target::Linux.run(workspace, &folder, &sources)?;
    print!("{expected}");
    for target in targets.iter().filter(|target| **target != Target::Linux) {
        let found = target.run(workspace, &folder, &sources)?;
        ensure!(found == expected, "{} computes other bits:\n{found}instead of\n{expected}", target.name());
        println!("{}: the same bits", target.name());
    }
    Ok(())
}

/// The sources of both faces in a folder; their C files.
fn write(workspace: &Workspace, folder: &Path) -> Result<Vec<PathBuf>> {
    let module = super::module(workspace, &MODEL, Size::Small)?;
    let sources = super::of(workspace, &MODEL, &Version::ALL, &module)?;
    if folder.exists() {
        std::fs::remove_dir_all(folder).with_context(|| format!("cannot remove the old {}", folder.display()))?;
    }
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (name, text) in &sources.files {
        std::fs::write(folder.join(name), text).with_context(|| format!("cannot write {name}"))?;
    }
    let size: usize = sources.files.values().map(String::len).sum();
    println!("{}: {} KB of C", folder.display(), size / 1000);
    Ok(sources.compiled.iter().map(|name| folder.join(name)).collect())
}

/// A shared library of both faces, run as the one in Rust is.
fn through_fmi(workspace: &Workspace, folder: &Path, sources: &[PathBuf]) -> Result<()> {
    // The headers of the standard as FMPy has them.
    let headers = Venv::prepare(workspace, Requirements::PACKAGE)?.module("fmpy")?.join("c-code");
    let library = library(folder);
    let mut compiler = Command::new("gcc");
    // Contracted operations are what the sources must keep out by themselves.
    compiler.args(["-std=gnu99", "-O1", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror"]);
    if has_fused_operations() {
        compiler.arg("-mfma");
    }
    compiler.args(["-DFMI2_OVERRIDE_FUNCTION_PREFIX", "-DFMI3_OVERRIDE_FUNCTION_PREFIX", "-I"]).arg(&headers);
    compiler.args(sources).arg(folder.join("loop.c")).arg("-lm").arg("-o").arg(&library);
    process::run(&mut compiler)?;
    let compiled = std::fs::read(&library).context("cannot read the library")?;
    let experiments = experiments_of(&MODEL);
    let expected = Machine::Linux.run(workspace, &build::for_this_machine(workspace)?, &experiments)?;
    same("the library from C", &expected, &Machine::Linux.run(workspace, &compiled, &experiments)?)
}

/// Where the library of the faces is.
fn library(folder: &Path) -> PathBuf {
    folder.join("library.so")
}

/// Whether this processor computes a product and a sum in one operation.
fn has_fused_operations() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    false
}
