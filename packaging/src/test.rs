//! `cargo xtask test`: every check, in the order in which mistakes are cheapest to find.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::bounds;
use crate::deny;
use crate::gallery::Gallery;
use crate::library::Library;
use crate::new;
use crate::own;
use crate::package::Package;
use crate::platform_test;
use crate::playground;
use crate::process::{self, heading};
use crate::public;
use crate::sanitizer;
use crate::site;
use crate::sources_test;
use crate::stress::Stress;
use crate::valgrind;
use crate::venv::{Requirements, Venv};
use crate::workspace::Workspace;

/// Run every check: format, lints, unit tests, C-interface tests, real FMI clients and other platforms.
///
/// Takes about 35 minutes on two processors. A check whose tool is missing is left out with a message; with the variable
/// CI set that is an error, but for the address sanitizer's nightly compiler and cargo-deny, which no package manager has.
#[derive(Args)]
#[command(after_help = "\
Examples:
  cargo xtask test                 everything that the tools of this machine allow
  CI=1 cargo xtask test            everything, or an error; .ci/run installs what that needs on Debian
  cargo xtask test --times         and say how long each stage has taken
  cargo xtask test --platforms     build the libraries of all platforms, run and compare them, nothing else
  cargo xtask test --sources       compile the sources in C for all targets, run and compare them, nothing else
  cargo xtask test --sources --only cortex-m7,s390x   of them only those of some models or for some targets
  cargo xtask test --sources --fuzz 10   random calls of the sources in C for ten minutes; with --only of some models")]
pub struct Test {
    /// Say at the end when each stage began and how long it took, also after a failure.
    #[arg(long)]
    times: bool,
    /// Only build and compare the libraries of all platforms; a missing tool is an error then.
    #[arg(long)]
    platforms: bool,
    /// Only compile the sources in C for all targets, run and compare them; a missing tool is an error then.
    #[arg(long, conflicts_with = "platforms")]
    sources: bool,
    /// Of the sources in C only those of these models, or for these targets.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "sources")]
    only: Vec<String>,
    /// Only make random calls of the sources in C, of all models or of some, for so many minutes.
    #[arg(long, value_name = "MINUTES", requires = "sources", value_parser = clap::value_parser!(u64).range(1..))]
    fuzz: Option<u64>,
}

impl Test {
    /// Runs the checks; the first failure ends it.
    ///
    /// # Errors
    /// When a tool is missing or a check fails.
    pub fn run(&self, workspace: &Workspace) -> Result<()> {
        let outcome = match (self.platforms, self.sources, self.fuzz) {
            (true, ..) => platform_test::run(workspace),
            (_, true, None) => sources_test::run(workspace, &self.only),
            (_, true, Some(minutes)) => sources_test::fuzz(workspace, Duration::from_secs(60 * minutes), &self.only),
            _ => run(workspace),
        };
        if self.times {
            print_times();
        }
        outcome
    }
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
    bounds::forget(workspace)?;
    process::both(|| checks.plant(), || checks.packages(&venv))?;
    heading("Room that bounds leave");
    bounds::check(workspace, bounds::SHOWN)
}

/// What lints and documentation look at. The benchmark's rivals take longer to compile than everything else together;
/// `cargo bench` compiles them. Both with the same features: what the packages depend on is then checked once.
const FEATURES: [&str; 2] = ["--features", "importer/fmi,benchmark/calls"];

/// Tests in Python that start programs: they run beside the others, and take half of the time of all.
const PROGRAMS: [&str; 7] =
    ["examples", "pages", "studies", "system_studies", "package_cli", "package_cli_options", "package_executors"];

