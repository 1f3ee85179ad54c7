//! `cargo xtask fuzz`: searches for inputs that reach new code.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_metadata::MetadataCommand;
use lexopt::Arg::{Long, Short, Value};
use lexopt::{Parser, ValueExt};
use pneumatic_servo_packaging::files;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::venv::{Requirements, Venv};
use pneumatic_servo_packaging::workspace::Workspace;

use crate::Work;
use crate::wheel;

/// The readers of files of the Python package; other targets are programs of the crate `fuzz`.
const READERS: &str = "readers";
/// Longest input in bytes: a few hundred calls.
const LONGEST: &str = "-max_len=1000";
/// Number of inputs of a target that are kept, so that all are run again in seconds.
const KEPT: usize = 40;
/// Time in s that an input may take, on a busy machine.
const SLOWEST: &str = "-timeout=60";

/// The help of the command.
pub const HELP: &str = "\
Look for calls, saved states and files that reach new code, and check the results.

Usage: cargo xtask fuzz [TARGETS] [--minutes NUMBER] [--keep]

  TARGETS             programs of the crate `fuzz`, or `readers`; everything, if none is named
  --minutes NUMBER    for how long each; otherwise 10
  --keep              fuzz nothing: keep inputs in the sources

Calls are compared with a reference, like the random calls of the tests. Found inputs go to tests/fuzz/corpus, failing ones to
tests/fuzz/artifacts; `--keep` copies a choice of the corpus into the sources, where the tests run them.

Examples:
  cargo xtask fuzz                                      ten minutes each
  cargo xtask fuzz --minutes 1 forged_states readers    some, for a minute each
  cargo xtask fuzz --keep co_simulation                 copy a choice of the corpus into the sources
It needs Linux, a nightly compiler and a tool: cargo install --locked cargo-fuzz";

/// Options of the command.
struct Fuzz {
    targets: Vec<String>,
    minutes: u64,
    keep: bool,
}

/// Reads the options.
///
/// # Errors
/// When one is unknown or is no number.
pub fn read(mut line: Parser) -> Result<Option<Work>> {
    let mut fuzz = Fuzz { targets: Vec::new(), minutes: 10, keep: false };
    while let Some(argument) = line.next()? {
        match argument {
            Short('h') | Long("help") => return Ok(None),
            Long("minutes") => {
                let text = line.value()?.string()?;
                fuzz.minutes = text.parse().with_context(|| format!("--minutes {text}: it must be a number"))?;
            }
            Long("keep") => fuzz.keep = true,
            Value(target) => fuzz.targets.push(target.string()?),
            other => return Err(other.unexpected().into()),
        }
    }
    Ok(Some(Box::new(move |workspace| fuzz.run(workspace))))
}

impl Fuzz {
    /// Fuzzes.
    ///
    /// # Errors
    /// When a target is unknown, a tool is missing, or an input fails.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let folder = workspace.root.join("tests/fuzz");
        let known = targets(&folder)?;
        let chosen = if self.targets.is_empty() { &known } else { &self.targets };
        for target in chosen {
            ensure!(known.contains(target), "`{target}` is not fuzzed; there are {}", known.join(", "));
        }
        for target in chosen {
            heading(&format!("Fuzzing {target}"));
            let [corpus, kept, artifacts] = ["corpus", "kept", "artifacts"].map(|it| folder.join(it).join(target));
            for made in [&corpus, &kept, &artifacts] {
                fs::create_dir_all(made).with_context(|| format!("cannot make {}", made.display()))?;
            }
            let mut program = program(workspace, &folder, target)?;
            if self.keep {
                keep(program, &corpus, &kept, &folder.join("corpus").join(format!("{target}_merged")))?;
            } else {
                // The slash makes a folder of it.
                program.arg(format!("-artifact_prefix={}/", artifacts.display()));
                let seconds = format!("-max_total_time={}", 60 * self.minutes);
                program.args([&seconds, LONGEST, SLOWEST, "-len_control=0"]).arg(&corpus).arg(&kept);
                process::run(&mut program)?;
            }
        }
        Ok(())
    }
}

/// Keeps, of few inputs that reach everything that is reached, the longest: the calls of a long one get further.
fn keep(mut program: Command, corpus: &Path, kept: &Path, merged: &Path) -> Result<()> {
    files::renew(merged)?;
    process::run(program.args(["-set_cover_merge=1", "-use_counters=0"]).args([merged, corpus, kept]))?;
    let mut found = Vec::new();
    for entry in fs::read_dir(merged).with_context(|| format!("cannot read {}", merged.display()))? {
        let entry = entry?;
        found.push((entry.metadata()?.len(), entry.path()));
    }
    found.sort_by(|one, other| other.cmp(one));
    files::renew(kept)?;
    for (_, file) in found.iter().take(KEPT) {
        let to = kept.join(file.file_name().context("an input without a name")?);
        files::write(&to, files::read(file)?)?;
    }
    Ok(())
}

/// The names of all targets.
fn targets(folder: &Path) -> Result<Vec<String>> {
    let metadata = process::metadata(MetadataCommand::new().manifest_path(folder.join("Cargo.toml")).no_deps())?;
    let packages = metadata.packages.iter().flat_map(|package| &package.targets);
    let programs = packages.filter(|target| target.is_bin()).map(|target| target.name.clone());
    Ok(programs.chain([READERS.to_owned()]).collect())
}

/// The program that fuzzes a target, to be given the options of libFuzzer and folders with inputs.
fn program(workspace: &Workspace, folder: &Path, target: &str) -> Result<Command> {
    if target == READERS {
        let venv = Venv::prepare(workspace, Requirements::FUZZ)?;
        wheel::install(&venv, &wheel::build(workspace, None)?)?;
        let mut python = venv.command();
        python.arg(folder.join("readers.py"));
        return Ok(python);
    }
    let mut cargo = Command::new("rustup");
    // The sanitizer has a test of its own; without it there are twice as many calls in a minute.
    cargo.args(["run", "nightly", "cargo", "fuzz", "run", "--fuzz-dir"]).arg(folder);
    cargo.args(["--sanitizer", "none", target, "--"]).current_dir(&workspace.root);
    Ok(cargo)
}
