//! The commands of `cargo xtask` that only developers need: what packs FMUs is in `packaging`, and compiled without them.

mod deny;
mod describe;
mod fuzz;
mod platform_test;
mod playground;
mod release;
mod sanitizer;
mod site;
mod sources_test;
mod tables;
mod test;
mod valgrind;
mod wheel;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use pneumatic_servo_packaging::workspace::Workspace;
use pneumatic_servo_packaging::{commands, lock};

/// The features of the plant that `cargo xtask` is compiled with: what has the same finds it compiled in `target/quick`.
const FEATURES: [&str; 2] = ["--features", "pneumatic-servo/all-models,pneumatic-servo/sensitivities"];

/// Builds, describes, zips and checks the FMUs.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Besides, each with `--help` of its own:
  package     Build the FMUs and the SSP, validate them and run the default experiments
  build       Build the shared libraries, the first half of `package`
  join        Put shared libraries into the FMUs, the second half of `package`
  new         Begin a crate of one's own with a law, a valve or a model

Begin with `cargo xtask package`: it leaves the FMUs, validated and run once, in target/fmu.
`cargo xtask help COMMAND` tells more and gives examples.";

/// Each command is a file of its own.
#[derive(Subcommand)]
enum Command {
    Wheel(wheel::Wheel),
    Playground(playground::Playground),
    Site(site::Site),
    Release(release::Release),
    Describe(describe::Describe),
    Record(valgrind::Record),
    Fuzz(fuzz::Fuzz),
    Test(test::Test),
}

fn main() -> ExitCode {
    let mut words = std::env::args_os().skip(1);
    // With sources in C, which the small program cannot make.
    if let Some(name) = words.next().and_then(|word| word.into_string().ok())
        && commands::NAMES.contains(&&*name)
    {
        return commands::run(&name, words);
    }
    commands::ended(run(&Arguments::parse().command))
}

fn run(command: &Command) -> Result<()> {
    let workspace = Workspace::of_the_project()?;
    let _alone = lock::hold(&workspace.target)?;
    match command {
        Command::Wheel(it) => it.run(&workspace),
        Command::Playground(it) => it.run(&workspace),
        Command::Site(it) => it.run(&workspace),
        Command::Release(it) => it.run(&workspace),
        Command::Describe(it) => it.run(&workspace),
        Command::Record(it) => it.run(&workspace),
        Command::Fuzz(it) => it.run(&workspace),
        Command::Test(it) => it.run(&workspace),
    }
}
