//! `cargo xtask test --platforms`: the libraries of all platforms, built, checked, run and compared.

mod experiment;
mod machine;
mod reproduction;

use anyhow::{Context, Result, ensure};

use self::machine::Machine;
use self::reproduction::Reproduction;
use crate::build::{self, aarch64, tools, tools::Tool};
use crate::gates::{self, Reach};
use crate::library::Library;
use crate::package;
use crate::platform::Platform;
use crate::process::{self, heading};
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Runs these tests; a missing tool is an error.
///
/// # Errors
/// When a tool is missing or a test fails.
pub fn run(workspace: &Workspace) -> Result<()> {
    tools::require(missing()?)?;
    run_all(workspace)
}

/// Runs these tests, or says what they would need.
///
/// # Errors
/// When a test fails, or under CI when a tool is missing.
pub fn run_if_possible(workspace: &Workspace) -> Result<()> {
    match tools::require(missing()?) {
        Ok(()) => run_all(workspace),
        Err(problem) => process::leave_out("Other platforms", &format!("{problem:#}")),
    }
}

fn missing() -> Result<Vec<(&'static str, Vec<Tool>)>> {
    let mut missing = Vec::new();
    for platform in Platform::ALL {
        missing.push((platform.folder(), build::missing(platform)?));
    }
    missing.push(("Linux on Arm", aarch64::missing()?));
    missing.extend(Machine::ALL.map(|machine| ("running them", machine.missing())));
    Ok(missing)
}

fn run_all(workspace: &Workspace) -> Result<()> {
    Venv::prepare(workspace, Requirements::ZIG)?;
    let (libraries, arm, again) = build_all(workspace)?;
    for library in &libraries {
        library.keep(workspace)?;
    }
    heading("Refuse damaged libraries");
    for library in &libraries {
        refuse_damaged(library)?;
    }
    heading("Join the FMUs for all platforms");
    package::join(workspace, &libraries)?;

    heading("Run every model under every friction law on every processor and system");
    let experiments = experiment::all();
    let reference = Machine::Linux.run(workspace, &libraries[0].bytes, &experiments)?;
    experiment::complete(&reference)?;
    for (machine, bytes) in [(Machine::Windows, &libraries[1].bytes), (Machine::Arm, &arm)] {
        let results = machine.run(workspace, bytes, &experiments)?;
        experiment::same(machine.name(), &reference, &results)?;
    }

    heading("Compare what was built twice");
    again.compare(workspace, &libraries)
}

/// The libraries of all platforms, that of Linux on Arm, and a second one of linux64.
///
/// Two builds at a time: one alone leaves half of two processors idle, because large crates are one unit of work.
fn build_all(workspace: &Workspace) -> Result<(Vec<Library>, Vec<u8>, Reproduction)> {
    let ((arm, again), libraries) = process::both(
        || {
            let arm = aarch64::build(&workspace.inside("platform-test")).context("Linux on Arm")?;
            Ok((arm, Reproduction::build(workspace).context("linux64 in another place")?))
        },
        || build::libraries(workspace, &Platform::ALL.into()),
    )?;
    Ok((libraries, arm, again))
}

/// Gates that never close are worth nothing.
fn refuse_damaged(library: &Library) -> Result<()> {
    let platform = library.platform;
    let mut told = library.bytes.clone();
    told.extend(b"/home/ann/.cargo/registry/src");
    let mut damages = vec![("a build path", told, "holds a build path")];
    if platform == Platform::Darwin64 {
        let mut changed = library.bytes.clone();
        let middle = changed.len() / 4;
        changed[middle] ^= 1;
        damages.push(("a changed byte", changed, "was changed after signing"));
    }
    for (damage, bytes, expected) in damages {
        let verdict = gates::check(platform, Reach::Everybody, &bytes, &[]);
        let problem = verdict.err().map(|problem| problem.to_string()).unwrap_or_default();
        ensure!(problem.contains(expected), "the gates let {damage} in {platform} pass: `{problem}`");
        println!("{platform} with {damage}: refused");
    }
    Ok(())
}
