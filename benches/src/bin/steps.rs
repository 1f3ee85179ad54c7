//! Runs communication steps of 1 ms with a fresh input: `steps <law> <number> [<parameter>=<value> ...]`, for a profiler
//! that counts instructions.

use std::env;
use std::process::ExitCode;

use benchmark::case::{Case, STEP, voltage};
use benchmark::host::Host;

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [law, number, changes @ ..] = arguments.as_slice() else { return usage("two arguments are expected") };
    let Some(mut case) = Case::of(law) else { return usage(&format!("{law} is no friction law")) };
    let Ok(number) = number.parse::<u32>() else { return usage(&format!("{number} is no number of steps")) };
    for change in changes {
        let parts = change.split_once('=').and_then(|(name, value)| Some((name, value.parse().ok()?)));
        let Some((name, value)) = parts else { return usage(&format!("{change} is no change of a parameter")) };
        case = case.with(name, value);
    }
    let mut host = Host::start(&case, 1e-6);
    for index in 0..number {
        host.step(voltage(f64::from(index) * STEP), STEP);
    }
    ExitCode::SUCCESS
}

fn usage(problem: &str) -> ExitCode {
    eprintln!("{problem}; usage: steps <law> <number> [<parameter>=<value> ...]");
    ExitCode::from(2)
}
