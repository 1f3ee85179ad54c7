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

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::archive::Archive;
    use crate::files;
    use crate::gates::made;
    use crate::moment::Moment;
    use crate::stand_in::{Answer, StandIn, Started};

    const ENTRY: [&str; 1] = ["PyInit__native"];

    /// A wheel with files of some names, each with these bytes.
    fn write_wheel(file: &Path, names: &[&str], bytes: &[u8]) -> Result<()> {
        let mut archive = Archive::default();
        for name in names {
            archive.add(name, bytes)?;
        }
        archive.write(file, Moment::of_source(&crate::workspace::home())?)
    }

    /// What comes of it, and what is started, where Rust has standard libraries for some targets, maturin makes a wheel of a
    /// name with a module, and some programs are missing.
    fn tried(
        folder: &Path,
        targets: &[&str],
        name: &'static str,
        module: Vec<u8>,
        lacking: &[&'static str],
    ) -> (Result<Vec<String>>, Vec<Started>) {
        let workspace = Workspace::made_up(folder);
        let machine = StandIn::new(move |command| {
            if command.says("maturin build") {
                let wheel = Path::new(command.after("--out")).join(name);
                write_wheel(&wheel, &["pneumatic_servo/_native.abi3.so"], &module).expect("a wheel");
            }
            command.line().contains("platform.machine())").then(|| Answer::Prints("3.11 aarch64\n".to_owned()))
        });
        let machine = lacking
            .iter()
            .fold(machine.compiling_for(&folder.join("sysroot"), targets), |it, program| it.lacking(program));
        machine.does(|| try_out(&workspace))
    }

    const ARM: &str = "aarch64-unknown-linux-gnu";
    const WINDOWS: &str = "x86_64-pc-windows-gnu";
    const WHEEL: &str = "pneumatic_servo-0.1.0-cp310-abi3-manylinux2014_aarch64.manylinux_2_17_aarch64.whl";

    /// Without its tools nothing is built, and each wheel is named with what it lacks.
    #[test]
    fn wheels_whose_tools_are_missing_are_left_out() -> Result<()> {
        let folder = files::scratch("elsewhere-missing");
        let (left, started) = tried(&folder, &[], "", Vec::new(), &["x86_64-w64-mingw32-gcc"]);
        let left = left?;
        assert_eq!(left.len(), 3, "{left:?}");
        assert!(
            left[0].contains("macOS")
                && left[1].contains(&format!("Linux on aarch64: Rust's standard library for {ARM}"))
        );
        assert!(left[2].contains(WINDOWS) && left[2].contains("x86_64-w64-mingw32-gcc (apt install"), "{left:?}");
        assert!(started.is_empty(), "{started:?}");
        // The linker of Windows is asked for there only.
        let (left, started) = tried(&folder, &[WINDOWS], "", Vec::new(), &["x86_64-w64-mingw32-gcc"]);
        let left = left?;
        assert!(
            left[1].contains(ARM) && !left[1].contains("mingw") && !left[2].contains("standard library"),
            "{left:?}"
        );
        assert!(started.is_empty(), "{started:?}");
        Ok(fs::remove_dir_all(&folder)?)
    }

    /// It is built by Zig for old systems, looked at, installed for its processor and run there.
    #[test]
    fn wheel_for_another_processor_is_built_and_run() -> Result<()> {
        let folder = files::scratch("elsewhere-arm");
        let module = made::linux_with(made::LINUX_ARM, ENTRY);
        let (left, started) = tried(&folder, &[ARM], WHEEL, module.clone(), &[]);
        assert_eq!(left?.len(), 2, "macOS and Windows");
        let of = |words: &str| started.iter().position(|it| it.says(words)).with_context(|| words.to_owned());
        let (built, installed) = (of("maturin build")?, of("pip install --quiet")?);
        let run =
            started.iter().position(|it| it.line().ends_with("wheel") && it.line().contains("pneumatic_servo as ps"));
        let run = run.context("the plant is not run")?;
        assert!(built < installed && installed < run);
        assert!(
            started[built].says(&format!("--target {ARM}")) && started[built].says("--compatibility manylinux_2_17")
        );
        let pip = &started[installed];
        assert!(pip.says("--python-version 3.11") && pip.says("--platform manylinux2014_aarch64"), "{pip:?}");
        let packages = PathBuf::from(pip.after("--target"));
        assert!(packages.starts_with(folder.join("target")) && pip.line().ends_with(WHEEL), "{pip:?}");
        let program = &started[run];
        assert_eq!(program.path, Path::new("/machine/first/aarch64-linux-gnu-python3"));
        assert_eq!((program.folder.as_ref(), Path::new(program.variable("PYTHONPATH"))), (Some(&packages), &*packages));

        let (left, started) = tried(&folder, &[ARM], WHEEL, module, &["aarch64-linux-gnu-python3"]);
        assert!(left?[1].ends_with("was not run: aarch64-linux-gnu-python3 is missing (.ci/pythons)"));
        assert!(
            started.iter().any(|it| it.says("maturin build")) && !started.iter().any(|it| it.says("--target packages"))
        );
        Ok(fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn wheel_that_is_not_what_it_should_be_is_refused() -> Result<()> {
        let folder = files::scratch("elsewhere-refused");
        let arm = made::linux_with(made::LINUX_ARM, ENTRY);
        let problem = |name, module: &[u8]| {
            let (outcome, started) = tried(&folder, &[ARM], name, module.to_vec(), &[]);
            assert!(!started.iter().any(|it| it.says("pip install --quiet")), "{started:?}");
            outcome.map_or_else(|problem| format!("{problem:#}"), |left| left.join(""))
        };
        let here = "pneumatic_servo-0.1.0-cp310-abi3-linux_x86_64.whl";
        assert!(problem(here, &arm).starts_with(&format!("{here} does not end with manylinux2014_aarch64")));
        let other = made::linux_with(made::LINUX_INTEL, ENTRY);
        assert!(problem(WHEEL, &other).contains("it is for x86_64, not for aarch64"));
        Ok(fs::remove_dir_all(&folder)?)
    }

    /// Its types lie beside it.
    #[test]
    fn compiled_part_of_a_wheel_is_found() -> Result<()> {
        let folder = files::scratch("elsewhere-module");
        let file = folder.join("a.whl");
        let names = ["pneumatic_servo/__init__.py", "pneumatic_servo/_native.abi3.so"];
        write_wheel(&file, &names, b"module")?;
        assert_eq!(module(&file)?, b"module");
        write_wheel(&file, &["pneumatic_servo/__init__.py", "pneumatic_servo/_native.pyi"], b"types")?;
        assert!(module(&file).is_err_and(|error| error.to_string().ends_with("has no compiled part")));
        assert!(module(&folder.join("none")).is_err());
        Ok(fs::remove_dir_all(&folder)?)
    }
}
