//! Runs communication steps of 1 ms with a fresh input: `steps <law> <number>`, for a profiler that counts instructions.

use std::env;
use std::process::ExitCode;

use benchmark::case::{Case, STEP, voltage};
use benchmark::host::Host;

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [law, number] = arguments.as_slice() else { return usage("two arguments are expected") };
    let Some(case) = Case::of(law) else { return usage(&format!("{law} is no friction law")) };
    let Ok(number) = number.parse::<u32>() else { return usage(&format!("{number} is no number of steps")) };
    let mut host = Host::start(&case, 1e-6);
    for index in 0..number {
        host.step(voltage(f64::from(index) * STEP), STEP);
    }
    ExitCode::SUCCESS
}

fn usage(problem: &str) -> ExitCode {
    eprintln!("{problem}; usage: steps <law> <number>");
    ExitCode::from(2)
}
