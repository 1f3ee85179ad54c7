//! Checks under the address sanitizer of the nightly compiler: like valgrind, it finds what is read or written outside of
//! its place; unlike valgrind, it sees places on the stack and between variables, and is quick enough for almost all tests.

use std::process::Command;

use anyhow::Result;

use crate::process::{self, heading};
use crate::workspace::Workspace;

/// Runs tests of the C interface, with the plant and the library, under the sanitizer, where there is a nightly
/// compiler. Where there is none this says so and is no error: valgrind looks for the same mistakes.
///
/// # Errors
/// When it finds something or a test fails.
pub fn check(workspace: &Workspace) -> Result<()> {
    /// They repeat for all laws what others do for some, which takes longer than all others; what could go wrong with
    /// memory is in the C faces, which are the same for all laws.
    const LONG: [&str; 2] = ["for_all_models_and_laws", "in_every_model_for_every_law"];
    heading("C interface under the address sanitizer");
    let Some(host) = nightly_host() else {
        println!("left out: it needs Linux and a nightly compiler (rustup toolchain install nightly)");
        println!("valgrind, where it is installed, has run all but the longest of these tests; under CI it must be");
        return Ok(());
    };
    let mut rustup = nightly("cargo");
    rustup.args(["test", "--package", "pneumatic-servo-fmu", "--test", "c_interface", "--test", "fuzz"]);
    // With a target named, programs that run while building are left alone.
    rustup.args(["--target", &host]).current_dir(&workspace.root);
    rustup.arg("--").args(LONG.into_iter().flat_map(|name| ["--skip", name]));
    rustup.env("CARGO_TARGET_DIR", workspace.target.join("sanitizer"));
    // The sanitizer's own functions are in the tests, and the library that they load looks for them there.
    rustup.env("RUSTFLAGS", "-Zsanitizer=address -Clink-arg=-rdynamic");
    process::run(&mut rustup)
}

/// The machine that a nightly compiler is for, if there is one and the sanitizer knows this system.
fn nightly_host() -> Option<String> {
    let answer = process::caught(nightly("rustc").arg("-vV")).ok().filter(|answer| answer.status.success())?;
    let text = String::from_utf8(answer.stdout).ok()?;
    let host = text.lines().find_map(|line| line.strip_prefix("host: "))?;
    cfg!(target_os = "linux").then(|| host.to_owned())
}

fn nightly(program: &str) -> Command {
    let mut rustup = Command::new("rustup");
    rustup.args(["run", "nightly", program]);
    rustup
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;
    use crate::stand_in::{Answer, StandIn};

    /// For the machine that the compiler names; without such a compiler nothing is run.
    #[test]
    fn tests_are_run_under_the_sanitizer_of_a_nightly_compiler() {
        let workspace = Workspace::of_a_test("/target".as_ref());
        let machine = |answer: fn() -> Answer| {
            let machine = StandIn::new(move |command| command.says("rustc -vV").then(answer));
            machine.does(|| check(&workspace))
        };
        let (outcome, started) = machine(|| Answer::Prints("rustc 1\nhost: a-machine\n".to_owned()));
        let tests = started.last().filter(|_| outcome.is_ok()).expect("tests");
        assert!(tests.says("rustup run nightly cargo test") && tests.says("--target a-machine --"), "{tests:?}");
        assert!(tests.variable("RUSTFLAGS").contains("-Zsanitizer=address"), "{tests:?}");
        assert_eq!(tests.variable("CARGO_TARGET_DIR"), "/target/sanitizer");
        let (outcome, started) = machine(|| Answer::Fails);
        assert!(outcome.is_ok() && started.len() == 1, "{started:?}");
    }
}
