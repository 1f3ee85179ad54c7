//! `cargo xtask test --platforms`: the libraries of all platforms, built, checked, run and compared.

mod experiment;
mod machine;
mod reproduction;
mod results;

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
    Built::tested(workspace)?.join(workspace)
}

/// Builds and tests the libraries of all platforms, or says what that would need.
///
/// # Errors
/// When a test fails, or under CI when a tool is missing.
pub fn run_if_possible(workspace: &Workspace) -> Result<Option<Built>> {
    match tools::require(missing()?) {
        Ok(()) => Built::tested(workspace).map(Some),
        Err(problem) => process::leave_out("Other platforms", &format!("{problem:#}")).map(|()| None),
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

/// What these tests are about.
pub struct Built {
    libraries: Vec<Library>,
    /// The library for Linux on Arm.
    arm: Vec<u8>,
    /// A second library for linux64.
    again: Reproduction,
}

impl Built {
    /// Builds the libraries, and runs and compares them.
    fn tested(workspace: &Workspace) -> Result<Self> {
        let built = Self::new(workspace)?;
        for library in &built.libraries {
            library.keep(workspace)?;
        }
        heading("Refuse damaged libraries");
        for library in &built.libraries {
            refuse_damaged(library)?;
        }
        heading("Run every model under every friction law on every processor and system");
        built.compare_machines(workspace)?;
        Ok(built)
    }

    /// Builds two libraries at a time: one alone leaves half of two processors idle, because large crates are one unit of
    /// work.
    fn new(workspace: &Workspace) -> Result<Self> {
        Venv::prepare(workspace, Requirements::ZIG)?;
        let ((arm, again), libraries) = process::both(
            || {
                let arm = aarch64::build(&workspace.inside("platform-test")).context("Linux on Arm")?;
                Ok((arm, Reproduction::build(workspace).context("linux64 in another place")?))
            },
            || build::libraries(workspace, &Platform::ALL.into()),
        )?;
        Ok(Self { libraries, arm, again })
    }

    fn compare_machines(&self, workspace: &Workspace) -> Result<()> {
        let experiments = experiment::all();
        let reference = Machine::Linux.run(workspace, &self.libraries[0].bytes, &experiments)?;
        results::complete(&experiments, &reference)?;
        results::versions_agree(&reference)?;
        for (machine, bytes) in [(Machine::Windows, &self.libraries[1].bytes), (Machine::Arm, &self.arm)] {
            let found = machine.run(workspace, bytes, &experiments)?;
            results::same(machine.name(), &reference, &found)?;
        }
        Ok(())
    }

    /// Leaves FMUs for all platforms in place of those for this one, and compares what was built twice.
    ///
    /// # Errors
    /// When something cannot be written, or differs.
    pub fn join(&self, workspace: &Workspace) -> Result<()> {
        heading("Join the FMUs for all platforms");
        package::join(workspace, &self.libraries)?;
        heading("Compare what was built twice");
        self.again.compare(workspace, &self.libraries)
    }
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
