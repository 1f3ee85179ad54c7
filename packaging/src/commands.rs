//! Command lines for packing FMUs: `package`, `build` and `join`.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::process::ExitCode;
use std::str::FromStr;

use anyhow::{Context, Result, ensure};
use lexopt::Arg::{Long, Short};
use lexopt::{Parser, ValueExt};

use crate::library::{self, Library};
use crate::lock;
use crate::machine::Machine;
use crate::package::{self, Package};
use crate::platform::{Binary, Platform, Platforms};
use crate::workspace::Workspace;

/// Help of the arguments of `package`.
const PACKAGE: &str = "\
  --platforms NAMES         for linux64,win64,darwin64 or all; otherwise for machines like this one
  --binary PLATFORM=PATH    a library that was built elsewhere, taken instead of building one
  --sources[=small|full]    add sources in C, for any other target: small, or larger and faster ones
  --model NAME              pack this model alone
  --set FILE.ssv            besides, FMUs of a machine of your own: of the model, the first one unless it is named, that
                            start with these values
  --name NAME               of the machine; otherwise that of the file
  --preset NAME             variables of the machine: all (otherwise), rig or minimal
  --inputs, --outputs, --parameters NAME,...
                            variables of the machine, by name";

/// The help of a command of `cargo xtask`, or of all of them.
fn help(command: &str) -> String {
    match command {
        "package" => format!(
            "Build the FMUs and the SSP, validate them and run the default experiment of each.\n\n\
             Usage: cargo xtask package [OPTIONS]\n\n{PACKAGE}\n\n\
             Results are in target/fmu: an FMU per model, its results as CSV and its figure, and the SSP; in target/fmu/fmi3 \
             the same\nFMUs for FMI 3.0. Other platforms: docs/platforms.md; sources in C: docs/target.md."
        ),
        "build" => "Build shared libraries, the first half of `package`; they are left in target/binaries.\n\n\
             Usage: cargo xtask build --platforms NAMES\n\n  --platforms NAMES    linux64,win64,darwin64 or all"
            .to_owned(),
        _ => "Put shared libraries that are built into the FMUs, the second half of `package`.\n\n\
             Usage: cargo xtask join [--platforms NAMES] [--binary PLATFORM=PATH]...\n\n  \
             --platforms NAMES         platforms whose libraries are in target/binaries\n  \
             --binary PLATFORM=PATH    a library that was built elsewhere, from the same source"
            .to_owned(),
    }
}

/// The names of the commands.
pub const NAMES: [&str; 3] = ["package", "build", "join"];

/// Arguments of a command.
#[derive(Debug, Default, PartialEq)]
pub struct Options {
    /// For which platforms.
    pub platforms: Option<Platforms>,
    /// Libraries that were built elsewhere.
    pub binaries: Vec<Binary>,
    /// Size of sources in C, if there are to be any: `small` or `full`.
    pub sources: Option<String>,
    /// The one model to be packed.
    pub model: Option<String>,
    /// The file of a machine of the user's.
    pub set: Option<String>,
    /// What is told of it.
    pub machine: Machine,
}

/// Request of a command line.
#[derive(Debug, PartialEq)]
pub enum Asked {
    /// The help.
    Help,
    /// To be done with these options.
    Do(Box<Options>),
}

impl Options {
    /// Reads a command line behind the name of the command.
    ///
    /// # Errors
    /// Names the argument that is unknown, without its value or wrong.
    pub fn read(arguments: impl IntoIterator<Item = OsString>) -> Result<Asked> {
        let mut parser = Parser::from_args(arguments);
        let mut options = Self::default();
        while let Some(argument) = parser.next()? {
            match argument {
                Short('h') | Long("help") => return Ok(Asked::Help),
                Long("platforms") => options.platforms = Some(value(&mut parser, "--platforms")?),
                Long("binary") => options.binaries.push(value(&mut parser, "--binary")?),
                Long("sources") => {
                    let size = parser.optional_value().map(|size| size.string()).transpose()?;
                    options.sources = Some(size.unwrap_or_else(|| "small".to_owned()));
                }
                Long("model") => options.model = Some(parser.value()?.string()?),
                Long("set") => options.set = Some(parser.value()?.string()?),
                Long("name") => options.machine.name = Some(parser.value()?.string()?),
                Long("preset") => options.machine.preset = Some(parser.value()?.string()?),
                Long("inputs") => options.machine.inputs = Some(names(&parser.value()?.string()?)),
                Long("outputs") => options.machine.outputs = Some(names(&parser.value()?.string()?)),
                Long("parameters") => options.machine.parameters = Some(names(&parser.value()?.string()?)),
                other => return Err(other.unexpected().into()),
            }
        }
        Ok(Asked::Do(Box::new(options)))
    }

