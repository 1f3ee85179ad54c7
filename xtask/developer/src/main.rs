//! The commands of `cargo xtask` for developers only; packing FMUs is in `packaging`, and compiled without them.

mod badges;
mod deny;
mod describe;
mod fuzz;
mod platform_test;
mod playground;
mod quick;
mod release;
mod sanitizer;
mod site;
mod sources_test;
mod tables;
mod test;
mod valgrind;
mod wheel;

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::{Context, Result};
use lexopt::Arg::{Long, Short};
use lexopt::Parser;
use pneumatic_servo_packaging::workspace::Workspace;
use pneumatic_servo_packaging::{commands, lock};

/// Work of a command in the repository.
type Work = Box<dyn FnOnce(&Workspace) -> Result<()>>;

/// A command.
struct Command {
    name: &'static str,
    /// Its help, whose first line stands in the list of commands.
    help: &'static str,
    /// Reads its options; nothing where the help is asked for.
    read: fn(Parser) -> Result<Option<Work>>,
}

/// Each is a file of its own.
const COMMANDS: [Command; 8] = [
    Command { name: "wheel", help: wheel::HELP, read: |line| without_options(line, wheel::run) },
    Command { name: "playground", help: playground::HELP, read: |line| without_options(line, playground::run) },
    Command { name: "site", help: site::HELP, read: site::read },
    Command { name: "release", help: release::HELP, read: release::read },
    Command { name: "describe", help: describe::HELP, read: |line| without_options(line, describe::run) },
    Command { name: "record", help: valgrind::HELP, read: |line| without_options(line, valgrind::record) },
    Command { name: "fuzz", help: fuzz::HELP, read: fuzz::read },
    Command { name: "test", help: test::HELP, read: test::read },
];

/// Commands of other programs, in the list of all.
const OTHERS: [(&str, &str); 4] = [
    ("package", "Build the FMUs and the SSP, validate them and run the default experiments."),
    ("build", "Build the shared libraries, the first half of `package`."),
    ("join", "Put shared libraries into the FMUs, the second half of `package`."),
    ("new", "Begin a crate of your own with a law, a valve or a model."),
];

fn main() -> ExitCode {
    let mut words: Vec<OsString> = std::env::args_os().skip(1).collect();
    if words.first().is_some_and(|word| word == "help") {
        words.remove(0);
        words.push("--help".into());
    }
    let name = words.first().and_then(|word| word.to_str()).unwrap_or("--help").to_owned();
    let options = words.into_iter().skip(1);
    // With sources in C, which the small program cannot make.
    if commands::NAMES.contains(&&*name) {
        return commands::run(&name, options);
    }
    if ["--help", "-h"].contains(&&*name) {
        print_commands();
        return ExitCode::SUCCESS;
    }
    match read(&name, options) {
        Ok((_, Some(work))) => commands::ended(alone(work)),
        Ok((help, None)) => {
            println!("{help}");
            ExitCode::SUCCESS
        }
        Err(problem) => commands::misspelt(&problem, "cargo xtask --help"),
    }
}

fn print_commands() {
    println!("Usage: cargo xtask COMMAND [OPTIONS]\n");
    let own = COMMANDS.iter().map(|command| (command.name, command.help.lines().next().unwrap_or_default()));
    for (name, text) in OTHERS.into_iter().chain(own) {
        println!("  {name:<12}{text}");
    }
    println!("\nBegin with `cargo xtask package`. `cargo xtask COMMAND --help` tells more and gives examples.");
}

/// The help of a command, and what it is to do unless the help is asked for.
fn read(name: &str, options: impl Iterator<Item = OsString>) -> Result<(&'static str, Option<Work>)> {
    let command = COMMANDS.iter().find(|command| command.name == name);
    let command = command.with_context(|| format!("there is no command `{name}`"))?;
    Ok((command.help, (command.read)(Parser::from_args(options))?))
}

/// Reads the line of a command without options.
fn without_options(mut line: Parser, work: fn(&Workspace) -> Result<()>) -> Result<Option<Work>> {
    match line.next()? {
        None => Ok(Some(Box::new(work))),
        Some(Short('h') | Long("help")) => Ok(None),
        Some(other) => Err(other.unexpected().into()),
    }
}

/// Does it once no other command works in the target directory.
fn alone(work: Work) -> Result<()> {
    let workspace = Workspace::of_the_project()?;
    let _alone = lock::hold(&workspace.target)?;
    work(&workspace)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(line: &str) -> String {
        let mut words = line.split(' ').map(OsString::from);
        let name = words.next().and_then(|word| word.into_string().ok()).unwrap_or_default();
        match read(&name, words) {
            Ok((_, Some(_))) => "work".to_owned(),
            Ok((help, None)) => help.to_owned(),
            Err(problem) => format!("{problem:#}"),
        }
    }

    #[test]
    fn command_lines_are_read_or_refused_by_the_word_that_is_wrong() {
        for line in [
            "test",
            "test --times --platforms",
            "test --sources --only cortex-m7,s390x --fuzz 10",
            "fuzz",
            "fuzz --minutes 1 forged_states readers",
            "fuzz --keep co_simulation",
            "release --binary win64=plant.dll --binary darwin64=plant.dylib",
            "site --keep-gallery",
            "wheel",
        ] {
            assert_eq!(outcome(line), "work", "{line}");
        }
        for (line, expected) in [
            ("paint", "`paint`"),
            ("wheel --fast", "--fast"),
            ("test --platforms --sources", "--platforms"),
            ("test --sanitizer --sources", "--sanitizer"),
            ("test --only cortex-m7", "--sources"),
            ("test --sources --fuzz 0", "--fuzz"),
            ("fuzz --minutes few", "--minutes"),
            ("release --binary amiga", "--binary amiga"),
            ("describe now", "now"),
        ] {
            assert!(outcome(line).contains(expected), "{line}: {}", outcome(line));
        }
        for command in COMMANDS {
            assert_eq!(outcome(&format!("{} --help", command.name)), command.help);
        }
    }
}
