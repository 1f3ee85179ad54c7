//! `cargo xtask fuzz`: looks for inputs that reach new places of the source.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_metadata::MetadataCommand;
use clap::Args;

use crate::files;
use crate::process::{self, heading};
use crate::venv::{Requirements, Venv};
use crate::wheel;
use crate::workspace::Workspace;

/// The readers of files of the Python package; what else is fuzzed is a program of the crate `fuzz`.
const READERS: &str = "readers";
/// Longest input in bytes: a few hundred calls.
const LONGEST: &str = "-max_len=1000";
/// Number of inputs of a target that are kept, so that all are run again in seconds.
const KEPT: usize = 40;
/// Time in s that an input may take, on a busy machine.
const SLOWEST: &str = "-timeout=60";

/// Look for calls, saved states and files that reach new places of the source, and check what they do.
///
/// Calls are compared with a reference, as those of the tests are that draw them at random. What is found is gathered in
/// fuzz/corpus, and an input that fails in fuzz/artifacts; `--keep` takes some of what is gathered into the sources, where the
/// tests run them.
#[derive(Args)]
#[command(after_help = "\
Examples:
  cargo xtask fuzz                                      ten minutes each
  cargo xtask fuzz --minutes 1 forged_states readers    some, for a minute each
  cargo xtask fuzz --keep co_simulation                 take some of what was found into the sources
It needs Linux, a nightly compiler and a tool: cargo install --locked cargo-fuzz")]
pub struct Fuzz {
    /// What is fuzzed: programs of the crate `fuzz`, or `readers`; everything, if none is named.
    targets: Vec<String>,
    /// For how long each, in minutes.
    #[arg(long, default_value_t = 10)]
    minutes: u64,
    /// Fuzz nothing: keep inputs in the sources.
    #[arg(long)]
    keep: bool,
}

impl Fuzz {
    /// Fuzzes.
    ///
    /// # Errors
    /// When a target is unknown, a tool is missing, or an input fails.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let folder = workspace.root.join("fuzz");
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
        wheel::install(&venv, &wheel::build(workspace)?)?;
        let mut python = venv.command();
        python.arg(folder.join("readers.py"));
        return Ok(python);
    }
    let mut cargo = Command::new("rustup");
    // The sanitizer has a test of its own; without it there are twice as many calls in a minute.
    cargo.args(["run", "nightly", "cargo", "fuzz", "run", "--sanitizer", "none", target, "--"]);
    cargo.current_dir(folder);
    Ok(cargo)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stand_in::{self, Answer, StandIn, Started};

    /// A workspace whose crate `fuzz` has two programs, and what is started there for some options.
    fn fuzzed(folder: &Path, options: &Fuzz) -> (Result<()>, Vec<Started>) {
        let root = folder.to_owned();
        let workspace = Workspace { root: root.clone(), ..Workspace::of_a_test(&root.join("target")) };
        let machine = StandIn::new(move |command| match command {
            _ if command.says("metadata") => {
                Some(stand_in::metadata(&root, &root, &[("calls", "0.1.0", "fuzz"), ("states", "0.1.0", "fuzz")]))
            }
            _ if command.says("fuzz run fails") => Some(Answer::Fails),
            // The one that the readers are in.
            _ => stand_in::wheel(command),
        });
        machine.lacking("npm").does(|| options.run(&workspace))
    }

    fn options(targets: &[&str]) -> Fuzz {
        Fuzz { targets: targets.iter().map(|it| (*it).to_owned()).collect(), minutes: 3, keep: false }
    }

    /// Each target in its turn, for so long, from what was found and what is kept; what fails is left where it is looked for.
    #[test]
    fn targets_are_fuzzed_for_their_time() -> Result<()> {
        let folder = files::scratch("fuzz");
        files::write(&folder.join("target/fmu/Model.fmu"), "")?;
        let (outcome, started) = fuzzed(&folder, &options(&[]));
        outcome?;
        let fuzzing: Vec<_> = started.iter().filter(|it| it.says("-max_total_time=180")).collect();
        let [calls, states, readers] = &fuzzing[..] else { panic!("{started:?}") };
        assert!(calls.says("fuzz run --sanitizer none calls") && states.says("fuzz run --sanitizer none states"));
        assert!(readers.line().starts_with("python ") && readers.line().contains("fuzz/readers.py"), "{readers:?}");
        let wheel = started.iter().position(|it| it.says("pip install --quiet") && it.line().ends_with("a.whl"));
        assert!(wheel.is_some_and(|place| started[place + 1].says("-max_total_time=180")), "{started:?}");
        for (command, name) in [(calls, "calls"), (states, "states"), (readers, "readers")] {
            let [corpus, kept] = ["corpus", "kept"].map(|it| folder.join("fuzz").join(it).join(name));
            assert!(command.line().ends_with(&format!("{} {}", corpus.display(), kept.display())), "{command:?}");
            assert!(corpus.is_dir() && kept.is_dir());
            let artifacts = folder.join("fuzz/artifacts").join(name);
            assert!(artifacts.is_dir() && command.says(&format!("-artifact_prefix={}/", artifacts.display())));
        }
        let (outcome, started) = fuzzed(&folder, &options(&["states"]));
        assert!(outcome.is_ok() && started.len() == 1, "{started:?}");
        let (outcome, started) = fuzzed(&folder, &Fuzz { keep: true, ..options(&["states"]) });
        assert!(outcome.is_ok() && started.len() == 1 && started[0].says("-set_cover_merge=1"), "{started:?}");
        Ok(fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn what_is_not_fuzzed_is_refused_with_what_is() -> Result<()> {
        let folder = files::scratch("fuzz-unknown");
        let (outcome, started) = fuzzed(&folder, &options(&["calls", "cells"]));
        let problem = outcome.map_err(|error| error.to_string());
        assert_eq!(problem, Err("`cells` is not fuzzed; there are calls, states, readers".to_owned()));
        assert!(started.is_empty() && !folder.join("fuzz").exists());
        Ok(())
    }

    /// The program leaves inputs in the first folder that it is given.
    #[test]
    fn longest_of_what_reaches_everything_is_kept_in_place_of_what_was() -> Result<()> {
        let folder = files::scratch("kept");
        let [corpus, kept, merged] = ["corpus", "kept", "merged"].map(|it| folder.join(it));
        for made in [&corpus, &kept] {
            files::renew(made)?;
        }
        files::write(&kept.join("old"), "old")?;
        let machine = StandIn::new(|command| {
            for length in 1..=KEPT + 2 {
                stand_in::writes(Path::new(&command.arguments[2]).join(format!("input{length}")), vec![0; length]);
            }
            None
        });
        machine.does(|| keep(Command::new("fuzzer"), &corpus, &kept, &merged)).0?;
        let lengths = |entry: std::io::Result<fs::DirEntry>| Ok(entry?.metadata()?.len());
        let mut found = fs::read_dir(&kept)?.map(lengths).collect::<Result<Vec<_>>>()?;
        found.sort_unstable();
        assert_eq!(found, (3..=KEPT as u64 + 2).collect::<Vec<_>>());
        fs::remove_dir_all(&folder)?;
        Ok(())
    }
}
