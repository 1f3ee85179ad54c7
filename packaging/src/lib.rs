//! Builds, describes, zips and checks FMUs: those of the project by `cargo xtask`, and those of any other crate by a program of
//! one line in it, [`package_fmus!`].

mod archive;
mod bounds;
mod build;
mod deny;
mod describe;
mod description;
mod docs;
mod documentation;
mod experiment;
mod files;
mod fingerprint;
mod fuzz;
mod gallery;
mod gates;
mod libraries;
mod library;
mod licences;
mod lock;
mod moment;
mod mutants;
mod new;
mod own;
mod package;
mod parameter_sets;
mod platform;
mod platform_test;
mod playground;
mod process;
mod product;
mod public;
mod rehearse;
mod release;
mod sanitizer;
mod site;
mod soundness;
mod sources;
mod sources_test;
mod ssp;
#[cfg(test)]
mod stand_in;
mod stress;
mod tables;
mod test;
mod tools;
mod valgrind;
mod venv;
mod wheel;
mod workspace;

pub use own::{Crate, package};

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use crate::workspace::Workspace;

/// Builds, describes, zips and checks the FMUs.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Begin with `cargo xtask package`: it leaves the FMUs, validated and run once, in target/fmu.
`cargo xtask help COMMAND` tells more and gives examples.";

/// Each command is a file of its own.
#[derive(Subcommand)]
enum Command {
    Package(package::Package),
    Gallery(gallery::Gallery),
    Build(libraries::Build),
    Join(package::Join),
    Release(release::Release),
    Playground(playground::Playground),
    Site(site::Site),
    Describe(describe::Describe),
    Record(valgrind::Record),
    Stress(stress::Stress),
    Bounds(bounds::Bounds),
    Mutants(mutants::Mutants),
    Fuzz(fuzz::Fuzz),
    New(new::New),
    Wheel(wheel::Wheel),
    Docs(docs::Docs),
    Test(test::Test),
}

/// `cargo xtask`: parses the command line, which begins with the name of the program, and does what it says.
pub fn xtask(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    match Arguments::try_parse_from(arguments) {
        Ok(arguments) => ended(run(&arguments.command)),
        Err(told) => not_begun(&told),
    }
}

/// Tells what is wrong with a command line, or the help that it asks for.
fn not_begun(told: &clap::Error) -> ExitCode {
    told.print().ok();
    u8::try_from(told.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from)
}

/// Tells what went wrong.
fn ended(outcome: Result<()>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: &Command) -> Result<()> {
    let workspace = Workspace::of_the_project()?;
    let _alone = lock::hold(&workspace.target)?;
    match command {
        Command::Package(it) => it.run(&workspace),
        Command::Gallery(it) => it.run(&workspace),
        Command::Build(it) => it.run(&workspace),
        Command::Join(it) => it.run(&workspace),
        Command::Release(it) => it.run(&workspace),
        Command::Playground(it) => it.run(&workspace),
        Command::Site(it) => it.run(&workspace),
        Command::Describe(it) => it.run(&workspace),
        Command::Record(it) => it.run(&workspace),
        Command::Docs(it) => it.run(&workspace),
        Command::Stress(it) => it.run(),
        Command::Bounds(it) => it.run(&workspace),
        Command::Mutants(it) => it.run(&workspace),
        Command::Fuzz(it) => it.run(&workspace),
        Command::New(it) => it.run(&workspace),
        Command::Wheel(it) => it.run(&workspace),
        Command::Test(it) => it.run(&workspace),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::stand_in::{self, StandIn};

    /// A command does what it says in the target directory that Cargo names, and its error is that of the program.
    #[test]
    fn a_command_line_is_parsed_and_done() -> Result<()> {
        let folder = files::scratch("xtask");
        let ends = |words: &str| {
            let target = folder.clone();
            let machine = StandIn::new(move |_| Some(stand_in::metadata(&workspace::home(), &target, &[])));
            let code = machine.does(|| xtask(words.split(' ').map(OsString::from))).0;
            format!("{code:?}")
        };
        let code = |code: u8| format!("{:?}", ExitCode::from(code));
        assert_eq!(ends("xtask bounds --recorded"), code(1), "nothing is recorded");
        files::write(&folder.join("tmp/bounds/record"), "tests/a.rs;7;tight;1e-7;1e-6;\n")?;
        assert_eq!(ends("xtask bounds --recorded"), code(0));
        assert_eq!([ends("xtask bonds"), ends("xtask bounds --help")], [code(2), code(0)]);
        Ok(std::fs::remove_dir_all(&folder)?)
    }

    #[test]
    fn every_command_names_itself_as_it_is_typed_and_tells_what_it_does() {
        let mut root = Arguments::command();
        root.build();
        for command in root.get_subcommands_mut().filter(|command| command.get_name() != "help") {
            let help = command.render_long_help().to_string();
            assert!(help.contains(&format!("Usage: cargo xtask {}", command.get_name())), "{help}");
            assert!(command.get_about().is_some(), "{help}");
        }
    }
}
