//! `cargo xtask`.

use std::process::ExitCode;

fn main() -> ExitCode {
    pneumatic_servo_packaging::xtask(std::env::args_os())
}
