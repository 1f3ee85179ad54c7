//! Checks under valgrind: memory errors of the C interface, and instruction counts, which tell a slower step without
//! a clock.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use pneumatic_servo_packaging::files;
use pneumatic_servo_packaging::library::Library;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::workspace::Workspace;
use serde::{Deserialize, Serialize};

/// Looks for memory errors, and compares the instruction counts with the record.
///
/// # Errors
/// When a check fails, or under CI when valgrind is missing.
pub fn check(workspace: &Workspace) -> Result<()> {
    if !is_available() {
        let reason = "valgrind is missing (apt install valgrind)";
        return process::leave_out("Memory checks and instruction counts", reason);
    }
    heading("C interface under valgrind");
    check_memory(workspace)?;
    heading("Instructions of a communication step");
    check_instructions(workspace)
}

/// Whether valgrind is installed.
fn is_available() -> bool {
    process::find("valgrind").is_some()
}

/// Runs tests of the C interface under valgrind, which fails on any invalid access.
///
/// # Errors
/// When it finds something or a test fails.
fn check_memory(workspace: &Workspace) -> Result<()> {
    /// Tests that repeat others many times, such as the table of all functions of FMI 3.0 in all modes, which mostly makes 800
    /// instances; or that start programs of their own.
    const LONG: [&str; 8] = [
        "for_every_law",
        "whatever_the_law",
        "all_models_and_laws",
        "state_before_an_event",
        "fmi3::state_machine::every_function",
        "corrupt_bytes",
        "eight_threads",
        "another_process",
    ];
    let mut interface = tests(workspace, "c_interface");
    interface.args(LONG.into_iter().flat_map(|name| ["--skip", name]));
    process::run(&mut interface)?;
    // Inputs that a fuzzer has kept make many times as many calls; the address sanitizer sees them.
    process::run(tests(workspace, "fuzz").args(["--skip", "kept"]).env("SERVO_FUZZ_CALLS", "8000"))
}

fn tests(workspace: &Workspace, name: &str) -> Command {
    const RUNNER: &str = "target.'cfg(all())'.runner = ['valgrind', '--quiet', '--error-exitcode=9']";
    let mut cargo = process::cargo();
    cargo.args(["--config", RUNNER, "test", "--test", name, "--", "--test-threads", "1"]);
    cargo.current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target);
    cargo
}

/// Instructions of a communication step of 1 ms with a new input sample in the library of the FMUs, by the arguments of `steps`,
/// and how they were made.
#[derive(Serialize, Deserialize)]
struct Counts {
    rustc: String,
    instructions: BTreeMap<String, u64>,
}

/// Friction laws, one of them with a loose tolerance and with options, one with hoses, and one under which steps are implicit.
const CASES: [&str; 11] = [
    "Stribeck",
    "Stribeck load.stiffness=50",
    "Stribeck sensor.position.sampleTime=1e-3",
    "Stribeck solver.relativeTolerance=1e-4",
    "Polito",
    "Dahl",
    "LuGre",
    "LuGre hoseA.length=2 hoseB.length=2",
    "GMS",
    "ElastoPlastic",
    "SmoothCoulomb",
];
/// A twentieth more than recorded fails; the C library's copies take a few instructions more or less on other machines.
const ALLOWANCE: f64 = 1.05;
const RECORD: &str = "tests/benches/instructions.json";