/// Packages whose unit tests are quick: without optimization they are compiled in a sixth of the time.
const UNITS: [&str; 6] = [
    "pneumatic-servo",
    "pneumatic-servo-fmu",
    "pneumatic-servo-packaging",
    "pneumatic-servo-playground",
    "pneumatic-servo-sources",
    "pneumatic-servo-ssp",
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
        public::check(self.workspace)?;
        heading("Unit tests");
        let packages = UNITS.map(|name| ["--package", name]).concat();
        let quick = ["test", "--profile", "quick", "--lib", "--no-default-features"];
        self.cargo(&[&quick[..], &process::FEATURES_OF_THIS, &packages].concat())?;
        heading("Library: published numbers, C interface");
        self.cargo(&["test", "--test", "*"])?;
        self.cargo(&["test", "--doc"])?;
        heading("Crates from outside: laws, valves and models of one's own");
        self.cargo(&["test", "--manifest-path", "examples/own/Cargo.toml"])?;
        new::check(self.workspace, &self.workspace.home)?;
        valgrind::check(self.workspace)?;
        sanitizer::check(self.workspace)?;
        Stress::SHORT.run()?;
        sources_test::run_if_possible(self.workspace)?;
        platform_test::run_if_possible(self.workspace)
    }

    /// Everything that is handed out, FMUs, figures, wheel and page, and then in the hands of its users.
    fn packages(&self, venv: &Venv) -> Result<()> {
        heading("Build the shared library");
        let library = Library::for_tests(self.workspace)?;
        Package::default().finish(self.workspace, &[library])?;
        own::check(self.workspace)?;
        Gallery {}.run(self.workspace)?;
        heading("Python: types of the package");
        self.python(venv, &["mypy", "--config-file", "python/pyproject.toml"])?;
        playground::check(self.workspace, venv)?;
        site::check(self.workspace)?;
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
            .env("GALLERY_FOLDER", self.workspace.gallery())
            .envs(self.bindgen.iter().map(|(name, value)| (name, value)))
    }
}

/// What the crate `fmi` needs in order to read the C headers of FMI: libclang, and the compiler's own headers.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files;
    use crate::stand_in::{Answer, StandIn, Started};

    const ALL: Test = Test { times: false, platforms: false, sources: false, only: Vec::new(), fuzz: None };

    /// What comes of it, and what is started, on a machine on which what is told these words fails.
    fn tested(test: &Test, failing: &'static str) -> Result<(String, Vec<Started>)> {
        let folder = files::scratch("test");
        let workspace = Workspace::of_a_test(&folder);
        let machine = StandIn::new(move |command| match command {
            _ if command.says(failing) => Some(Answer::Fails),
            _ => command.says("-print-file-name=include").then(|| Answer::Prints("/headers\n".to_owned())),
        });
        let (outcome, started) = machine.does(|| test.run(&workspace));
        std::fs::remove_dir_all(&folder).ok();
        Ok((outcome.map_or_else(|problem| format!("{problem:#}"), |()| String::new()), started))
    }

    /// What is cheap comes first, and a failure ends it.
    #[test]
    fn checks_end_with_the_first_failure() -> Result<()> {
        let orders = [
            ("fmt --all --check", "-print-file-name=include"),
            ("ruff format", "fmt --all --check"),
            ("ruff check", "ruff format --check"),
            ("deny --offline", "ruff check"),
        ];
        for (failing, before) in orders {
            let (problem, started) = tested(&ALL, failing)?;
            assert!(problem.contains(failing), "{problem}");
            let [.., second, last] = &started[..] else { panic!("{started:?}") };
            assert!(last.says(failing) && (second.says(before) || !cfg!(target_os = "linux")), "{started:?}");
        }
        let (_, started) = tested(&ALL, "ruff format")?;
        let format = started.iter().find(|it| it.says("fmt")).context("no format")?;
        assert_eq!(
            format.variable("BINDGEN_EXTRA_CLANG_ARGS"),
            if cfg!(target_os = "linux") { "-I/headers" } else { "" }
        );
        assert_eq!(format.folder, Some(crate::workspace::home()));
        Ok(())
    }

    /// Only the platforms, only the sources, or only random calls of them.
    #[test]
    fn one_of_the_long_checks_is_run_alone() -> Result<()> {
        let only = || vec!["Bed".to_owned()];
        for (test, expected) in [
            (Test { sources: true, only: only(), ..ALL }, "`Bed` is no model and no target"),
            (Test { sources: true, only: only(), fuzz: Some(1), ..ALL }, "`Bed` is no model;"),
            (Test { platforms: true, times: true, ..ALL }, "`rustc --print sysroot` failed"),
        ] {
            let (problem, started) = tested(&test, "--print sysroot")?;
            let is_begun = started.iter().any(|it| it.line().starts_with("cargo "));
            assert!(problem.starts_with(expected) && !is_begun, "{problem}: {started:?}");
        }
        Ok(())
    }
}
