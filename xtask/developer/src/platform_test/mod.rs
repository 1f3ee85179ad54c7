//! `cargo xtask test --platforms`: the libraries of all platforms, built, checked, run and compared.

mod experiment;
mod machine;
mod reproduction;
mod results;

use anyhow::{Context, Result, ensure};
use pneumatic_servo_packaging::build::{self, aarch64};
use pneumatic_servo_packaging::gates::{self, Reach};
use pneumatic_servo_packaging::library::Library;
use pneumatic_servo_packaging::package;
use pneumatic_servo_packaging::platform::Platform;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::tools::{self, Tool};
use pneumatic_servo_packaging::workspace::Workspace;

pub use self::experiment::of as experiments_of;
pub use self::machine::{Machine, wine};
use self::reproduction::Reproduction;
pub use self::results::same;

/// Runs these tests; a missing tool is an error.
///
/// # Errors
/// When a tool is missing or a test fails.
pub fn run(workspace: &Workspace) -> Result<()> {
    tools::require(missing(&Platform::ALL)?)?;
    let (mut libraries, (again, macos)) = process::both(
        || compared(workspace, [&workspace.inside("platform-test"), workspace], &experiment::all(experiment::WHOLE)),
        || {
            let again = Reproduction::build(workspace).context("linux64 in another place")?;
            heading("Build the shared library for darwin64");
            Ok((again, Library::for_everybody(workspace, Platform::Darwin64)?))
        },
    )?;
    libraries.push(macos);
    libraries.iter().try_for_each(|library| library.keep(workspace).map(|_| ()))?;
    heading("Refuse damaged libraries");
    libraries.iter().try_for_each(refuse_damaged)?;
    heading("Join the FMUs for all platforms");
    package::join(workspace, &libraries)?;
    heading("Compare what was built twice");
    again.compare(workspace, &libraries)
}

/// Builds, runs and compares the libraries of the platforms that can be run here over a quarter of the experiments, or names the
/// missing tools.
///
/// # Errors
/// When a test fails, or under CI when a tool is missing.
pub fn run_if_possible(workspace: &Workspace) -> Result<()> {
    match tools::require(missing(&[Platform::Linux64, Platform::Win64])?) {
        Ok(()) => {
            let others = workspace.inside("platform-test");
            let libraries = compared(workspace, [&others; 2], &experiment::all(experiment::QUARTER))?;
            heading("Refuse damaged libraries");
            libraries.iter().try_for_each(refuse_damaged)
        }
        Err(problem) => process::leave_out("Other platforms", &format!("{problem:#}")),
    }
}

/// The missing tools for building platforms, and for running the libraries that can run here.
fn missing(platforms: &[Platform]) -> Result<Vec<(&'static str, Vec<Tool>)>> {
    let mut missing = Vec::new();
    for platform in platforms {
        missing.push((platform.folder(), build::missing(*platform)?));
    }
    missing.push(("Linux on Arm", aarch64::missing()?));
    missing.extend(Machine::ALL.map(|machine| ("running them", machine.missing())));
    Ok(missing)
}

/// Builds the libraries for Linux, for Linux on Arm and for Windows, the last two in places of their own, runs and compares them;
/// returns those that FMUs hold. Two things at a time: one build alone leaves half of two processors idle, because large crates
/// are one unit of work, and so does an emulator.
fn compared(workspace: &Workspace, [on_arm, on_windows]: [&Workspace; 2], experiments: &str) -> Result<Vec<Library>> {
    let (arm, linux) =
        process::both(|| aarch64::build(on_arm).context("Linux on Arm"), || Library::for_tests(workspace))?;
    let (reference, windows) = process::both(
        || compare_processors(workspace, &linux.bytes, &arm, experiments),
        || {
            heading("Build the shared library for win64");
            Library::for_everybody(on_windows, Platform::Win64)
        },
    )?;
    let results = Machine::Windows.run(workspace, &windows.bytes, experiments)?;
    results::same(Machine::Windows.name(), &reference, &results)?;
    Ok(vec![linux, windows])
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
