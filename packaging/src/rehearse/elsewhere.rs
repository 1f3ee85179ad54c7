//! Wheels for other systems and processors: built here, looked at, and run where an interpreter for them is at hand.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::PROGRAM;
use crate::build::toolchain::Target;
use crate::gates;
use crate::platform::Platform;
use crate::process;
use crate::tools::Tool;
use crate::venv::{Requirements, Venv};
use crate::wheel;
use crate::workspace::Workspace;

/// A wheel that is not for this machine.
struct Elsewhere {
    /// What it is called.
    name: &'static str,
    /// What maturin builds for, with the standard library of Rust for it.
    target: &'static str,
    platform: Platform,
    processors: &'static [&'static str],
    /// What the name of the wheel must end with.
    tag: &'static str,
    /// The interpreter that runs it here, if there can be one: `.ci/pythons` makes it.
    interpreter: Option<&'static str>,
}

const ALL: [Elsewhere; 2] = [
    Elsewhere {
        name: "Linux on aarch64",
        target: "aarch64-unknown-linux-gnu",
        platform: Platform::Linux64,
        processors: &["aarch64"],
        tag: "manylinux2014_aarch64.manylinux_2_17_aarch64.whl",
        interpreter: Some("aarch64-linux-gnu-python3"),
    },
    Elsewhere {
        name: "Windows",
        target: "x86_64-pc-windows-gnu",
        platform: Platform::Win64,
        processors: &["x86_64"],
        tag: "win_amd64.whl",
        interpreter: None,
    },
];

/// Builds the wheels whose tools are there, and returns what was left out. It is told of the wheel for this machine, whose
/// FMUs and page they hold, too.
///
/// # Errors
/// When a wheel cannot be built, is not what it should be, or does not run.
pub fn try_out(workspace: &Workspace) -> Result<Vec<String>> {
    // Linked by Zig it would export more than its entry, and need libraries that no Mac need have.
    let mut left = vec!["the wheel for macOS, which the workflow builds on a Mac".to_owned()];
    for elsewhere in &ALL {
        let missing = elsewhere.missing()?;
        if !missing.is_empty() {
            let missing: Vec<_> = missing.iter().map(Tool::to_string).collect();
            left.push(format!("the wheel for {}: {}", elsewhere.name, missing.join(", ")));
            continue;
        }
        let folder = workspace.target.join("rehearsal").join(elsewhere.target);
        let (toolchain, _) = Target::find(elsewhere.target, elsewhere.target)?.found()?;
        let wheel = wheel::build_for(workspace, &toolchain, elsewhere.target, &folder.join("wheel"))?;
        let name = wheel.file_name().unwrap_or_default().to_string_lossy();
        ensure!(name.ends_with(elsewhere.tag), "{name} does not end with {}", elsewhere.tag);
        let module = module(&wheel)?;
        println!("{name}: {}", gates::check_module(elsewhere.platform, elsewhere.processors, &module)?);
        match elsewhere.interpreter.map(|program| (program, process::find(program))) {
            Some((_, Some(python))) => run(workspace, &python, &wheel, &folder.join("packages"))?,
            Some((program, None)) => {
                left.push(format!("the wheel for {} was not run: {program} is missing (.ci/pythons)", elsewhere.name));
            }
            None => left.push(format!("the wheel for {} was looked at, not run", elsewhere.name)),
        }
    }
    Ok(left)
}

impl Elsewhere {
    fn missing(&self) -> Result<Vec<Tool>> {
        let std = Target::find(self.target, self.target)?.missing();
        let linker = (self.platform == Platform::Win64)
            .then(|| Tool::unless_found("x86_64-w64-mingw32-gcc", "gcc-mingw-w64-x86-64-posix"));
        Ok(std.into_iter().chain(linker.flatten()).collect())
    }
}

/// The compiled part of a wheel.
fn module(wheel: &Path) -> Result<Vec<u8>> {
    let file = fs::File::open(wheel).with_context(|| format!("cannot open {}", wheel.display()))?;
    let mut archive = zip::ZipArchive::new(file)?;
    let mut module = None;
    for name in archive.file_names() {
        let name = name?;
        if name.starts_with("pneumatic_servo/_native.") && !name.ends_with(".pyi") {
            module = Some(name.into_owned());
        }
    }
    let name = module.with_context(|| format!("{} has no compiled part", wheel.display()))?;
    let mut bytes = Vec::new();
    archive.by_name(&name)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Installs a wheel for another processor, with what it asks for, into a folder, and runs the plant. The pip that does so
/// is of this machine: an emulated interpreter starts no programs.
fn run(workspace: &Workspace, python: &Path, wheel: &Path, packages: &Path) -> Result<()> {
    let ask = "import sys, platform; print('%d.%d' % sys.version_info[:2], platform.machine())";
    let answer = process::output(Command::new(python).args(["-c", ask]))?;
    let (version, machine) = answer.trim().split_once(' ').context("the interpreter does not tell its version")?;
    if packages.exists() {
        fs::remove_dir_all(packages).with_context(|| format!("cannot remove the old {}", packages.display()))?;
    }
    let mut pip = Venv::prepare(workspace, Requirements::ZIG)?.command();
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:"]);
    pip.args(["--implementation", "cp", "--python-version", version]);
    // From old to new: packages are built for the oldest glibc they can run with.
    for system in ["manylinux2014", "manylinux_2_17", "manylinux_2_27", "manylinux_2_28"] {
        pip.args(["--platform", &format!("{system}_{machine}")]);
    }
    process::run(pip.arg("--target").arg(packages).arg(wheel))?;
    let mut program = Command::new(python);
    program.args(["-c", PROGRAM, "wheel"]).current_dir(packages);
    process::run(program.env("PYTHONPATH", packages).env("PYTHONNOUSERSITE", "1").env("MPLBACKEND", "Agg"))
}
