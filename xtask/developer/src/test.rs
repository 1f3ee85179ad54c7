//! `cargo xtask test`: every check, in the order in which mistakes are cheapest to find.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use lexopt::Arg::{Long, Short};
use lexopt::{Parser, ValueExt};
use pneumatic_servo_packaging::build::wasm;
use pneumatic_servo_packaging::files;
use pneumatic_servo_packaging::library::Library;
use pneumatic_servo_packaging::package::Package;
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::tools;
use pneumatic_servo_packaging::venv::{Requirements, Venv};
use pneumatic_servo_packaging::workspace::{ENVIRONMENTS, Workspace};

use crate::Work;
use crate::deny;
use crate::platform_test;
use crate::playground;
use crate::quick;
use crate::sanitizer;
use crate::site;
use crate::sources_test;
use crate::valgrind;
use crate::wheel;

/// The help of the command.
pub const HELP: &str = "\
Run every check: format, lints, unit tests, C-interface tests, real FMI clients and other platforms.

Usage: cargo xtask test [OPTIONS]

  --times            say at the end when each stage began and how long it took, also after a failure
  --platforms        only build and compare the libraries of all platforms; a missing tool is an error then
  --sanitizer        only run the C interface under the address sanitizer of the nightly compiler, which valgrind does not
                     replace in full
  --sources          only compile the sources in C for all targets, run and compare them; a missing tool is an error then
  --only NAMES       of the sources in C only these models, or these targets
  --fuzz MINUTES     only make random calls of the sources in C, of all models or of some, for some minutes

A check whose tool is missing is left out with a message; with the variable CI set that is an error, but for cargo-deny, which no
package manager has. docs/testing.md says what is tested how.

Examples:
  cargo xtask test                 everything that the tools of this machine allow
  CI=1 cargo xtask test            everything, or an error; .ci/run installs what that needs on Debian
  cargo xtask test --platforms     build the libraries of all platforms, run and compare them, nothing else
  cargo xtask test --sources --only cortex-m7,s390x   the sources in C for two targets
  cargo xtask test --sources --fuzz 10   random calls of the sources in C for ten minutes; with --only of some models";

/// Part of the checks to run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Platforms,
    Sanitizer,
    Sources,
}

/// Reads the options.
///
/// # Errors
/// When one is unknown or two do not fit together.
pub fn read(mut line: Parser) -> Result<Option<Work>> {
    let (mut times, mut parts, mut only, mut minutes) = (false, Vec::new(), Vec::new(), None);
    while let Some(argument) = line.next()? {
        match argument {
            Short('h') | Long("help") => return Ok(None),
            Long("times") => times = true,
            Long("platforms") => parts.push(Part::Platforms),
            Long("sanitizer") => parts.push(Part::Sanitizer),
            Long("sources") => parts.push(Part::Sources),
            Long("only") => only.extend(line.value()?.string()?.split(',').map(str::to_owned)),
            Long("fuzz") => {
                let text = line.value()?.string()?;
                let number = text.parse::<u64>().ok().filter(|number| *number > 0);
                minutes = Some(number.with_context(|| format!("--fuzz {text}: it must be a number of minutes"))?);
            }
            other => return Err(other.unexpected().into()),
        }
    }
    ensure!(parts.len() < 2, "one of --platforms, --sanitizer and --sources at a time");
    let part = parts.pop();
    let is_of_sources = part == Some(Part::Sources);
    ensure!(is_of_sources || only.is_empty() && minutes.is_none(), "--only and --fuzz are options of --sources");
    Ok(Some(Box::new(move |workspace| {
        let outcome = match (part, minutes) {
            (Some(Part::Platforms), _) => platform_test::run(workspace),
            (Some(Part::Sanitizer), _) => sanitizer::run(workspace),
            (Some(Part::Sources), None) => sources_test::run(workspace, &only),
            (Some(Part::Sources), Some(minutes)) => {
                sources_test::fuzz(workspace, Duration::from_secs(60 * minutes), &only)
            }
            (None, _) => run(workspace),
        };
        if times {
            print_times();
        }
        outcome
    })))
}

/// Stages in the order in which they began; two run at a time.
fn print_times() {
    let sections = process::sections();
    println!("\nbegan at   took");
    for process::Section { text, begin, length } in &sections {
        println!("{:>8} {:>6}  {text}", process::minutes(*begin), process::minutes(*length));
    }
    let work = sections.iter().map(|section| section.length).sum();
    let end = sections.iter().map(|section| section.begin + section.length).max().unwrap_or_default();
    println!("{:>8} {:>6}  everything", process::minutes(end), process::minutes(work));
}

fn run(workspace: &Workspace) -> Result<()> {
    heading("Prepare the Python environment");
    let venv = Venv::prepare(workspace, Requirements::TESTS)?;
    let checks = Checks { workspace, bindgen: bindgen(&venv)? };

    heading("Format");
    checks.cargo(&["fmt", "--all", "--check"])?;

    heading("Python: format and lints");
    checks.python(&venv, &["ruff", "format", "--check"])?;
    checks.python(&venv, &["ruff", "check"])?;

    deny::check(workspace)?;

    // Compiling the plant for release is work for one processor, and so are most tests: two at a time need half as long.
    process::both(|| checks.plant(), || checks.packages(&venv)).map(|_| ())
}