/// Counts, and compares with the record.
///
/// # Errors
/// When a step needs clearly more instructions than recorded with the same compiler; under CI, with another compiler.
fn check_instructions(workspace: &Workspace) -> Result<()> {
    let file = workspace.root.join(RECORD);
    let text = files::text(&file)?;
    let recorded: Counts = serde_json::from_str(&text).with_context(|| format!("{} is no record", file.display()))?;
    let counted = count(workspace)?;
    let mut slower = Vec::new();
    for (case, instructions) in &counted.instructions {
        let before = *recorded.instructions.get(case).with_context(|| format!("{RECORD} lacks {case}"))?;
        println!("{case}: {instructions} instructions per step, {before} recorded");
        if *instructions as f64 > ALLOWANCE * before as f64 {
            slower.push(case.as_str());
        }
    }
    if counted.rustc != recorded.rustc {
        let reason = format!("recorded with {}, this is {}", recorded.rustc, counted.rustc);
        return process::leave_out("Comparison of instruction counts", &reason);
    }
    ensure!(
        slower.is_empty(),
        "a step takes more instructions than recorded under {}; if that is meant: cargo xtask record",
        slower.join(", ")
    );
    Ok(())
}

/// The help of `record`.
pub const HELP: &str = "\
Record what the checks compare with: bits of runs, counts of solver steps in the docs, instructions of a step.

Usage: cargo xtask record

The instruction counts of a communication step need valgrind.";

/// Runs and counts, and writes the records.
///
/// # Errors
/// When a run fails, valgrind is missing or a record cannot be written.
pub fn record(workspace: &Workspace) -> Result<()> {
    heading("Bits of many runs, counts in the docs");
    for tests in [&["recorded_runs"][..], &["plant", "documented"]] {
        let mut cargo = process::cargo();
        cargo.args(["test", "--test"]).args(tests).env("SERVO_RECORD", "1");
        process::run(cargo.current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target))?;
    }
    heading("Instructions of a communication step");
    ensure!(is_available(), "valgrind is missing (on Debian or Ubuntu: apt install valgrind)");
    let text = serde_json::to_string_pretty(&count(workspace)?)?;
    let file = workspace.root.join(RECORD);
    files::write(&file, format!("{text}\n"))?;
    println!("{}", file.display());
    Ok(())
}

fn count(workspace: &Workspace) -> Result<Counts> {
    let library = Library::for_tests(workspace)?.keep(workspace)?;
    let program = host(workspace)?;
    let version = process::output(Command::new("rustc").arg("--version"))?;
    let counted = CASES.into_iter().map(|case| Ok((case.to_owned(), per_step(&program, &library, case)?)));
    Ok(Counts { rustc: version.trim().to_owned(), instructions: counted.collect::<Result<_>>()? })
}

/// Program that calls the library, with the plant that the tests have compiled: it takes some dozens of the instructions.
fn host(workspace: &Workspace) -> Result<PathBuf> {
    let mut cargo = process::cargo();
    cargo.args(["build", "--package", "benchmark", "--bin", "steps", "--features", "pneumatic-servo/default"]);
    process::run(cargo.current_dir(&workspace.root).env("CARGO_TARGET_DIR", &workspace.target))?;
    Ok(workspace.target.join("debug/steps").with_extension(std::env::consts::EXE_EXTENSION))
}

/// The difference between a long and a short run, so that the start does not count.
fn per_step(program: &Path, library: &Path, case: &str) -> Result<u64> {
    const SHORT: u64 = 1000;
    const LONG: u64 = 3000;
    Ok((collected(program, library, case, LONG)? - collected(program, library, case, SHORT)?) / (LONG - SHORT))
}

fn collected(program: &Path, library: &Path, case: &str, steps: u64) -> Result<u64> {
    let mut words = case.split(' ');
    let law = words.next().context("no law")?;
    instructions(Command::new(program).arg(library).args([law, &steps.to_string()]).args(words))
}

/// Instructions of a program from its start to its end.
///
/// # Errors
/// When valgrind is missing, or the program fails.
pub fn instructions(program: &Command) -> Result<u64> {
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program.get_program())
        .args(program.get_args());
    let output = process::caught(&mut valgrind)?;
    let report = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("valgrind failed: {report}");
    }
    let number = report.lines().find_map(|line| line.split_once("Collected : ")).context("valgrind counted nothing")?.1;
    number.trim().parse().with_context(|| format!("valgrind counted {number}"))
}
