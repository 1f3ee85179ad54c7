//! `cargo xtask`: builds, describes, zips and checks the FMUs.

mod archive;
mod build;
mod describe;
mod description;
mod documentation;
mod gates;
mod library;
mod licences;
mod moment;
mod package;
mod parameter_sets;
mod platform;
mod platform_test;
mod process;
mod ssp;
mod tables;
mod test;
mod valgrind;
mod venv;
mod workspace;
mod xml;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::platform::{Binary, Platforms};
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
    Package {
        /// What the FMUs run on: `linux64,win64,darwin64` or `all`; otherwise machines like this one.
        #[arg(long)]
        platforms: Option<Platforms>,
        /// A library that was built elsewhere, taken instead of building one.
        #[arg(long = "binary", value_name = "PLATFORM=PATH")]
        binaries: Vec<Binary>,
    },
    /// Build the shared libraries, the first half of `package`; they are left in target/binaries.
    Build {
        /// `linux64,win64,darwin64` or `all`.
        #[arg(long)]
        platforms: Platforms,
    },
    /// Put shared libraries that are built into the FMUs, the second half of `package`.
    Join {
        /// Platforms whose libraries are in target/binaries: `linux64,win64,darwin64` or `all`.
        #[arg(long, required_unless_present = "binaries")]
        platforms: Option<Platforms>,
        /// A library that was built elsewhere.
        #[arg(long = "binary", value_name = "PLATFORM=PATH")]
        binaries: Vec<Binary>,
    },
    /// Rewrite the XML below modelDescription and the tables of README and docs from the variable tables.
    Describe,
    /// Record the instruction counts of a communication step, which the checks compare with.
    Record,
    /// Run every check: format, lints, unit tests, C-interface tests, real FMI clients and other platforms.
    Test {
        /// Only build and compare the libraries of all platforms; a missing tool is an error then.
        #[arg(long)]
        platforms: bool,
    },
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let outcome = Workspace::find().and_then(|workspace| match arguments.command {
        Command::Package { platforms, binaries } => package::run(&workspace, platforms.as_ref(), &binaries),
        Command::Build { platforms: Platforms(platforms) } => build::run(&workspace, &platforms),
        Command::Join { platforms, binaries } => package::join_built(&workspace, platforms.as_ref(), &binaries),
        Command::Describe => describe::run(&workspace),
        Command::Record => valgrind::record_instructions(&workspace),
        Command::Test { platforms: true } => platform_test::run(&workspace),
        Command::Test { platforms: false } => test::run(&workspace),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