/// Features of lints and documentation, the same for both, so that dependencies are checked once. The benchmark's rivals
/// take longer to compile than everything else together; `cargo bench` compiles them.
const FEATURES: [&str; 2] = ["--features", "importer/fmi,benchmark/calls"];

/// Tests in Python that start programs: they run beside the others, and take half of the time of all.
const PROGRAMS: [&str; 14] = [
    "examples",
    "export",
    "export_hosts",
    "hosts",
    "own",
    "own_laws",
    "package_cli",
    "package_cli_options",
    "package_executors",
    "package_wheel",
    "pages",
    "strict_host",
    "studies",
    "system_studies",
];

/// Runs checks in the repository.
struct Checks<'a> {
    workspace: &'a Workspace,
    bindgen: Vec<(&'static str, OsString)>,
}

impl Checks<'_> {
    /// The source, plant and C interface by themselves, what packs them, and the plant on other machines.
    fn plant(&self) -> Result<()> {
        heading("Lints");
        let all = ["--workspace", "--all-targets"];
        self.cargo(&[&["clippy"], &all[..], &FEATURES, &["--", "--deny", "warnings"]].concat())?;
        heading("Documentation");
        self.documentation()?;
        heading("Unit tests");
        let quick = ["test", "--profile", "quick", "--lib", "--bins", "--no-default-features"];
        self.cargo(&[&quick[..], &quick::FEATURES, &quick::packages()].concat())?;
        heading("Library: published numbers, C interface");
        self.cargo(&["test", "--test", "*"])?;
        self.cargo(&["test", "--package", "pneumatic-servo-fit", "--test", "*"])?;
        self.cargo(&["test", "--doc"])?;
        heading("Crates from outside: laws, valves and models of your own");
        // Without optimization their tests run as long as they compile, which takes a fraction of the time. With the feature that packs
        // one of them the plant is compiled already.
        let own = ["test", "--profile", "quick", "--manifest-path", "examples/own/Cargo.toml"];
        self.cargo(&[&own[..], &["--features", "quarter-car/package"]].concat())?;
        self.begun_crates()?;
        valgrind::check(self.workspace)?;
        sources_test::run_if_possible(self.workspace)?;
        platform_test::run_if_possible(self.workspace)
    }

    /// Everything that is handed out, FMUs, figures, wheel and page, and then in the hands of its users.
    fn packages(&self, venv: &Venv) -> Result<()> {
        heading("Build the shared library");
        let library = Library::for_tests(self.workspace)?;
        Package::default().finish(self.workspace, &[library])?;
        self.own_model(venv)?;
        self.observer()?;
        let page = playground::page_if_possible(self.workspace)?;
        wheel::install(venv, &wheel::build(self.workspace, page.as_deref())?)?;
        heading("Python: types of the package");
        self.python(venv, &["mypy", "--config-file", "python/pyproject.toml"])?;
        if let Some(page) = page {
            playground::check(self.workspace, venv, &page)?;
            site::check(self.workspace, &page)?;
        }
        heading("Import with the crate fmi");
        // With the features that the crate fmi asks of others, the plant would be optimized once more for its tables alone.
        self.cargo(&["test", "--profile", "quick", "--package", "importer", "--features", "fmi"])?;
        let programs = PROGRAMS.map(|name| format!("tests/python/test_{name}.py"));
        process::both(
            || {
                heading("Programs of examples, pages and studies, commands of the package");
                self.python(venv, &[&["pytest"], &programs.each_ref().map(String::as_str)[..]].concat())
            },
            || {
                heading("Import with FMPy");
                let others = programs.each_ref().map(|file| format!("--ignore={file}"));
                self.python(venv, &[&["pytest", "tests/python"], &others.each_ref().map(String::as_str)[..]].concat())
            },
        )?;
        Ok(())
    }

    /// Packs the model among the examples as a user does. With the tools for sources in C the FMUs have them, too, and give the bits of
    /// the library where FMPy compiles them.
    fn own_model(&self, venv: &Venv) -> Result<()> {
        heading("A model of your own: pack its FMU");
        let missing = tools::require([("the sources in C", wasm::missing()?)]);
        let (features, sources) = match missing {
            Ok(()) => ("package,pneumatic-servo-packaging/sources", Some("--sources")),
            Err(problem) => {
                process::leave_out("Sources in C of a model of your own", &format!("{problem:#}"))?;
                ("package", None)
            }
        };
        let manifest = ["--features", features, "--manifest-path", "examples/own/model/Cargo.toml"];
        let folder = self.pack_quickly(&manifest, sources)?;
        if sources.is_none() {
            return Ok(());
        }
        heading("A model of your own: compile the sources in its FMU");
        let mut python = venv.command();
        python.arg(self.workspace.python().join("compiled.py"));
        python.args(["fmu", "fmu/fmi3"].map(|of| folder.join(of).join("QuarterCar.fmu")));
        python.arg("--experiments").arg(folder.join("experiments.json"));
        process::run(python.env("PATH", venv.path()?))
    }

    /// Packs the observer, whose library is apart from that of the other FMUs.
    fn observer(&self) -> Result<()> {
        heading("The observer: pack its FMU");
        let package = ["--package", "pneumatic-servo-observer", "--features", "package"];
        self.pack_quickly(&package, None).map(|_| ())
    }

    /// Runs the program `package` of a crate, and says in which folder its FMUs are: target/own, beside those of the project. What
    /// compiles the program is the target directory of the project, where most of it is compiled already. The library is compiled
    /// without optimization, in a fifth of the time: its bits are the same, as the run shows, and what a step costs is asked elsewhere.
    fn pack_quickly(&self, of: &[&str], sources: Option<&str>) -> Result<PathBuf> {
        let folder = self.workspace.target.join("own");
        let mut cargo = process::cargo();
        cargo.args(["run", "--profile", "quick", "--example", "package"]).args(of);
        cargo.arg("--target-dir").arg(&self.workspace.target);
        cargo.arg("--").args(sources);
        cargo.env("CARGO_TARGET_DIR", &folder);
        cargo.env(ENVIRONMENTS, &self.workspace.environments);
        cargo.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0").env("CARGO_PROFILE_RELEASE_LTO", "off");
        process::run(cargo.current_dir(&self.workspace.home))?;
        Ok(folder)
    }

    /// Begins a crate of each kind in an empty folder, as a user does, and checks that all compile; the tests of the model run,
    /// while what the others are begun from has run among the examples. All are members of one workspace, with the versions of
    /// the other crates from outside: the plant is compiled once for all.
    fn begun_crates(&self) -> Result<()> {
        heading("Crates of your own, begun in an empty folder");
        let folder = self.workspace.target.join("new");
        files::renew(&folder)?;
        xtask::new::write_all(&folder, &self.workspace.home)?;
        let lock = self.workspace.home.join("examples/own/Cargo.lock");
        std::fs::copy(&lock, folder.join("Cargo.lock")).with_context(|| format!("cannot copy {}", lock.display()))?;
        let manifest = folder.join("Cargo.toml");
        files::write(
            &manifest,
            files::text(&manifest)? + "\n[profile.quick]\ninherits = \"dev\"\ndebug = false\nincremental = false\n",
        )?;
        // Also the programs that pack them.
        let check = ["check", "--workspace", "--all-targets", "--all-features"];
        for arguments in [&check[..], &["test", "--package", "own-begun-model"]] {
            let mut cargo = process::cargo();
            cargo.args(arguments).args(["--profile", "quick"]);
            cargo.arg("--target-dir").arg(&self.workspace.target).current_dir(&folder);
            process::run(&mut cargo)?;
        }
        Ok(())
    }

    fn cargo(&self, arguments: &[&str]) -> Result<()> {
        process::run(self.prepared(process::cargo().args(arguments)))
    }

    fn documentation(&self) -> Result<()> {
        let mut cargo = process::cargo();
        cargo.args(["doc", "--workspace", "--no-deps"]).args(FEATURES).env("RUSTDOCFLAGS", "--deny warnings");
        process::run(self.prepared(&mut cargo))
    }

    fn python(&self, venv: &Venv, module: &[&str]) -> Result<()> {
        process::run(self.prepared(venv.command().arg("-m").args(module)))
    }

    /// Lets a command find the repository, the FMUs and libclang.
    fn prepared<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command
            .current_dir(&self.workspace.root)
            .env("CARGO_TARGET_DIR", &self.workspace.target)
            .env("FMU_FOLDER", self.workspace.fmus())
            .envs(self.bindgen.iter().map(|(name, value)| (name, value)))
    }
}

/// Environment in which the crate `fmi` finds libclang and the compiler's own headers for the C headers of FMI.
fn bindgen(venv: &Venv) -> Result<Vec<(&'static str, OsString)>> {
    let mut variables = vec![("LIBCLANG_PATH", venv.module("clang")?.join("native").into_os_string())];
    if cfg!(target_os = "linux") {
        let mut include = OsString::from("-I");
        include.push(compiler_headers()?);
        variables.push(("BINDGEN_EXTRA_CLANG_ARGS", include));
    }
    Ok(variables)
}

fn compiler_headers() -> Result<OsString> {
    let mut gcc = Command::new("gcc");
    let answer = process::output(gcc.arg("-print-file-name=include"));
    let answer = answer.context("gcc was not found; install it (on Debian or Ubuntu: apt install gcc libc6-dev)")?;
    let folder = Path::new(answer.trim());
    if !folder.is_absolute() {
        bail!("gcc has no folder of headers; install it (on Debian or Ubuntu: apt install gcc libc6-dev)");
    }
    Ok(folder.into())
}
