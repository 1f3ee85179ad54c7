//! `cargo xtask test --sources`: the sources in C, compiled for this machine and for others, and run there. Every result is
//! compared with the library in Rust, bit for bit.

mod compiled;
mod footprint;
mod single_law;
mod suite;
mod target;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Model;
use pneumatic_servo::models::{self, pneumatic_servo_cylinder::MODEL};
use pneumatic_servo_fmu::guid;
use pneumatic_servo_packaging::build::wasm;
use pneumatic_servo_packaging::files;
use pneumatic_servo_packaging::library::Library;
use pneumatic_servo_packaging::package;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::sources;
use pneumatic_servo_packaging::tools::{self, Tool};
use pneumatic_servo_packaging::venv::{Requirements, Venv};
use pneumatic_servo_packaging::workspace::Workspace;

use self::compiled::Written;
use self::target::Target;
use crate::platform_test::{Machine, experiments_of, same};
use crate::valgrind;

/// Compiles and runs the sources of all models, and of the cylinder for all targets, or only for some models or targets; a missing
/// tool is an error.
///
/// # Errors
/// When a tool is missing, a step fails or a bit differs, or nothing is called as is asked for.
pub fn run(workspace: &Workspace, only: &[String]) -> Result<()> {
    let names = models::ALL.iter().map(|model| model.name).chain(Target::ALL.map(|target| target.compiler().folder));
    ensure_known(only, "no model and no target", names.chain([LOOP, TRANSLATOR]).collect())?;
    let models: Vec<_> = models::ALL.iter().filter(|model| is_wanted(only, model.name)).collect();
    let targets: Vec<_> = Target::ALL.into_iter().filter(|target| is_wanted(only, target.compiler().folder)).collect();
    tools::require(missing(&targets)?)?;
    let rust = if models.is_empty() && targets.is_empty() { Vec::new() } else { Library::for_tests(workspace)?.bytes };
    let mut cylinder = None;
    for model in models {
        let Made { written, plant, library } = on_this_machine(workspace, model, &rust)?;
        heading(&format!("Sources in C of {}: the tests of the C interface", model.name));
        suite::run(workspace, model, &library)?;
        heading(&format!("Sources in C of {}: FMUs that FMPy compiles", model.name));
        by_fmpy(workspace, model, &written.module)?;
        if model.name == MODEL.name {
            heading("Sources in C: instructions of a step");
            println!("law, instructions of a step in Rust, from C, ratio");
            println!("{}", speed(workspace, &written, &rust, &library)?.join("\n"));
            cylinder = Some((written, plant));
        }
    }
    if is_wanted(only, LOOP) {
        tools::require(missing(&[Target::CortexM7])?)?;
        single_law::run(workspace)?;
    }
    if is_wanted(only, TRANSLATOR) {
        translator(workspace)?;
    }
    if targets.is_empty() {
        return Ok(());
    }
    let (written, plant) = match cylinder {
        Some(made) => made,
        None => {
            let written = Written::of(workspace, &MODEL)?;
            let plant = written.plant(&Target::Linux.compiler())?;
            (written, plant)
        }
    };
    on_targets(workspace, &targets, &written, &plant, &rust)
}

/// Name of the loops of one law for `--only`.
const LOOP: &str = "loop";
/// Name of the core tests of the translator for `--only`.
const TRANSLATOR: &str = "wasm-as-c";

/// The core tests of the specification of WebAssembly, for the translator to C.
fn translator(workspace: &Workspace) -> Result<()> {
    heading("Sources in C: the core tests of WebAssembly");
    let mut cargo = process::cargo();
    cargo.args(["test", "--profile", "quick", "--package", "wasm-as-c", "--features", "core-tests", "--test", "core"]);
    process::run(cargo.current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target))
}

/// The numbers of all laws, which have no gaps.
fn all_laws() -> Range<i32> {
    1..LAWS.items.len() as i32 + 1
}

/// The core tests of the translator, and the sources of the cylinder on this machine; where a tool is missing, that is an error under
/// CI and otherwise said.
///
/// # Errors
/// When a tool is missing under CI, a step fails or a bit differs.
pub fn run_if_possible(workspace: &Workspace) -> Result<()> {
    match tools::require(missing(&[Target::Linux])?) {
        Ok(()) => {
            translator(workspace)?;
            on_this_machine(workspace, &MODEL, &Library::for_tests(workspace)?.bytes).map(|_| ())
        }
        Err(problem) => process::leave_out("Sources in C", &format!("{problem:#}")),
    }
}

/// Random calls of the sources of all models, or of some, for so long at least, each time other ones.
///
/// # Errors
/// When a tool is missing, a step fails or a call does not do what the model does, or there is no such model.
pub fn fuzz(workspace: &Workspace, length: Duration, only: &[String]) -> Result<()> {
    ensure_known(only, "no model", models::ALL.iter().map(|model| model.name).collect())?;
    tools::require(missing(&[Target::Linux])?)?;
    let rust = Library::for_tests(workspace)?.bytes;
    let mut libraries = Vec::new();
    for model in models::ALL.iter().filter(|model| is_wanted(only, model.name)) {
        libraries.push((model, on_this_machine(workspace, model, &rust)?.library));
    }
    heading("Sources in C: random calls");
    let begin = Instant::now();
    let mut rounds = 0;
    while !length.saturating_sub(begin.elapsed()).is_zero() {
        for (model, library) in &libraries {
            suite::fuzz(workspace, model, library, rounds)?;
        }
        rounds += 1;
    }
    let (models, seconds) = (libraries.len(), begin.elapsed().as_secs_f64());
    println!("{rounds} rounds with {models} of {} models in {seconds:.0} s, and nothing was found", models::ALL.len());
    Ok(())
}

