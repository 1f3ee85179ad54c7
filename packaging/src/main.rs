//! `cargo xtask`: builds, describes, zips and checks the FMUs.

mod archive;
mod describe;
mod description;
mod documentation;
mod library;
mod licences;
mod moment;
mod package;
mod parameter_sets;
mod platform;
mod process;
mod readme;
mod ssp;
mod test;
mod valgrind;
mod venv;
mod workspace;
mod xml;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::workspace::Workspace;

/// Builds, describes, zips and checks the FMUs.
#[derive(Parser)]
#[command(name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build every FMU, validate it, run its default experiment and draw the figures.
    Package,
    /// Rewrite the XML below modelDescription and the tables of the README from the variable tables.
    Describe,
    /// Record the instruction counts of a communication step, which the checks compare with.
    Record,
    /// Run every check: format, lints, unit tests, C-interface tests and real FMI clients.
    Test,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let outcome = Workspace::find().and_then(|workspace| match arguments.command {
        Command::Package => package::run(&workspace),
        Command::Describe => describe::run(&workspace),
        Command::Record => valgrind::record_instructions(&workspace),
        Command::Test => test::run(&workspace),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
