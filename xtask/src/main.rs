//! `cargo xtask`: packs the FMUs and begins crates. All other commands are programs of `xtask-developer`, which is compiled
//! when one of them is asked for.

use std::ffi::OsString;
use std::process::ExitCode;

use pneumatic_servo_packaging::{commands, process};

fn main() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    let name = words.first().and_then(|word| word.to_str()).unwrap_or_default();
    let is_small = !words.iter().any(|word| word.to_string_lossy().starts_with("--sources"));
    match name {
        "new" => xtask::new::run(&words[1..]),
        _ if commands::NAMES.contains(&name) && is_small => commands::run(name, words[1..].iter().cloned()),
        _ => developer(&words),
    }
}

/// Does a command of developers.
fn developer(words: &[OsString]) -> ExitCode {
    let mut cargo = process::cargo();
    cargo.args(["run", "--config", "term.progress.when='always'", "--config", "term.progress.width=80"]);
    cargo.args(["--profile", "quick", "--package", "xtask-developer", "--"]).args(words);
    // Output and exit code are the command's own.
    match cargo.status() {
        Ok(status) => status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from),
        Err(problem) => commands::ended(Err(anyhow::Error::from(problem).context("cannot start Cargo"))),
    }
}
