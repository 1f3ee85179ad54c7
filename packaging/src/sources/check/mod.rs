//! `cargo xtask test --sources`: the sources in C, compiled for this machine and for others, and run there. Every result is
//! compared with the library in Rust, bit for bit.

mod compiled;
mod suite;
mod target;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Model;
use pneumatic_servo::models::{self, pneumatic_servo_cylinder::MODEL};
use pneumatic_servo_fmu::guid;

use self::compiled::Written;
use self::target::Target;
use crate::build::tools::{self, Tool};
use crate::build::{self, wasm};
use crate::files;
use crate::library::Library;
use crate::package;
use crate::platform_test::{Machine, experiments_of, same};
use crate::process::{self, heading};
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Compiles and runs the sources of all models, and those of the cylinder for all targets; a missing tool is an error.
///
/// # Errors
/// When a tool is missing, a step fails or a bit differs.
pub fn run(workspace: &Workspace) -> Result<()> {
    tools::require(missing(&Target::ALL)?)?;
    let rust = build::for_this_machine(workspace)?;
    for model in models::ALL {
        let (written, plant, library) = on_this_machine(workspace, model, &rust)?;
        heading(&format!("Sources in C of {}: the tests of the C interface", model.name));
        suite::run(workspace, model, &library)?;
        if model.name == MODEL.name {
            heading("Sources in C: how long a step takes");
            speed(workspace, &written, &rust, &library)?;
            heading("Sources in C: FMUs that FMPy compiles");
            by_fmpy(workspace)?;
            on_targets(workspace, &written, &plant, &rust)?;
        }
    }
    Ok(())
}

/// The sources of the cylinder on this machine; where a tool is missing, that is an error under CI and otherwise said.
///
/// # Errors
/// When a tool is missing under CI, a step fails or a bit differs.
pub fn run_if_possible(workspace: &Workspace) -> Result<()> {
    match tools::require(missing(&[Target::Linux])?) {
        Ok(()) => on_this_machine(workspace, &MODEL, &build::for_this_machine(workspace)?).map(|_| ()),
        Err(problem) => process::leave_out("Sources in C", &format!("{problem:#}")),
    }
}

/// Random calls of the sources of all models for so long at least, each time other ones.
///
/// # Errors
/// When a tool is missing, a step fails or a call does not do what the model does.
pub fn fuzz(workspace: &Workspace, length: Duration) -> Result<()> {
    tools::require(missing(&[Target::Linux])?)?;
    let rust = build::for_this_machine(workspace)?;
    let mut libraries = Vec::new();
    for model in models::ALL {
        libraries.push((model, on_this_machine(workspace, model, &rust)?.2));
    }
    heading("Sources in C: random calls");
    let begin = Instant::now();
    let mut rounds = 0;
    while begin.elapsed() < length {
        for (model, library) in &libraries {
            suite::fuzz(workspace, model, library, rounds)?;
        }
        rounds += 1;
    }
    println!("{rounds} rounds with all models in {:.0} s, and nothing was found", begin.elapsed().as_secs_f64());
    Ok(())
}

fn missing(targets: &[Target]) -> Result<Vec<(&'static str, Vec<Tool>)>> {
    let mut missing = vec![("the sources in C", wasm::missing()?), ("running them", Machine::Linux.missing())];
    missing.extend(targets.iter().map(|target| (target.name(), target.missing())));
    Ok(missing)
}

/// The sources of a model, their objects without the functions of FMI, and their library, which has been run.
fn on_this_machine(
    workspace: &Workspace,
    model: &'static Model,
    rust: &[u8],
) -> Result<(Written, Vec<PathBuf>, PathBuf)> {
    heading(&format!("Sources in C of {}: make and compile them", model.name));
    let written = Written::of(workspace, model)?;
    let compiler = Target::Linux.compiler();
    let plant = written.plant(&compiler)?;
    let library = written.library(&compiler, &[plant.clone(), written.faces(&compiler)?].concat())?;
    heading(&format!("Sources in C of {}: run every law through FMI", model.name));
    let experiments = experiments_of(model);
    let expected = Machine::Linux.run(workspace, rust, &experiments)?;
    same("the library from C", &expected, &Machine::Linux.run(workspace, &read(&library)?, &experiments)?)?;
    Ok((written, plant, library))
}