/// Refuses a name that none of some has.
fn ensure_known(only: &[String], what: &str, names: Vec<&str>) -> Result<()> {
    match only.iter().find(|name| !names.contains(&name.as_str())) {
        Some(unknown) => bail!("`{unknown}` is {what}; there are {}", names.join(", ")),
        None => Ok(()),
    }
}

/// Whether a name is wanted: listed, or none is listed.
fn is_wanted(only: &[String], name: &str) -> bool {
    only.is_empty() || only.iter().any(|only| only == name)
}

fn missing(targets: &[Target]) -> Result<Vec<(&'static str, Vec<Tool>)>> {
    let mut missing = vec![("the sources in C", wasm::missing()?), ("running them", Machine::Linux.missing())];
    missing.extend(targets.iter().map(|target| (target.name(), target.missing())));
    Ok(missing)
}

/// The sources of a model, compiled for this machine.
struct Made {
    written: Written,
    /// The objects without the functions of FMI.
    plant: Vec<PathBuf>,
    library: PathBuf,
}

/// Compiles the sources of a model, and runs their library.
fn on_this_machine(workspace: &Workspace, model: &'static Model, rust: &[u8]) -> Result<Made> {
    heading(&format!("Sources in C of {}: make and compile them", model.name));
    let written = Written::of(workspace, model)?;
    let compiler = Target::Linux.compiler();
    let plant = written.plant(&compiler)?;
    let library = written.library(&compiler, &[plant.clone(), written.faces(&compiler)?].concat())?;
    heading(&format!("Sources in C of {}: run every law through FMI", model.name));
    let experiments = experiments_of(model);
    let expected = Machine::Linux.run(workspace, rust, &experiments)?;
    same("the library from C", &expected, &Machine::Linux.run(workspace, &files::read(&library)?, &experiments)?)?;
    Ok(Made { written, plant, library })
}

/// The cylinder on this machine and on targets: a control loop and all laws on each, and FMI where a machine can load libraries.
fn on_targets(
    workspace: &Workspace,
    targets: &[Target],
    written: &Written,
    plant: &[PathBuf],
    rust: &[u8],
) -> Result<()> {
    heading(&format!("Sources in C: {}", Target::Linux.name()));
    let expected = Target::Linux.run(workspace, written, plant, &all_laws())?;
    print!("{}", expected.bits);
    let experiments = experiments_of(&MODEL);
    let reference = Machine::Linux.run(workspace, rust, &experiments)?;
    let mut needs = Ok(());
    for target in targets.iter().filter(|target| **target != Target::Linux) {
        heading(&format!("Sources in C: {}", target.name()));
        let compiler = target.compiler();
        let plant = written.plant(&compiler)?;
        let found = target.run(workspace, written, &plant, &all_laws())?;
        let (bits, others) = (found.bits, &expected.bits);
        ensure!(bits == *others, "{} computes other bits:\n{bits}instead of\n{others}", target.name());
        println!("{}: the same bits", target.name());
        if target.has_no_system() {
            // All rows are told before the first that the page does not have ends this.
            needs = needs.and(found.needs.compare(workspace, target.name(), &compiler));
        }
        if let Some(machine) = target.machine() {
            let library = written.library(&compiler, &[plant, written.faces(&compiler)?].concat())?;
            same(target.name(), &reference, &machine.run(workspace, &files::read(&library)?, &experiments)?)?;
        }
    }
    needs
}

/// FMPy compiles FMUs of both versions, as for its users, and runs them beside the library in Rust.
fn by_fmpy(workspace: &Workspace, model: &'static Model, module: &[u8]) -> Result<()> {
    let library = Library::for_tests(workspace)?;
    let venv = Venv::prepare(workspace, Requirements::TESTS)?;
    let folder = workspace.target.join("sources-test/fmpy");
    let sources = |version| Ok(Some(sources::sources(workspace, model, &[version], module)?));
    let fmus = package::write(workspace, model, &[library], sources, &folder)?;
    let stated = folder.join("experiments.json");
    files::write(&stated, pneumatic_servo_packaging::experiment::stated(workspace.product.models)?)?;
    let mut python = venv.command();
    python.arg(workspace.python().join("compiled.py")).args(fmus).arg("--experiments").arg(stated);
    process::run(python.env("PATH", venv.path()?))
}

/// Instructions of a step in the Rust library and in the library from C, by valgrind, and their ratio: a row for each law.
fn speed(workspace: &Workspace, written: &Written, rust: &[u8], library: &Path) -> Result<Vec<String>> {
    /// The difference between a long and a short run, so that the start does not count.
    const STEPS: [u64; 2] = [50, 350];
    let compiler = Target::Linux.compiler();
    let files = [workspace.root.join("tests/sources/speed.c"), "-ldl".into()];
    let program = written.program(&compiler, "speed", &files, &[])?;
    let native = written.folder.join("native.so");
    std::fs::write(&native, rust).context("cannot write the library in Rust")?;
    let measure = |library: &Path, law: usize| {
        let of = |steps: u64| {
            let mut command = Command::new(&program);
            valgrind::instructions(command.arg(library).arg(guid(&MODEL)).args([law.to_string(), steps.to_string()]))
        };
        Ok::<u64, anyhow::Error>((of(STEPS[1])? - of(STEPS[0])?) / (STEPS[1] - STEPS[0]))
    };
    let row = |(law, item): (usize, &(i32, &str, &str))| {
        let (native, compiled) = (measure(&native, law)?, measure(library, law)?);
        Ok(format!("{:>16} {native:>8} {compiled:>8} {:>6.2}", item.1, compiled as f64 / native as f64))
    };
    (1..).zip(LAWS.items).map(row).collect()
}
