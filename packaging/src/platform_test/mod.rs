//! `cargo xtask test --platforms`: the libraries of all platforms, built, checked, run and compared.

mod experiment;
mod machine;
mod reproduction;
mod results;

use anyhow::{Context, Result, ensure};

pub use self::experiment::of as experiments_of;
pub use self::machine::{Machine, wine};
use self::reproduction::Reproduction;
pub use self::results::same;
use crate::build::{self, aarch64};
use crate::gates::{self, Reach};
use crate::libraries;
use crate::library::Library;
use crate::package;
use crate::platform::Platform;
use crate::process::{self, heading};
use crate::tools::{self, Tool};
use crate::workspace::Workspace;

/// Runs these tests; a missing tool is an error.
///
/// # Errors
/// When a tool is missing or a test fails.
pub fn run(workspace: &Workspace) -> Result<()> {
    tools::require(missing(&Platform::ALL)?)?;
    let (mut libraries, (again, macos)) = process::both(
        || compared(workspace),
        || {
            let again = Reproduction::build(workspace).context("linux64 in another place")?;
            Ok((again, libraries(workspace, [Platform::Darwin64])?))
        },
    )?;
    libraries.extend(macos);
    heading("Refuse damaged libraries");
    libraries.iter().try_for_each(refuse_damaged)?;
    heading("Join the FMUs for all platforms");
    package::join(workspace, &libraries)?;
    heading("Compare what was built twice");
    again.compare(workspace, &libraries)
}

/// Builds, runs and compares the libraries of the platforms that can be run here, or says what that would need.
///
/// # Errors
/// When a test fails, or under CI when a tool is missing.
pub fn run_if_possible(workspace: &Workspace) -> Result<()> {
    match tools::require(missing(&[Platform::Linux64, Platform::Win64])?) {
        Ok(()) => {
            let libraries = compared(workspace)?;
            heading("Refuse damaged libraries");
            libraries.iter().try_for_each(refuse_damaged)
        }
        Err(problem) => process::leave_out("Other platforms", &format!("{problem:#}")),
    }
}

/// The tools that are missing for building platforms, and for running what can be run here.
fn missing(platforms: &[Platform]) -> Result<Vec<(&'static str, Vec<Tool>)>> {
    let mut missing = Vec::new();
    for platform in platforms {
        missing.push((platform.folder(), build::missing(*platform)?));
    }
    missing.push(("Linux on Arm", aarch64::missing()?));
    missing.extend(Machine::ALL.map(|machine| ("running them", machine.missing())));
    Ok(missing)
}

/// Builds the libraries for Linux, for Linux on Arm and for Windows, runs and compares them; returns those that FMUs hold. Two
/// things at a time: one build alone leaves half of two processors idle, because large crates are one unit of work, and so
/// does an emulator.
fn compared(workspace: &Workspace) -> Result<Vec<Library>> {
    let experiments = experiment::all();
    let (arm, mut built) = process::both(
        || aarch64::build(&workspace.inside("platform-test")).context("Linux on Arm"),
        || libraries(workspace, [Platform::Linux64]),
    )?;
    let (reference, windows) = process::both(
        || compare_processors(workspace, &built[0].bytes, &arm, &experiments),
        || libraries(workspace, [Platform::Win64]),
    )?;
    let results = Machine::Windows.run(workspace, &windows[0].bytes, &experiments)?;
    results::same(Machine::Windows.name(), &reference, &results)?;
    built.extend(windows);
    Ok(built)
}

/// Builds the libraries of platforms, in their order, and keeps them.
fn libraries<const N: usize>(workspace: &Workspace, platforms: [Platform; N]) -> Result<Vec<Library>> {
    let libraries = libraries::build(workspace, &platforms.into())?;
    libraries.iter().try_for_each(|library| library.keep(workspace).map(|_| ()))?;
    Ok(libraries)
}

/// Runs everything here and on the other processor, and returns the results.
fn compare_processors(workspace: &Workspace, linux: &[u8], arm: &[u8], experiments: &str) -> Result<String> {
    heading("Run every model under every friction law on every processor and system");
    let reference = Machine::Linux.run(workspace, linux, experiments)?;
    results::complete(experiments, &reference)?;
    results::versions_agree(&reference)?;
    results::same(Machine::Arm.name(), &reference, &Machine::Arm.run(workspace, arm, experiments)?)?;
    Ok(reference)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files;
    use crate::gates::made;
    use crate::stand_in::{Answer, StandIn};

    /// Everything that is missing is named before anything is built; that is an error under CI and for who asks for it.
    #[test]
    fn what_is_missing_for_other_platforms_is_named() {
        let folder = files::scratch("platforms");
        let workspace = Workspace::of_a_test(&folder);
        let machine = || StandIn::new(|_| None).compiling_for(&folder, &[]).lacking("qemu-aarch64").lacking("gcc");
        assert!(machine().does(|| run_if_possible(&workspace)).0.is_ok());
        for outcome in
            [machine().does(|| run(&workspace)).0, machine().with("CI", "1").does(|| run_if_possible(&workspace)).0]
        {
            let problem = outcome.map_or_else(|problem| problem.to_string(), |()| String::new());
            for wanted in [
                "for linux64: ",
                "for win64: ",
                "for Linux on Arm: ",
                "for running them: qemu-aarch64",
                "for running them: gcc",
            ] {
                assert!(problem.contains(wanted), "{wanted} is not in {problem}");
            }
        }
    }

    /// Every bit on Arm is that on Linux.
    #[test]
    fn results_of_another_processor_are_compared() -> Result<()> {
        let folder = files::scratch("processors");
        let workspace = Workspace::of_a_test(&folder);
        const RESULTS: &str = "run fmi2 A\n0 1\nrun fmi3 A\n0 1\ndone\n";
        let compare = |of_arm: &'static str| {
            let machine = StandIn::new(move |command| {
                let results = if command.line().starts_with("qemu-aarch64") { of_arm } else { RESULTS };
                command.says("./library.so").then(|| Answer::Prints(results.to_owned()))
            });
            let experiments = "run fmi2 A\nrun fmi3 A\n";
            machine.does(|| compare_processors(&workspace, b"linux", b"arm", experiments)).0
        };
        assert_eq!(compare(RESULTS)?, RESULTS);
        let problem = compare("run fmi2 A\n0 2\n").map_err(|problem| problem.to_string());
        assert!(problem.is_err_and(|text| text.starts_with("Linux on Arm under QEMU departs from linux64 in fmi2 A")));
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    /// The gates close for a path in a library.
    #[test]
    fn damaged_libraries_are_refused() {
        let library = |platform, bytes| Library { platform, architectures: Default::default(), bytes };
        assert!(refuse_damaged(&library(Platform::Linux64, made::linux())).is_ok());
        // What is no library is refused for another reason.
        assert!(refuse_damaged(&library(Platform::Linux64, vec![1, 2, 3])).is_err());
    }
}