    /// The options of `package`.
    ///
    /// # Errors
    /// When this program cannot make the requested sources, or their size is unknown.
    pub fn package(self) -> Result<Package> {
        let Self { platforms, binaries, sources, model, set, machine } = self;
        ensure!(set.is_some() || machine == Machine::default(), "a machine needs its values: --set FILE.ssv");
        let machine = set.map(|file| Machine { file: file.into(), ..machine });
        let is_possible = sources.is_none() || cfg!(feature = "sources");
        ensure!(is_possible, "--sources needs the feature `sources` of pneumatic-servo-packaging");
        Ok(Package { platforms, binaries, sources: sources.as_deref().map(str::parse).transpose()?, model, machine })
    }
}

/// Names with commas between them.
fn names(list: &str) -> Vec<String> {
    list.split(',').map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect()
}

/// The value behind an argument.
fn value<T: FromStr<Err = anyhow::Error>>(parser: &mut Parser, name: &str) -> Result<T> {
    let text = parser.value()?.string()?;
    text.parse().with_context(|| format!("{name} {text}"))
}

/// Does a command of `cargo xtask` for the FMUs of the project.
pub fn run(command: &str, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    match Options::read(arguments).and_then(|asked| planned(command, asked)) {
        Ok(None) => {
            println!("{}", help(command));
            ExitCode::SUCCESS
        }
        Ok(Some(work)) => ended(alone(work)),
        Err(problem) => misspelt(&problem, &format!("cargo xtask {command} --help")),
    }
}

/// Does something in the workspace of the project once no other command works in it.
fn alone(work: Work) -> Result<()> {
    let workspace = Workspace::of_the_project()?;
    let _alone = lock::hold(&workspace.target)?;
    work(&workspace)
}

/// Work to be done in a workspace.
type Work = Box<dyn FnOnce(&Workspace) -> Result<()>>;

/// Work of a command, or nothing where its help is asked for.
fn planned(command: &str, asked: Asked) -> Result<Option<Work>> {
    let Asked::Do(options) = asked else { return Ok(None) };
    if command == "package" {
        let package = options.package()?;
        return Ok(Some(Box::new(move |workspace| package.run(workspace))));
    }
    ensure!(options.sources.is_none(), "--sources is an option of `package`");
    ensure!(options.model.is_none(), "--model is an option of `package`");
    ensure!(
        options.set.is_none() && options.machine == Machine::default(),
        "--set and what it needs are options of `package`"
    );
    if command == "build" {
        ensure!(options.binaries.is_empty(), "--binary is an option of `package` and `join`");
        let Platforms(platforms) = options.platforms.context("--platforms is missing")?;
        return Ok(Some(Box::new(move |workspace| build(workspace, &platforms))));
    }
    ensure!(options.platforms.is_some() || !options.binaries.is_empty(), "--platforms or --binary is missing");
    Ok(Some(Box::new(move |workspace| join(workspace, &options))))
}

/// Packs the models of a crate of somebody else: a program that has these options alone.
pub(crate) fn run_of_a_crate(
    arguments: impl IntoIterator<Item = OsString>,
    work: impl FnOnce(&Package) -> Result<()>,
) -> ExitCode {
    let package = Options::read(arguments).and_then(|asked| match asked {
        Asked::Help => Ok(None),
        Asked::Do(options) => options.package().map(Some),
    });
    match package {
        Ok(None) => {
            println!("Build the FMUs of this crate, validate them and run their default experiments.\n\n{PACKAGE}");
            ExitCode::SUCCESS
        }
        Ok(Some(package)) => ended(work(&package)),
        Err(problem) => misspelt(&problem, "--help"),
    }
}

/// Options of the compilation of a loop's module.
#[derive(Debug, PartialEq)]
pub(crate) struct LoopOptions {
    /// Bytes of its stack.
    pub stack: u32,
    /// Features of its crate.
    pub features: Vec<String>,
}

/// Makes sources of a loop of somebody else's crate.
pub(crate) fn run_of_a_loop(
    arguments: impl IntoIterator<Item = OsString>,
    work: impl FnOnce(&LoopOptions) -> Result<()>,
) -> ExitCode {
    match LoopOptions::read(arguments) {
        Ok(None) => {
            println!(
                "Make sources in C of the control loop of this crate.\n\n  \
                 --stack BYTES       of the module, inside the memory of an instance; otherwise {STACK}\n  \
                 --features NAMES    of this crate for the module: those that this program is compiled with"
            );
            ExitCode::SUCCESS
        }
        Ok(Some(options)) => ended(work(&options)),
        Err(problem) => misspelt(&problem, "--help"),
    }
}

/// Bytes of the stack of a loop alone: nearly twice what the built-in laws need.
const STACK: u32 = 32_768;

impl LoopOptions {
    /// Reads a command line, or nothing where its help is asked for.
    fn read(arguments: impl IntoIterator<Item = OsString>) -> Result<Option<Self>> {
        let mut parser = Parser::from_args(arguments);
        let mut options = Self { stack: STACK, features: Vec::new() };
        while let Some(argument) = parser.next()? {
            match argument {
                Short('h') | Long("help") => return Ok(None),
                Long("stack") => {
                    let text = parser.value()?.string()?;
                    let stack = text.parse().with_context(|| format!("--stack {text} is no number of bytes"))?;
                    ensure!(stack % 16 == 0 && stack > 0, "--stack {stack}: it must be a multiple of 16, and not 0");
                    options.stack = stack;
                }
                Long("features") => {
                    options.features.extend(parser.value()?.string()?.split(',').map(str::to_owned));
                }
                other => return Err(other.unexpected().into()),
            }
        }
        Ok(Some(options))
    }
}