/// The cylinder on all targets: a control loop and all laws on each, and FMI where a machine can load libraries.
fn on_targets(workspace: &Workspace, written: &Written, plant: &[PathBuf], rust: &[u8]) -> Result<()> {
    heading(&format!("Sources in C: {}", Target::Linux.name()));
    let expected = Target::Linux.run(workspace, written, plant)?;
    print!("{expected}");
    let experiments = experiments_of(&MODEL);
    for target in Target::ALL.into_iter().filter(|target| *target != Target::Linux) {
        heading(&format!("Sources in C: {}", target.name()));
        let compiler = target.compiler();
        let plant = written.plant(&compiler)?;
        let found = target.run(workspace, written, &plant)?;
        ensure!(found == expected, "{} computes other bits:\n{found}instead of\n{expected}", target.name());
        println!("{}: the same bits", target.name());
        if let Some(machine) = target.machine() {
            let library = written.library(&compiler, &[plant, written.faces(&compiler)?].concat())?;
            let reference = Machine::Linux.run(workspace, rust, &experiments)?;
            same(target.name(), &reference, &machine.run(workspace, &read(&library)?, &experiments)?)?;
        }
    }
    Ok(())
}

/// FMPy compiles FMUs of both versions as it compiles those of others, and runs them beside the library in Rust.
fn by_fmpy(workspace: &Workspace) -> Result<()> {
    let module = super::module(workspace, &MODEL, super::Size::Small)?;
    let library = Library::for_this_machine(workspace)?;
    let venv = Venv::prepare(workspace, Requirements::TESTS)?;
    let folder = workspace.target.join("sources-test/fmpy");
    let sources = |version| Ok(Some(super::of(workspace, &MODEL, &[version], &module)?));
    let fmus = package::write(workspace, &MODEL, &[library], sources, &folder)?;
    let stated = folder.join("experiments.json");
    files::write(&stated, crate::describe::experiments(workspace.product.models)?)?;
    let mut python = venv.command();
    python.arg(workspace.python().join("compiled.py")).args(fmus).arg("--experiments").arg(stated);
    process::run(python.env("PATH", venv.path()?))
}

/// Prints how long a step takes in the library in Rust and in that from C, once compiled for size and once for speed.
fn speed(workspace: &Workspace, written: &Written, rust: &[u8], library: &Path) -> Result<()> {
    let compiler = Target::Linux.compiler();
    let laws = format!("-DLAWS={}", LAWS.items.len());
    let files = [laws.into(), workspace.root.join("tests/sources/speed.c"), "-ldl".into()];
    let program = written.program(&compiler, "speed", &files, &[])?;
    let native = written.folder.join("native.so");
    std::fs::write(&native, rust).context("cannot write the library in Rust")?;
    let measure = |library: &Path| {
        let printed = process::output(Command::new(&program).arg(library).arg(guid(&MODEL)))?;
        let numbers = printed.lines().filter_map(|line| line.split(' ').nth(1)?.parse().ok());
        Ok::<Vec<f64>, anyhow::Error>(numbers.collect())
    };
    let (native, compiled) = (measure(&native)?, measure(library)?);
    println!("law, ns a step in Rust, ns a step from C, ratio");
    for ((item, native), compiled) in LAWS.items.iter().zip(native).zip(compiled) {
        println!("{:>16} {native:>8.0} {compiled:>8.0} {:>6.2}", item.1, compiled / native);
    }
    Ok(())
}

fn read(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))
}
