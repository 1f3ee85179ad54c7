//! Checks under the address sanitizer of the nightly compiler: like valgrind, it finds reads and writes outside of
//! its place; unlike valgrind, it sees places on the stack and between variables, and is quick enough for almost all tests.

use std::process::Command;

use anyhow::{Context, Result};
use pneumatic_servo_packaging::process::{self, heading};
use pneumatic_servo_packaging::workspace::Workspace;

/// Runs tests of the C interface, with the plant and the library, under the sanitizer.
///
/// # Errors
/// When there is no nightly compiler, it finds something, or a test fails.
pub fn run(workspace: &Workspace) -> Result<()> {
    /// Long tests that repeat for all laws what others do for some; memory errors can only be in the C interfaces, which
    /// are the same for all laws.
    const LONG: [&str; 2] = ["for_all_models_and_laws", "in_every_model_for_every_law"];
    heading("C interface under the address sanitizer");
    let host = nightly_host().context("it needs Linux and a nightly compiler (rustup toolchain install nightly)")?;
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