/// Leaves the library of each platform below `target/binaries`.
fn build(workspace: &Workspace, platforms: &BTreeSet<Platform>) -> Result<()> {
    for library in library::build(workspace, platforms)? {
        println!("{}", library.keep(workspace)?.display());
    }
    Ok(())
}

/// Takes the libraries that were handed in, and those that `build` left.
fn join(workspace: &Workspace, options: &Options) -> Result<()> {
    let handed_in = library::handed_in(workspace, &options.binaries)?;
    let wanted = options.platforms.iter().flat_map(|Platforms(platforms)| platforms.clone()).collect();
    let kept = |&platform: &Platform| {
        let file = library::kept(workspace, platform);
        let built = Library::read(workspace, &Binary { platform, file });
        built.with_context(|| {
            format!("build it with `cargo xtask build --platforms {platform}` or add `--binary {platform}=PATH`")
        })
    };
    let libraries = library::complete(handed_in, wanted, |missing| missing.iter().map(kept).collect())?;
    package::join(workspace, &libraries)
}

/// Prints the mistake in a command line.
pub fn misspelt(problem: &anyhow::Error, help: &str) -> ExitCode {
    eprintln!("error: {problem:#}\n\nFor more information, try `{help}`.");
    ExitCode::from(2)
}

/// Prints an error.
pub fn ended(outcome: Result<()>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<Asked> {
        Options::read(line.split_whitespace().map(OsString::from))
    }

    #[test]
    fn options_are_read() -> Result<()> {
        let asked = read("--platforms linux64,win64 --binary darwin64=a.dylib --sources=full --model Festoon")?;
        let options = Options {
            platforms: Some("linux64,win64".parse()?),
            binaries: vec!["darwin64=a.dylib".parse()?],
            sources: Some("full".to_owned()),
            model: Some("Festoon".to_owned()),
            ..Options::default()
        };
        assert_eq!(asked, Asked::Do(Box::new(options)));
        let Asked::Do(options) = read("--sources")? else { unreachable!("no help is asked for") };
        assert_eq!(options.sources.as_deref(), Some("small"));
        assert_eq!(read("--help")?, Asked::Help);
        Ok(())
    }

    #[test]
    fn options_of_a_machine_need_its_values() -> Result<()> {
        let package = |line: &str| -> Result<Package> {
            let Asked::Do(options) = read(line)? else { unreachable!("no help is asked for") };
            options.package()
        };
        let machine = Machine {
            file: "my.ssv".into(),
            name: Some("Axis7".to_owned()),
            inputs: Some(vec!["valveVoltage".to_owned(), "supplyPressure".to_owned()]),
            ..Machine::default()
        };
        let line = "--set my.ssv --name Axis7 --inputs valveVoltage,supplyPressure";
        assert_eq!(package(line)?.machine, Some(machine));
        assert_eq!(package("--model Festoon")?.machine, None);
        assert!(package("--name Axis7").is_err_and(|error| error.to_string().contains("--set FILE.ssv")));
        Ok(())
    }

    #[test]
    fn options_of_a_loop_are_read() -> Result<()> {
        let read = |line: &str| LoopOptions::read(line.split_whitespace().map(OsString::from));
        let features = vec!["gms".to_owned(), "trace".to_owned()];
        assert_eq!(read("--stack 8192 --features gms,trace")?, Some(LoopOptions { stack: 8192, features }));
        assert_eq!(read("")?, Some(LoopOptions { stack: STACK, features: Vec::new() }));
        assert_eq!(read("--help")?, None);
        for line in ["--stack many", "--stack 0", "--stack 8", "--heap 3"] {
            assert!(read(line).is_err(), "{line}");
        }
        Ok(())
    }

    #[test]
    fn what_is_wrong_is_named() {
        let problem = |command: &str, line: &str| {
            let planned = read(line).and_then(|asked| planned(command, asked));
            planned.err().map(|problem| format!("{problem:#}")).unwrap_or_default()
        };
        for (command, line, expected) in [
            ("package", "--platform all", "--platform"),
            ("package", "--platforms amiga", "amiga"),
            ("package", "--binary", "--binary"),
            ("package", "linux64", "linux64"),
            ("build", "", "--platforms is missing"),
            ("build", "--platforms all --sources", "--sources is an option of `package`"),
            ("join", "--platforms all --model Festoon", "--model is an option of `package`"),
            ("package", "--model", "--model"),
            ("join", "", "--platforms or --binary is missing"),
        ] {
            assert!(problem(command, line).contains(expected), "{command} {line}: {}", problem(command, line));
        }
        assert_eq!(problem("join", "--platforms all"), "");
    }
}
